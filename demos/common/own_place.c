#define _XOPEN_SOURCE 700

#include "own_place.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST_PATH = 4000 };

bool own_place_find(const char *const *places, char *path, size_t size)
{
    char own[MOST_PATH];
    ssize_t length = readlink("/proc/self/exe", own, sizeof own - 1);
    if (length < 0) return false;
    own[length] = '\0';
    char *end = strrchr(own, '/');
    if (end) *end = '\0';
    for (; *places; places++) {
        char place[MOST_PATH + 512];
        snprintf(place, sizeof place, "%s/%s", own, *places);
        char *real = realpath(place, NULL);
        bool fits = real && strlen(real) < size;
        if (fits) strcpy(path, real);
        free(real);
        if (fits) return true;
    }
    return false;
}

bool own_place_data(const char *name, char *path, size_t size)
{
    /* in an installation, and in the build tree */
    static const char *const folders[] = {PINCH_DATA_FROM_COMMAND, "share/pinch"};
    char place[2][512];
    for (int i = 0; i < 2; i++) snprintf(place[i], sizeof place[i], "%s/%s", folders[i], name);
    return own_place_find((const char *const[]){place[0], place[1], NULL}, path, size);
}
