#ifndef PINCH_RUN_HANDS_H
#define PINCH_RUN_HANDS_H

#include "scenes/world/simulation.h"

#include <stdio.h>

/* What `pinch run` shows of hands and of further objects. */

const char *run_joint_plain_name(const world *w, int hand_index, int joint);
void run_print_joints(const world *w, FILE *stream);

/* The columns behind those of the fingers: joints, then the poses of further objects. */
void run_hands_csv_header(const world *w, FILE *stream);
void run_hands_csv_row(const world *w, FILE *stream);

#endif
