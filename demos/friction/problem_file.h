/*
 * Frictional problems in the files of the FCLIB collection (Acary, Bremond, Koziara and Perignon, "FCLIB: a collection
 * of discrete 3D frictional contact problems", 2014), which are HDF5.
 *
 *     local     u = W r + q
 *     global    M v = H r + f,   u = H^T v + q
 *
 * Contact k has the rows k d to k d + d - 1, d the dimension, the normal first. Units are the file's.
 */
#ifndef PINCH_FRICTION_PROBLEM_FILE_H
#define PINCH_FRICTION_PROBLEM_FILE_H

#include "common/command_status.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct friction_entry {
    int row, column;
    double value;
} friction_entry;

typedef struct friction_matrix {
    int rows, columns;
    size_t count;
    friction_entry *entries; /* several of one place add up */
} friction_matrix;

typedef struct friction_file {
    bool global;
    int dimension;        /* 2 or 3 */
    int contacts;         /* >= 0 */
    int freedoms;         /* of M; 0 in a local problem */
    friction_matrix w;    /* W or M */
    friction_matrix h;    /* H; of a global problem */
    double *free;         /* q, per row of the contacts */
    double *force;        /* f, per freedom */
    double *coefficients; /* friction, per contact, >= 0 */
} friction_file;

/* Reads a file, by the library of FCLIB. On failure the reason is in error (512 bytes), and nothing is to be released:
 * COMMAND_BAD_INPUT for what is no such file, COMMAND_SYSTEM without that library or memory. */
command_status friction_file_read(const char *path, friction_file *file, char *error);
void friction_file_free(friction_file *file);

#endif
