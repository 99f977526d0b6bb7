#ifndef PINCH_TEST_DRAW_H
#define PINCH_TEST_DRAW_H

#include "support/arithmetic.h"
#include "support/random.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

/* These are the random draws of the tests. Every test seeds its own stream, so that its seed reproduces a failure. */

static inline double draw_uniform(pinch_random *random, double low, double high)
{
    return low + (high - low) * pinch_random_uniform(random);
}

static inline double draw_log_uniform(pinch_random *random, double low, double high)
{
    return exp(draw_uniform(random, log(low), log(high)));
}

/* Returns a whole number in 0 .. count - 1. */
static inline int draw_index(pinch_random *random, int count)
{
    return (int)(pinch_random_next(random) % (uint64_t)count);
}

static inline bool draw_chance(pinch_random *random, double probability)
{
    return pinch_random_uniform(random) < probability;
}

/* n is uniform on the unit sphere. */
static inline void draw_direction(pinch_random *random, double n[3])
{
    double z = draw_uniform(random, -1, 1), angle = draw_uniform(random, 0, 6.283185307179586), s = sqrt(1 - z * z);
    n[0] = s * cos(angle);
    n[1] = s * sin(angle);
    n[2] = z;
    double unit = length(n);
    for (int i = 0; i < 3; i++) n[i] /= unit;
}

/* t is a unit vector that is perpendicular to the unit vector n. */
static inline void draw_tangent(pinch_random *random, const double n[3], double t[3])
{
    double left = 0;
    while (left < 0.1) {
        draw_direction(random, t);
        double along = dot(t, n);
        for (int i = 0; i < 3; i++) t[i] -= along * n[i];
        left = length(t);
    }
    for (int i = 0; i < 3; i++) t[i] /= left;
}

/* The rows of R are the axes of a right-handed orthonormal frame. */
static inline void draw_frame(pinch_random *random, double R[9])
{
    draw_direction(random, R);
    draw_tangent(random, R, R + 3);
    cross(R, R + 3, R + 6);
}

/* With PINCH_TEST_FULL in the environment, tests with large counts run all of them; without it, a hundredth. */
static inline bool draw_full(void)
{
    const char *full = getenv("PINCH_TEST_FULL");
    return full && *full && *full != '0';
}

static inline int draw_count(int whole)
{
    return draw_full() ? whole : (whole + 99) / 100;
}

#endif
