#ifndef PINCH_SOLVE_H
#define PINCH_SOLVE_H

#include "command.h"

#include "scenes/scene.h"

/* solve_hands.c: the statics of a scene with hands, under what the schedule applies at `moment` (s), where its run has
 * come by then. NAN: no time was asked for. */
command_status solve_with_hands(const options *o, const scene *s, double moment);

/* solve_hands.c: writes a slip margin as tables show it: a hyphen where there is none, and a zero without a sign. */
enum { SOLVE_MARGIN_LENGTH = 16 };
void solve_write_margin(double margin, char text[SOLVE_MARGIN_LENGTH]);

#endif
