#ifndef PINCH_COMPARE_WHOLE_FILE_H
#define PINCH_COMPARE_WHOLE_FILE_H

#include <stdbool.h>
#include <stdio.h>

/* A file that is there as a whole or not at all: it is written beside its place and moved there at the end. A device or
 * a pipe is written to directly. Of a link, the file behind it is replaced. */
typedef struct whole_file {
    FILE *stream; /* write to this */
    char *path, *beside;
} whole_file;

/* Returns false, with the reason in errno, where the file cannot be written. */
bool whole_file_open(whole_file *file, const char *path);
/* Moves the file to its place. Removes it instead where something could not be written or `keep` is false. Returns
 * false where it could not be written, with the reason in errno, or 0 there where it is not known. */
bool whole_file_close(whole_file *file, bool keep);

/* Could the file be written now? What is there stays. A device or a pipe is not opened, as its reader would see an end.
 * Returns false with the reason in errno. */
bool whole_file_can_be_written(const char *path);

#endif
