#ifndef PINCH_PIPE_H
#define PINCH_PIPE_H

#include <stdbool.h>
#include <stddef.h>

/* What two processes pass to each other through a pipe. Both calls go on where a signal interrupts them. */

/* Writes all `size` bytes; false where that fails. */
bool pipe_send(int to, const void *data, size_t size);

/* Reads exactly `size` bytes; false where that fails or where the other end closes before. */
bool pipe_receive(int from, void *data, size_t size);

#endif
