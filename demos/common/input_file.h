#ifndef PINCH_COMMON_INPUT_FILE_H
#define PINCH_COMMON_INPUT_FILE_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef enum input_status { INPUT_READ = 0, INPUT_REFUSED, INPUT_NO_MEMORY } input_status;

/* Opens a file that a document names. A document may come from anybody, so that only a regular file is opened: a pipe
 * without a writer would block for ever, and a device may never end. NULL: `fault` (128 bytes) says why, or is empty
 * where memory ran out. */
FILE *input_open_regular(const char *path, char *fault);

/* Opens a file that the command line names, which may be a pipe: one that nobody writes to is at its end and does not
 * block. NULL as fopen returns it, with errno, and of a directory, too. */
FILE *input_open(const char *path);

/* Reads the rest of `stream`, at most `most` bytes, and closes it. `text` is followed by a zero byte and is the
 * caller's to free. It reads until the end and not by size, because a document may come out of a pipe. */
input_status input_read(FILE *stream, size_t most, char **text, size_t *length, char *fault);

/* Reads a JSON document from the beginning of `stream`, without the byte order mark that some editors write before it;
 * a key must not come twice. Returns NULL where there is none. */
json_t *input_load_json(FILE *stream, json_error_t *error);

/* What is wrong with a JSON document that could not be read, in the terms of its file. It lives as long as `error`. */
const char *input_json_fault(const json_error_t *error);

#endif
