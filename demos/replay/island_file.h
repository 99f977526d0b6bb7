#ifndef PINCH_REPLAY_ISLAND_FILE_H
#define PINCH_REPLAY_ISLAND_FILE_H

#include "scenes/scene.h"

#include <pinch/problem.h>

/* One recorded solve of an island: a document of the format "pinch-island/1". */
typedef struct island_file {
    long step_number;
    int island;
    pinch_solver_settings settings;
    pinch_problem problem; /* owns its lists and its memory; what the solver only writes is zero */
    pinch_step_result ended;
    /* what the solve ended with, NAN for what is not finite */
    double *velocities;     /* 6 per body */
    double *contact_forces; /* 4 per contact */
    double *row_forces;     /* per joint row */
} island_file;

/* Reads and checks a document. On success the caller gives *result to island_file_free; otherwise *result is NULL and
 * error->text says why, in one line with file, line and place. */
scene_status island_file_load(const char *path, island_file **result, scene_error *error);
void island_file_free(island_file *file); /* NULL is fine */

#endif
