#ifndef PINCH_TEST_SANITIZED_H
#define PINCH_TEST_SANITIZED_H

#include <stdbool.h>

/* With the sanitizers a program takes some five times as long. They look at the code, which fewer problems reach as
 * well; the build without them runs the larger counts.
 */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { SANITIZED = true };
#else
enum { SANITIZED = false };
#endif

#endif
