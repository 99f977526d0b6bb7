#ifndef PINCH_TEST_BLOCK_H
#define PINCH_TEST_BLOCK_H

#include <pinch/ode.h>
#include <stdbool.h>

/* A cube of 4 cm and 0.1 kg on a large static box, in a world with gravity 10 m/s^2 downwards. */
enum { BLOCK_POINTS = 8 };

typedef struct block {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID body;
    dGeomID cube, table;
} block;

/* A material whose block settles within a few tenths of a second. */
pinch_material block_material(void);

/* `material` on the table; NULL: on neither. The cube starts `depth` (m) inside the table's surface at z = 0. */
void block_make(block *b, const pinch_material *material, double depth);
void block_free(block *b);
/* Collides cube and table and hands the contacts over, with the geoms in either order; returns how many. */
int block_hand_over(block *b, bool swapped);
/* Hands over and steps; asserts that both are legal. */
void block_step(block *b, double h);
void block_steps(block *b, int count);
/* Sum of the normal forces on the cube, and of all forces, of the last step. */
double block_normal_force(const block *b);
void block_force(const block *b, double force[3]);

#endif
