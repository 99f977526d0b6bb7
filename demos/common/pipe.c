#define _POSIX_C_SOURCE 200809L

#include "common/pipe.h"

#include <errno.h>
#include <unistd.h>

bool pipe_send(int to, const void *data, size_t size)
{
    for (const char *at = data; size > 0;) {
        ssize_t sent = write(to, at, size);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) return false;
        at += sent;
        size -= (size_t)sent;
    }
    return true;
}

bool pipe_receive(int from, void *data, size_t size)
{
    for (char *at = data; size > 0;) {
        ssize_t got = read(from, at, size);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        at += got;
        size -= (size_t)got;
    }
    return true;
}
