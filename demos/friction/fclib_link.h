#ifndef PINCH_FRICTION_FCLIB_LINK_H
#define PINCH_FRICTION_FCLIB_LINK_H

#include <stdbool.h>

/*
 * What the module libpinch_fclib.so, which alone is linked with FCLIB and HDF5, writes into a pipe: this head, the
 * entries of W or M and those of H (friction_entry), then q, f and the coefficients of friction. Where `error` says
 * something, nothing follows.
 */
typedef struct fclib_head {
    bool global;
    int dimension, contacts, freedoms, w_size, h_rows, h_columns, w_count, h_count;
    char error[128];
} fclib_head;

#define FCLIB_SEND "pinch_fclib_send"
/* Reads the file and writes it to the descriptor. FCLIB may end the process or crash on a file that is broken. Returns
 * false where the descriptor took less, or with the errno ENOMEM without memory. */
typedef bool (*fclib_send)(const char *path, int to);

#endif
