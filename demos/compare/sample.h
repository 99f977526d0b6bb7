#ifndef PINCH_COMPARE_SAMPLE_H
#define PINCH_COMPARE_SAMPLE_H

#include "scenes/world/world.h"

/* Which steps of a run are sampled: evenly spaced ones, the first ones in which a finger's state changes, and those in
 * which the fingers' forces change most. */

typedef enum sample_reason { SAMPLE_EVEN = 0, SAMPLE_STATE_CHANGE, SAMPLE_LOAD_CHANGE } sample_reason;

/* "even", "state change", "load change" */
const char *sample_reason_text(sample_reason reason);

typedef struct chosen_step {
    long step; /* from 1 */
    sample_reason reason;
} chosen_step;

typedef struct step_chooser {
    const world *w;
    long steps;
    double *change;             /* per step: the change of the fingers' forces, summed over the fingers, N */
    bool *state_changed;        /* per step: has a finger's state changed? */
    double *last;               /* per finger: its force in the step before */
    pinch_contact_state *state; /* per finger: its state in the step before */
} step_chooser;

/* Returns false when memory runs out. Free it in either case. */
bool step_chooser_start(step_chooser *chooser, const world *w, long steps);
void step_chooser_after_step(step_chooser *chooser);
/* Chooses at most `count` different steps, in order of time. Returns how many there are. */
int step_chooser_choose(const step_chooser *chooser, int count, chosen_step *chosen);
void step_chooser_free(step_chooser *chooser);

/* One step of Pinch's run beside its exact answer and the answers of ODE's solvers. */

enum {
    SAMPLE_COUNTS = 10,    /* numbers of iterations at which quickstep's convergence is shown */
    SAMPLE_RESIDUALS = 64, /* residuals kept of Pinch's solve */
    SAMPLE_RUNS = 16,
    SAMPLE_FINGERS = 32 /* fingers whose poses are kept */
};
extern const int sample_counts[SAMPLE_COUNTS];

typedef struct sample_contact {
    int finger;                    /* the finger that touches the object here; -1: another pair */
    double position[3], normal[3]; /* m; unit, into the object where it takes part, else into body 1 */
    double friction;               /* coefficient */
    double depth;                  /* m */
    double exact[3];               /* N, on that body */
    double exact_torsion;          /* N m about the normal */
    double force[SAMPLE_RUNS][3];  /* N, per run */
    double torsion[SAMPLE_RUNS];   /* N m */
} sample_contact;

typedef enum sample_status {
    SAMPLE_OK = 0,
    SAMPLE_NO_CONTACT, /* nothing touches in this step */
    SAMPLE_NO_EXACT,   /* no exact answer was found, or its laws are not supported */
    SAMPLE_NOT_SOLVED, /* Pinch left the step to ODE */
    SAMPLE_NO_MEMORY
} sample_status;

typedef struct sample {
    chosen_step at;
    double time; /* s, of the step's end */
    sample_status status;
    double scale;    /* N: the largest of the exact contact forces and of the load on the object */
    double residual; /* of the exact answer, over its own scale */
    int contact_count;
    sample_contact *contacts;
    double error[SAMPLE_RUNS];         /* per run: the largest contact's, over `scale` */
    double count_error[SAMPLE_COUNTS]; /* quickstep's with these numbers of iterations */
    int residual_count;
    double residuals[SAMPLE_RESIDUALS]; /* of Pinch's iterations */
    double poses[1 + SAMPLE_FINGERS]
                [7]; /* of the object and the fingers at the start of the step: position, quaternion */
} sample;

/* Samples the step that `w` is in. It must be called after the solve and before anything has moved. runs[0] is Pinch's
 * own; the others are ODE's. */
void sample_take(const world *w, const world_settings *runs, int run_count, sample *s);
void sample_free(sample *s);

/* A contact's force error in run `run` over the sample's scale. Torsion counts as the force at the lever `radius` (m).
 */
double sample_contact_error(const sample *s, const sample_contact *c, int run, double radius);

#endif
