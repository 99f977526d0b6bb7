#ifndef PINCH_STUDY_TRIAL_H
#define PINCH_STUDY_TRIAL_H

#include "study.h"

#include "scenes/world/simulation.h"

/* protocol.c */

/* How many runs the protocol makes of a trial: one for each direction of force, otherwise one. */
int protocol_runs(const study_protocol *p, int dimension);
/* "+x", "-x", "+y", ... of the run; "" where the protocol has no directions. */
const char *protocol_direction(const study_protocol *p, int run);
/* Appends the protocol's phases to the scene's schedule. *begin becomes the time (s) when they begin, at which motion
 * begins to count; 0 without a protocol. Returns false when memory runs out. */
bool protocol_apply(const study_protocol *p, int run, scene *s, double *begin);
/* When the scene's own schedule, ramps, paths and targets have come to their ends, s. */
double protocol_schedule_end(const scene *s);
/* The protocol with all of its numbers, as in a study. */
json_t *protocol_document(const study_protocol *p);

/* run.c */

/* The scene of one run of a trial. As scene_load. */
scene_status trial_scene(const study *s, json_t *inputs, int run, scene **result, double *begin, scene_error *error);

/* What else is wanted of a run; each may be NULL. */
typedef struct trial_watch {
    json_t *grasp; /* gets what record_contacts finds when the protocol begins, without one at the end */
    void (*step)(void *context, const world *w);                                    /* after every step */
    void (*finish)(void *context, const world *w, const simulation_result *result); /* before the world goes */
    void *context;
} trial_watch;

typedef struct trial_outcome {
    const char *status; /* as of a solve, or "bad_draw", "no_memory" */
    int exit;           /* as of `pinch run` */
    bool success;
    double displacement, rotation, wall_time;
    char hash[24];
    json_t *recorded;
    char message[1024]; /* "": none */
} trial_outcome;

/* The run number `run` of a trial. The caller releases what it has recorded. `watch` may be NULL. */
trial_outcome trial_run_once(const study *s, json_t *inputs, int run, const trial_watch *watch);

/* trial.c */

/* Runs a trial. The answer has `index`, `inputs`, `status`, `success`, `exit`, `wall_time`, `run_time`, `hash`,
 * `recorded`, `directions` and `errors`, as the tables of the results. dInitODE2 must have been called. */
json_t *trial_run(const study *s, long index);

/* The inputs with which a trial alone is what its row is of: those that were drawn and, where the study looks for a
 * least value, the one that holds, or the greatest where none does. For that the search is made again. *run becomes the
 * first of the protocol's directions that fails, which takes a trial, too; NULL: nobody asks. NULL when memory runs
 * out. dInitODE2 must have been called. */
json_t *trial_inputs(const study *s, long index, int *run);

/* Sets the quantity of the study's search among the inputs. */
void trial_set_least(const study *s, json_t *inputs, double value);

/* check.c */

/* Checks that the names of `record` are there, and that not all trials are illegal scenes, of a study of a thousand
 * trials at most. *error says what is wrong; dInitODE2 must have been called. */
scene_status trial_check(const study *s, scene_error *error);

/* record.c */

/* Copies the value that `name` stands for, such as "object.creep" or "fingers.*.slip_total", from a run's document.
 * Elements of lists are called by their `name`, or by their place. Returns how many values there were. */
int record_take(const json_t *document, const char *name, json_t *into);
/* Needs the name the static grasp? */
bool record_is_static(const char *name);
/* The quantities of the static grasp that some of the study's names stand for, under these names; null where the
 * grasp has none. The names are "grasp.smallest_friction", "grasp.largest_load_factor", "grasp.least_closing",
 * "grasp.epsilon", "grasp.epsilon_upper" and "grasp.volume". False for another name of a static quantity. */
bool record_grasp(const study *s, const scene *base, double time, json_t *into);
/* The same of a scene with hands, or with fingers that a path has moved, from the contacts as they are in the run: each
 * point that presses is a finger at its place, with its share of the stiffness, and closed as far as it is pressed. The
 * hand is thus taken as it stands. Nothing is set for other scenes, nor where ODE's own solvers solve. */
void record_contacts(const study *s, const world *w, json_t *into);

#endif
