#ifndef PINCH_TEST_SCENE_RUN_H
#define PINCH_TEST_SCENE_RUN_H

#include "scenes/world/simulation.h"

/* Loads scenes, from the shipped files or from a text, and steps them. All functions assert that they work. */

/* The scene of assets/scenes with this file name. */
scene *scene_shipped(const char *name);
/* The scene that a file with this text describes. */
scene *scene_from_text(const char *text);
/* The scene's world with Pinch as contact solver. */
world *world_of(const scene *s);
/* Steps the world until `time` (s). */
void world_run_until(world *w, double time);

/* What contact points and loads leave over on the object: the force (N), the moment about the centre of mass (N m), and
 * the largest excess of a point's friction over its limit (N). It is computed from the plugin's list of contact points
 * alone. */
typedef struct balance_at_rest {
    double force, moment, cone;
} balance_at_rest;
balance_at_rest world_balance(const world *w);

#endif
