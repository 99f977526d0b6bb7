/* The settings that `pinch exec` leaves in the environment, and the statistics that it asks for. */
#ifndef PINCH_PRELOAD_REPORT_H
#define PINCH_PRELOAD_REPORT_H

/*
 * The names in the environment. PINCH_SCOPE is all, soft or material. PINCH_STATS is an absolute file name, or "-" for
 * standard error. PINCH_RECORD is the absolute name of a folder for recordings. PINCH_PROCESS is the process that
 * `pinch exec` became; children of the program have the same environment.
 */
#define PINCH_ENV_SCOPE          "PINCH_SCOPE"
#define PINCH_ENV_RATIO          "PINCH_TANGENTIAL_RATIO"
#define PINCH_ENV_SOLVER         "PINCH_SOLVER"
#define PINCH_ENV_TOLERANCE      "PINCH_TOLERANCE"
#define PINCH_ENV_MAX_ITERATIONS "PINCH_MAX_ITERATIONS"
#define PINCH_ENV_STATS          "PINCH_STATS"
#define PINCH_ENV_PROCESS        "PINCH_PROCESS"
#define PINCH_ENV_RECORD         "PINCH_RECORD"
#define PINCH_ENV_RECORD_MOST    "PINCH_RECORD_MOST"
#define PINCH_ENV_RECORD_ALL     "PINCH_RECORD_ALL"

/* Reads the environment once. Settings that make no sense are ignored, because `pinch exec` has checked them. */
void pinch_report_start(void);
/* Writes the file where one was asked for and this process has stepped a world. */
void pinch_report_now(void);
/* Does the same at most once a second: to be called after steps, and when worlds are destroyed. The first call also
 * sees to it that SIGTERM and SIGINT do not end the program without a last report. */
void pinch_report_sometimes(void);
/* Says on standard error that something in a world was left to ODE for a while, at this step of the world. To be called
 * once for a world. */
void pinch_report_backoff(long step);
/* Writes the last report, which is the only one on standard error, and says so where ODE had to solve much of what was
 * Pinch's to solve. */
void pinch_report_end(void);

#endif
