#ifndef PINCH_SOLVE_H
#define PINCH_SOLVE_H

#include "command.h"

#include "scenes/scene.h"

/* solve_hands.c: the statics of a scene with hands, under what the schedule applies at `moment` (s), where its run has
 * come by then. NAN: no time was asked for. */
command_status solve_with_hands(const options *o, const scene *s, double moment);

#endif
