/* Settings from the environment that `pinch exec` leaves, and the statistics it asks for. */
#ifndef PINCH_PRELOAD_REPORT_H
#define PINCH_PRELOAD_REPORT_H

/*
 * The environment's names. PINCH_SCOPE: all, soft, material. PINCH_STATS: an absolute file name, or "-" for standard
 * error. PINCH_PROCESS: the process that `pinch exec` became; children of the program have the same environment.
 */
#define PINCH_ENV_SCOPE          "PINCH_SCOPE"
#define PINCH_ENV_RATIO          "PINCH_TANGENTIAL_RATIO"
#define PINCH_ENV_SOLVER         "PINCH_SOLVER"
#define PINCH_ENV_TOLERANCE      "PINCH_TOLERANCE"
#define PINCH_ENV_MAX_ITERATIONS "PINCH_MAX_ITERATIONS"
#define PINCH_ENV_STATS          "PINCH_STATS"
#define PINCH_ENV_PROCESS        "PINCH_PROCESS"

/* Reads the environment, once. A setting that makes no sense is not taken: `pinch exec` has checked them. */
void pinch_report_start(void);
/* Writes the file, where there is one and this process has stepped a world. */
void pinch_report_now(void);
/* The same, at most once a second: for programs that make and destroy worlds all the time. */
void pinch_report_sometimes(void);
/* The last report; the only one on standard error. */
void pinch_report_end(void);

#endif
