#ifndef PINCH_TEST_BLOCK_H
#define PINCH_TEST_BLOCK_H

#include <pinch/ode.h>
#include <stdbool.h>

/* The world holds a cube of 4 cm and 0.1 kg on a large static box. Gravity pulls downwards with 10 m/s^2. */
enum { BLOCK_POINTS = 8 };

typedef struct block {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID body;
    dGeomID cube, table;
} block;

/* A block of this material settles within a few tenths of a second. */
pinch_material block_material(void);

/* The table gets the material, unless it is NULL. The cube starts `depth` (m) inside the table's surface at z = 0. */
void block_make(block *b, const pinch_material *material, double depth);
void block_free(block *b);
/* Collides cube and table and hands the contacts over, with the geoms in either order; returns how many. */
int block_hand_over(block *b, bool swapped);
/* Hands over and steps; asserts that both are legal. */
void block_step(block *b, double h);
void block_steps(block *b, int count);
/* Both sum up the last step: the normal forces, and all forces on the cube. */
double block_normal_force(const block *b);
void block_force(const block *b, double force[3]);

#endif
