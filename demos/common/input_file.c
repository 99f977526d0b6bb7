#define _POSIX_C_SOURCE 200809L

#include "input_file.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FAULT = 128 };

/* O_NONBLOCK lets a pipe be opened, so that it can be refused. */
FILE *input_open_regular(const char *path, char *fault)
{
    struct stat status;
    FILE *stream = NULL;
    int descriptor = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    *fault = '\0';
    if (descriptor >= 0 && fstat(descriptor, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode)) {
        snprintf(fault, FAULT, "This is no regular file, but a pipe or a device");
    } else {
        if (descriptor >= 0 && S_ISDIR(status.st_mode))
            errno = EISDIR;
        else if (descriptor >= 0)
            stream = fdopen(descriptor, "rb");
        if (!stream && errno != ENOMEM) snprintf(fault, FAULT, "%s", strerror(errno));
    }
    if (!stream && descriptor >= 0) close(descriptor);
    return stream;
}

/* A pipe that nobody writes would block for ever. Its writer may be starting, and is waited for a little. */
FILE *input_open(const char *path)
{
    enum { PATIENCE = 1000 }; /* ms */
    int descriptor = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    struct stat about = {.st_mode = 0};
    struct pollfd pipe = {.fd = descriptor, .events = POLLIN};
    if (descriptor >= 0 && fstat(descriptor, &about) == 0 && S_ISFIFO(about.st_mode)) (void)poll(&pipe, 1, PATIENCE);
    if (descriptor >= 0 && S_ISDIR(about.st_mode)) {
        close(descriptor);
        errno = EISDIR;
        return NULL;
    }
    int flags = descriptor < 0 ? -1 : fcntl(descriptor, F_GETFL);
    FILE *stream = flags >= 0 && fcntl(descriptor, F_SETFL, flags & ~O_NONBLOCK) == 0 ? fdopen(descriptor, "rb") : NULL;
    int error = errno;
    if (!stream && descriptor >= 0) close(descriptor);
    errno = error;
    return stream;
}

input_status input_read(FILE *stream, size_t most, char **text, size_t *length, char *fault)
{
    input_status status = INPUT_READ;
    size_t room = 0, got = 1;
    *text = NULL;
    *length = 0;
    while (got > 0 && *length <= most) {
        if (*length + 1 >= room) {
            room = room ? 2 * room : (size_t)1 << 16;
            char *larger = realloc(*text, room);
            if (!larger) {
                status = INPUT_NO_MEMORY;
                break;
            }
            *text = larger;
        }
        got = fread(*text + *length, 1, room - 1 - *length, stream);
        *length += got;
    }
    if (status == INPUT_READ && ferror(stream)) {
        status = INPUT_REFUSED;
        snprintf(fault, FAULT, "%s", strerror(errno));
    } else if (status == INPUT_READ && *length > most) {
        status = INPUT_REFUSED;
        snprintf(fault, FAULT, "It has more than %zu MiB", most >> 20);
    }
    fclose(stream);
    if (status == INPUT_READ) {
        (*text)[*length] = '\0';
    } else {
        free(*text);
        *text = NULL;
    }
    return status;
}

/* No JSON document begins with the first byte of the mark: what it takes with it was none. */
static void skip_byte_order_mark(FILE *stream)
{
    enum { FIRST_OF_MARK = 0xEF, OTHERS = 2 };
    int first = getc(stream);
    if (first != FIRST_OF_MARK) {
        ungetc(first, stream); /* does nothing at the end */
        return;
    }
    for (int k = 0; k < OTHERS; k++) (void)getc(stream);
}

json_t *input_load_json(FILE *stream, json_error_t *error)
{
    skip_byte_order_mark(stream);
    return json_loadf(stream, JSON_REJECT_DUPLICATES, error);
}

const char *input_json_fault(const json_error_t *error)
{
    /* The library's own words name a setting of its, which nobody can make in a file. */
    enum json_error_code code = json_error_code(error);
    bool zero = code == json_error_null_character || code == json_error_null_byte_in_key;
    return zero ? "the character \\u0000 may not stand in a text or a key" : error->text;
}
