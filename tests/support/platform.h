#ifndef PINCH_TEST_PLATFORM_H
#define PINCH_TEST_PLATFORM_H

#include <stdint.h>

/*
 * The bits of a run depend on more than Pinch: on the C library's mathematical functions, ODE, libccd and qhull. They do
 * not depend on the compiler. Golden hashes hold on the platform that they were made on; these two tell whether this is
 * that platform.
 */

/* The processor's architecture and the versions of the libraries. */
const char *platform_versions(void);

/* A hash over the results of mathematical functions, and over an ODE world that moves without Pinch. The C library
 * chooses its functions by processor, so that the same versions can give other bits. */
uint64_t platform_fingerprint(void);

#endif
