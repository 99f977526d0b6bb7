#ifndef PINCH_SUPPORT_RANDOM_H
#define PINCH_SUPPORT_RANDOM_H

#include <stdint.h>

/* A reproducible random stream: xoshiro256** (Blackman and Vigna 2021), seeded through splitmix64. */
typedef struct pinch_random {
    uint64_t state[4];
} pinch_random;

void pinch_random_seed(pinch_random *random, uint64_t seed);
uint64_t pinch_random_next(pinch_random *random);
/* Draws uniformly from the 2^53 multiples of 2^-53 in [0, 1). */
double pinch_random_uniform(pinch_random *random);

#endif
