#ifndef PINCH_COMPARE_WHOLE_FILE_H
#define PINCH_COMPARE_WHOLE_FILE_H

#include <stdbool.h>
#include <stdio.h>

/* A file that is there as a whole or not at all: written beside its place and moved there at the end. A device or pipe
 * is written to directly. */
typedef struct whole_file {
    FILE *stream; /* to write to */
    char *path, *beside;
} whole_file;

/* false: cannot be written. */
bool whole_file_open(whole_file *file, const char *path);
/* Moves the file to its place, or takes it away where something could not be written or `keep` is false. */
bool whole_file_close(whole_file *file, bool keep);

#endif
