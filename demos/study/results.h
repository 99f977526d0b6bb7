#ifndef PINCH_STUDY_RESULTS_H
#define PINCH_STUDY_RESULTS_H

#include "common/command_status.h"
#include "study.h"

/* The results of a study: an SQLite database with a write-ahead log. What has been committed stays, whatever happens to
 * the process.
 *
 *   study        one row: document, scene, table, hash, name, version, trials (how many there are in all),
 *                contact_solver, step (s; 0: the scene's), files (a hash over the meshes and hands)
 *   trials       "index", inputs, status, success, exit, wall_time, run_time, hash, recorded; inputs and recorded are
 *                JSON
 *   directions   trial, direction, status, success, exit, displacement, rotation, wall_time, hash, recorded
 *   errors       trial, direction, status, message
 *   refinements  trial, contact_solver, step, halvings, status, success, exit, displacement, rotation, wall_time, hash
 *   results      a view of the trials with a column for each input and each recorded value
 */
typedef struct results results;

typedef struct results_error {
    command_status status; /* COMMAND_BAD_INPUT, COMMAND_SYSTEM */
    char text[1024];       /* one line, which names the file */
} results_error;

/* Opens the file for the study. A file that exists is refused, unless `resume` says to go on with it; then it must be
 * of the same study. One that does not exist, or that was never begun, is begun. NULL after a failure. */
results *results_open(const char *path, const study *s, const char *version, bool resume, results_error *error);
/* Opens the results of any study for reading. */
results *results_read(const char *path, results_error *error);
/* Are there results of the study in the file? It is only read. */
bool results_check_beside(const char *path, const study *s, results_error *error);
/* Lays such results beside these as the schema `beside`. They are only read. Once. */
bool results_attach(results *r, const char *path, results_error *error);
/* Commits what was added and closes. Returns false where it could not be written. NULL is fine. */
bool results_close(results *r, results_error *error);

/* Is the trial there? Returns -1 after a failure. */
int results_has(results *r, long index, results_error *error);
/* Adds a trial, as trial_run answers. It is kept for good by the next commit. */
bool results_add(results *r, const json_t *trial, results_error *error);
/* Adds the rows of a refinement, as beside_refine answers. */
bool results_add_refinements(results *r, const json_t *answer, results_error *error);
bool results_commit(results *r, results_error *error);

typedef struct results_counts {
    long trials;                             /* of the study */
    long done, succeeded, unsolved, refused; /* unsolved: exit status 1 or 3; refused: 2, a draw that is no scene */
} results_counts;
bool results_count(results *r, results_counts *counts, results_error *error);

/* Makes the view `results`, which results_query can ask for a row of each trial that is there. */
bool results_make_view(results *r, results_error *error);

/* The rows of a query, one at a time: each row is a list of numbers, texts and nulls. Returns false after a failure;
 * `take` returns false to end. */
bool results_query(results *r, const char *query, bool (*take)(void *context, const json_t *names, json_t *row),
                   void *context, results_error *error);

#endif
