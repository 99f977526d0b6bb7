#define _XOPEN_SOURCE 700

#include "whole_file.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* A pipe that nobody reads would block for ever. Its reader may be starting, and is waited for a little. */
static FILE *open_special(const char *path)
{
    enum { TRIES = 100 };
    const struct timespec pause = {.tv_nsec = 10000000};
    int descriptor = open(path, O_WRONLY | O_NONBLOCK | O_CLOEXEC | O_TRUNC);
    for (int try = 0; descriptor < 0 && errno == ENXIO && try < TRIES; try++) {
        nanosleep(&pause, NULL);
        descriptor = open(path, O_WRONLY | O_NONBLOCK | O_CLOEXEC | O_TRUNC);
    }
    int flags = descriptor < 0 ? -1 : fcntl(descriptor, F_GETFL);
    FILE *stream = flags >= 0 && fcntl(descriptor, F_SETFL, flags & ~O_NONBLOCK) == 0 ? fdopen(descriptor, "w") : NULL;
    int error = errno;
    if (!stream && descriptor >= 0) close(descriptor);
    errno = error;
    return stream;
}

static bool is_special(const char *path)
{
    struct stat about;
    return stat(path, &about) == 0 && !S_ISREG(about.st_mode);
}

/* The names of files that are being written. A process that ends before they are complete removes them. */
enum { MOST_UNFINISHED = 16 };
static const char *unfinished[MOST_UNFINISHED];
static pid_t owner; /* a child process leaves them alone */

static void remove_unfinished(void)
{
    for (int i = 0; i < MOST_UNFINISHED && owner == getpid(); i++)
        if (unfinished[i]) (void)unlink(unfinished[i]);
}

/* unlink may be called from a signal handler. The signal then ends the process as it would have. */
static void remove_and_end(int number)
{
    remove_unfinished();
    signal(number, SIG_DFL);
    raise(number);
}

static void note_unfinished(const char *path)
{
    static const int signals[] = {SIGHUP, SIGINT, SIGTERM};
    if (owner != getpid()) {
        owner = getpid();
        (void)atexit(remove_unfinished);
        for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) {
            struct sigaction before;
            if (sigaction(signals[i], NULL, &before) == 0 && before.sa_handler == SIG_DFL)
                signal(signals[i], remove_and_end);
        }
    }
    for (int i = 0; i < MOST_UNFINISHED; i++)
        if (!unfinished[i]) {
            unfinished[i] = path;
            return;
        }
}

static void forget_unfinished(const char *path)
{
    for (int i = 0; i < MOST_UNFINISHED; i++)
        if (unfinished[i] == path) unfinished[i] = NULL;
}

/* mkstemp makes files for their owner alone; this one gets the mode that fopen would give it. */
static FILE *open_beside(char *path)
{
    int descriptor = mkstemp(path);
    if (descriptor < 0) return NULL;
    mode_t mask = umask(0);
    umask(mask);
    if (fchmod(descriptor, 0666 & ~mask) == 0) {
        FILE *stream = fdopen(descriptor, "w");
        if (stream) return stream;
    }
    int error = errno;
    close(descriptor);
    remove(path);
    errno = error;
    return NULL;
}

static char *copy_of(const char *path)
{
    char *real = realpath(path, NULL);
    return real ? real : strdup(path);
}

bool whole_file_open(whole_file *file, const char *path)
{
    memset(file, 0, sizeof *file);
    if (is_special(path)) {
        file->stream = open_special(path);
        return file->stream != NULL;
    }
    file->path = copy_of(path);
    if (!file->path) return false;
    size_t length = strlen(file->path);
    file->beside = malloc(length + 8);
    if (file->beside) {
        memcpy(file->beside, file->path, length);
        memcpy(file->beside + length, ".XXXXXX", 8);
        file->stream = open_beside(file->beside);
        if (file->stream) note_unfinished(file->beside);
    }
    if (file->stream) return true;
    int error = errno;
    free(file->path);
    free(file->beside);
    errno = error;
    return false;
}

bool whole_file_can_be_written(const char *path)
{
    struct stat about;
    whole_file file;
    if (stat(path, &about) == 0 && !S_ISREG(about.st_mode)) {
        if (!S_ISDIR(about.st_mode)) return access(path, W_OK) == 0;
        errno = EISDIR;
        return false;
    }
    if (!whole_file_open(&file, path)) return false;
    (void)whole_file_close(&file, false);
    return true;
}

/* What errno said when an earlier write failed may have been overwritten since. What was in the way is so mostly still,
 * and stops one more write; 0 where it does not. */
static int reason_now(int descriptor)
{
    static const char block[4096];
    return write(descriptor, block, sizeof block) < 0 ? errno : 0;
}

bool whole_file_close(whole_file *file, bool keep)
{
    bool written = !ferror(file->stream);
    int error = !written && file->beside ? reason_now(fileno(file->stream)) : 0;
    if (fclose(file->stream) != 0) {
        if (written) error = errno;
        written = false;
    }
    if (file->beside) {
        if (written && keep) {
            written = rename(file->beside, file->path) == 0;
            error = errno;
        }
        if (!written || !keep) remove(file->beside);
        forget_unfinished(file->beside);
    }
    free(file->path);
    free(file->beside);
    errno = error;
    return written;
}
