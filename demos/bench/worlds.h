/* The worlds that the benchmarks of steps run, by size. */
#ifndef PINCH_BENCH_WORLDS_H
#define PINCH_BENCH_WORLDS_H

#include "world.h"

/* One object held by n >= 2 fingertips that do not move: 2 pinch a capsule, 3 to 9 a cube, more a ball. */
void bench_build_object(bench_world *w, int n);
/* n cubes of 50 mm, five fingertips each. */
void bench_build_hands(bench_world *w, int n);
/* The same, carried up and down, so that nothing is ever at rest. */
void bench_build_carried(bench_world *w, int n);
/* n balls in hands of five fingers with three hinges each, torques at the hinges. */
void bench_build_articulated(bench_world *w, int n);
/* n cubes between four fingertips each that rub to and fro faster than they can stick. */
void bench_build_slip(bench_world *w, int n);
/* n bricks in a wall; n boxes, n spheres on a heap in a pit. Stiff contacts, as ODE's defaults have them. */
void bench_build_wall(bench_world *w, int n);
void bench_build_boxes(bench_world *w, int n);
void bench_build_spheres(bench_world *w, int n);

#endif
