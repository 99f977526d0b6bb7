/* Checksums tell whether numbers are what they were, to the bit, where they are not kept for anything else. */
#ifndef PINCH_UTIL_CHECKSUM_H
#define PINCH_UTIL_CHECKSUM_H

#include <stdint.h>
#include <string.h>

/* `sum` goes on with more numbers: each is mixed in by a bijection, so that a change of one always
 * shows. */
static inline uint64_t pinch_checksum(uint64_t sum, const double *values, int count)
{
    for (int i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        sum = (sum ^ bits) * 0xff51afd7ed558ccdu;
        sum ^= sum >> 32;
    }
    return sum;
}

static inline uint64_t pinch_checksum_start(int count)
{
    return 0x9e3779b97f4a7c15u + (uint64_t)count; /* 2^64 over the golden ratio */
}

#endif
