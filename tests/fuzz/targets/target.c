#define _GNU_SOURCE /* memfd_create */

#include "target.h"

#include <fcntl.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

void target_found(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("finding: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    abort();
}

const char *target_file(const uint8_t *data, size_t size)
{
    static int descriptor = -1;
    static char path[64];
    if (descriptor < 0) {
        descriptor = memfd_create("input", 0);
        snprintf(path, sizeof path, "/proc/self/fd/%d", descriptor);
    }
    /* Its page stays where the old end is cut off after the new bytes are there: that takes half the time. */
    if (descriptor < 0 || pwrite(descriptor, data, size, 0) != (ssize_t)size || ftruncate(descriptor, (off_t)size) != 0)
        target_found("no file in memory");
    return path;
}

const char *target_file_in(const char *folder, const uint8_t *data, size_t size)
{
    static int descriptor = -1;
    static char path[4096];
    if (descriptor < 0) {
        snprintf(path, sizeof path, "%s/input-%d", folder, (int)getpid());
        descriptor = open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    }
    if (descriptor < 0 || ftruncate(descriptor, 0) != 0 || pwrite(descriptor, data, size, 0) != (ssize_t)size)
        target_found("%s cannot be written", path);
    return path;
}

/* glibc's stderr is a variable. What sanitizers report does not go through it. */
static FILE *ears, *terminal;
static char *words;
static size_t length;

void target_listen(void)
{
    terminal = stderr;
    ears = open_memstream(&words, &length);
    if (!ears) target_found("no memory");
    stderr = ears;
}

void target_heard(bool wrong)
{
    stderr = terminal;
    fclose(ears);
    if (!wrong && length > 0) target_found("an unexpected message: \"%s\"", words);
    if (wrong && (length < 2 || words[length - 1] != '\n')) target_found("no message: \"%s\"", words);
    if (wrong) words[length - 1] = 0;
    if (wrong) target_check_message(words);
    free(words);
}

void target_check_message(const char *text)
{
    if (!*text || strchr(text, '\n')) target_found("no message of one line: \"%s\"", text);
}

unsigned target_byte(target_bytes *b)
{
    if (b->left == 0) return 0;
    b->left--;
    return *b->at++;
}

int target_iterations(target_bytes *b)
{
#ifdef PINCH_FUZZ
    return target_byte(b) < 240 ? 40 : 300;
#else
    (void)b;
    return 300;
#endif
}

double target_number(target_bytes *b)
{
    static const double odd[16] = {0,      -0.0,   1,   -1,       1e-12,     1e12, -1e12, 1e300,
                                   1e-300, -1e300, NAN, INFINITY, -INFINITY, 1e-6, 1e6,   0.5};
    unsigned kind = target_byte(b);
    if (kind >= 240) return odd[kind - 240];
    double sign = target_byte(b) & 1 ? -1 : 1, digits = 1 + target_byte(b) / 256.0;
    return sign * digits * pow(10, (int)(kind % 7) - 3);
}
