#ifndef PINCH_RUN_H
#define PINCH_RUN_H

#include "command.h"

#include "scenes/world/simulation.h"
#include <stdio.h>

/* The parts of pinch run. */

/* ---- run_hands.c ---- */

/* What `pinch run` shows of hands and of further objects. */

void run_print_joints(const world *w, FILE *stream);

/* The columns behind those of the fingers: joints, then the poses of further objects. */
void run_hands_csv_header(const world *w, FILE *stream);
void run_hands_csv_row(const world *w, FILE *stream);

/* ---- run_checkpoint.c: --checkpoint FILE --every N, --resume FILE ---- */

typedef struct run_checkpoint {
    const char *path; /* where checkpoints are written; NULL: none are */
    int every;        /* steps */
    char *from;       /* what --resume has read; NULL without it */
    size_t from_size;
    const char *from_path;
} run_checkpoint;

/* Checks the options, and reads the file of --resume. What comes of it goes to run_checkpoint_free. */
command_status run_checkpoint_prepare(const options *o, run_checkpoint *c);
void run_checkpoint_free(run_checkpoint *c);

/* Brings a run that has just been started to where the checkpoint was made, if there is one. */
command_status run_checkpoint_resume(const run_checkpoint *c, simulation *s);
/* Writes a checkpoint where one is due after so many steps, or `now`. */
command_status run_checkpoint_step(const run_checkpoint *c, simulation *s, long steps, bool now);

#endif
