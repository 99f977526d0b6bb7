#ifndef PINCH_COMMON_OWN_PLACE_H
#define PINCH_COMMON_OWN_PLACE_H

#include <stdbool.h>
#include <stddef.h>

/* What belongs to the command is found from the place of its own file: in the build tree, or in an installation, which
 * may have been moved. */

/* Writes the absolute path of the first of `places` that is there. They are relative to the folder of the running
 * program; NULL is the last. Returns false where there is none, or the path has no room. */
bool own_place_find(const char *const *places, char *path, size_t size);

/* Writes the absolute path of a file or folder of the data that the command comes with, "scenes/paper" for example.
 * Returns false where it is not there. */
bool own_place_data(const char *name, char *path, size_t size);

#endif
