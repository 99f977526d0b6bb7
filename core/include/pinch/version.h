#ifndef PINCH_VERSION_H
#define PINCH_VERSION_H

#include <pinch/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * The version of the headers that a program is compiled with. The build reads these three lines: packages, the
 * libraries' names and `pinch --version` have no other source. Libraries of one major version can take each other's
 * place: the number behind libpinch.so is the major version.
 */
#define PINCH_VERSION_MAJOR 1
#define PINCH_VERSION_MINOR 0
#define PINCH_VERSION_PATCH 0

/* Returns the version of the library that the program runs with, "1.0.0" for example; a static string,
 * for any thread. */
PINCH_API const char *pinch_version(void);

#ifdef __cplusplus
}
#endif
#endif
