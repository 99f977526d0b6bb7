#ifndef PINCH_STATUS_H
#define PINCH_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define PINCH_API __attribute__((visibility("default")))
#else
#define PINCH_API
#endif

/* Was the call legal? How a solve ended is a different question: pinch_solve_status. */
typedef enum pinch_status {
    PINCH_OK = 0,
    PINCH_INVALID_ARGUMENT, /* a value is outside the range its header documents */
    PINCH_OUT_OF_MEMORY,
    PINCH_UNSUPPORTED, /* a legal request for which no method exists */
    PINCH_SYSTEM_FAILURE
} pinch_status;

/* How did the solve end? Only PINCH_SOLVE_CONVERGED is an answer. */
typedef enum pinch_solve_status {
    PINCH_SOLVE_CONVERGED = 0,
    PINCH_SOLVE_MAX_ITERATIONS,
    PINCH_SOLVE_DIVERGED,
    PINCH_SOLVE_INFEASIBLE, /* no forces inside the cones balance the wrench */
    PINCH_SOLVE_UNSTABLE,   /* forces could balance, the compliant object escapes */
    PINCH_SOLVE_RAY,        /* a pivoting method ended on a ray */
    PINCH_SOLVE_UNVERIFIED  /* converged by its own word, refused by the verification */
} pinch_solve_status;

/* Static strings, never NULL. The solve status text is the word of the JSON output. */
PINCH_API const char *pinch_status_text(pinch_status status);
PINCH_API const char *pinch_solve_status_text(pinch_solve_status status);

#ifdef __cplusplus
}
#endif
#endif
