#ifndef PINCH_TEST_ISLAND_H
#define PINCH_TEST_ISLAND_H

#include <pinch/problem.h>
#include <stdint.h>

/* Random islands for the contact solver. Kind and seed alone decide what an island is. */

typedef enum island_kind {
    ISLAND_FRICTIONLESS = 0,
    ISLAND_HARD,
    ISLAND_SOFT,
    ISLAND_MIXED,    /* all three models, directional friction now and then */
    ISLAND_SLIPPING, /* hard and soft, every contact with a speed and a load that make it slip */
    ISLAND_ROUGH,    /* hard, friction 0.8 to 1.2, several contacts a body */
    ISLAND_JOINTS,   /* mixed, with hard, soft and one-sided joint rows */
    ISLAND_DRIVES,   /* a body between two massless drives, and more contacts */
    ISLAND_GRASP,    /* one body, contacts around it that press towards its centre */
    ISLAND_KIND_COUNT
} island_kind;

const char *island_kind_name(island_kind kind);

enum { ISLAND_BODIES = 8, ISLAND_CONTACTS = 24, ISLAND_ROWS = 48 };

typedef struct island {
    pinch_problem problem; /* points into the arrays below, so an island must not be copied; make it again */
    pinch_body bodies[ISLAND_BODIES];
    pinch_contact contacts[ISLAND_CONTACTS];
    pinch_joint_row rows[ISLAND_ROWS];
} island;

/* Returns J v of one row at the velocities v, 6 per body. */
double island_row_velocity(const pinch_joint_row *row, const double *v);

/* All forces are zero: there is no warm start. */
void island_make(island *made, island_kind kind, uint64_t seed);

#endif
