#ifndef PINCH_TEST_SCENE_RUN_H
#define PINCH_TEST_SCENE_RUN_H

#include "scenes/world/simulation.h"

/* Scenes for tests that step them: from the shipped files, or from a text. All assert that it works. */

/* A scene of assets/scenes by its file name. */
scene *scene_shipped(const char *name);
/* A scene file with this text. */
scene *scene_from_text(const char *text);
/* The scene's world with Pinch as contact solver. */
world *world_of(const scene *s);
/* Steps until `time` (s). */
void world_run_until(world *w, double time);

/* Forces and moments about the object's centre of mass that the contact points and the loads leave over, from the
 * plugin's list of contact points alone; and the largest excess of a point's friction over its limit, N. */
typedef struct balance_at_rest {
    double force, moment, cone;
} balance_at_rest;
balance_at_rest world_balance(const world *w);

#endif
