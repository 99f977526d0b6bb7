#ifndef PINCH_SIMULATION_H
#define PINCH_SIMULATION_H

#include "world.h"

#include <jansson.h>

/* A whole run of a scene, and what is measured in it. */

typedef enum simulation_event_type {
    EVENT_CRUSH = 0,
    EVENT_SLIP,
    EVENT_DROPPED, /* fallen freely, or at the end of the run untouched and gone by its own size */
    EVENT_LIMIT,
    EVENT_COUNT
} simulation_event_type;

/* "crush", "slip", "dropped", "limit": a joint of a hand has come to one of its limits */
const char *simulation_event_name(simulation_event_type type);

typedef struct simulation_event {
    double time;     /* s */
    int finger;      /* -1: an object or a joint */
    int object;      /* dropped: which one */
    int hand, joint; /* limit: which one of which hand; else -1 */
    simulation_event_type type;
    double value, limit; /* N; m; for dropped: distance from where it was last touched (m) and 0; rad or m */
} simulation_event;

/* How an object has moved from its start, in the world or as the hand sees it. */
typedef struct simulation_motion {
    double displacement[3];      /* m */
    double creep, creep_angular; /* |x(T) - x(T/2)| / (T/2), m/s; the rotation between them likewise, rad/s. NaN where
                                    the run was ended early */
} simulation_motion;

/* What one object has done. */
typedef struct simulation_object {
    simulation_motion motion;
    simulation_motion motion_in_hand; /* relative to what the schedule's `hand` does */
    double speed_max;                 /* m/s, over the second half */
} simulation_object;

typedef struct simulation_result {
    long steps;
    double time;              /* s simulated */
    simulation_motion motion; /* these three: of the first object */
    simulation_motion motion_in_hand;
    double speed_max;
    int object_count;
    simulation_object *objects;
    double force_error, torque_error; /* N, N m: the sum of all forces and the external wrench at the end, of the object
                                       * with the largest */
    double joint_error; /* N m or N: the largest difference between what a joint's position control should give at the
                         * position and speed that the last step ended with and what it gave; NaN without one, 0 at rest
                         */
    double loop_gap;    /* m: between anchors of a hand's loops at the end; NaN without loops */
    double max_penetration; /* m */
    bool touched;           /* by a finger at the end: any of the objects */
    char *overlap;          /* the remark on what begins in something else; NULL: none */
    int event_count;
    simulation_event *events;
} simulation_result;

/* A run that makes one step at a time, so that several runs can take turns. */
typedef struct simulation simulation;

/* NULL when memory runs out. `w` must outlive the simulation. */
simulation *simulation_start(world *w);
/* The number of steps in the scene's duration, rounded. */
long simulation_steps(const simulation *s);
world_status simulation_step(simulation *s);
/* What has been measured so far. */
const simulation_result *simulation_so_far(const simulation *s);
/* Ends the run. The caller gives the result to simulation_free. */
void simulation_finish(simulation *s, simulation_result *result);
void simulation_free(simulation_result *result);

/*
 * checkpoint.c: a run as bytes, from which it goes on to the same bits, in another process too. Only of WORLD_PINCH.
 *
 * simulation_know_origin reads what the run is made from: the scene and the files that it names, which may change while
 * it runs: where there will be checkpoints, it is to be called before the first step.
 * simulation_checkpoint makes the bytes; the caller frees *bytes. Both return false when memory runs out.
 */
bool simulation_know_origin(simulation *s);
bool simulation_checkpoint(simulation *s, unsigned char **bytes, size_t *size);

typedef enum checkpoint_status {
    CHECKPOINT_FINE = 0,
    CHECKPOINT_DAMAGED,  /* it is none, or none of this program's format, or not as it was written */
    CHECKPOINT_FOREIGN,  /* of another scene, or of another solver or step */
    CHECKPOINT_NO_MEMORY /* or CHECKPOINT_FOREIGN: the run is as it was */
} checkpoint_status;

/* Brings a run that has just been started to where the other one was. Only a run that is CHECKPOINT_FINE may go on. */
checkpoint_status simulation_resume(simulation *s, const unsigned char *bytes, size_t size);

/* In one word how the grasp went, by the worst of its events: "held", "slipped", "crushed" or "dropped". */
const char *simulation_outcome(const simulation_result *result);

/* What makes the result another one than was meant, in a line each: a duration between two steps, things that begin in
 * each other, steps that put energy in. */
void simulation_remarks(const world *w, const simulation_result *result,
                        void (*report)(void *context, const char *text), void *context);
enum { SIMULATION_REMARK = 160 };
/* The remark on the energy of steps; false where there is none. */
bool simulation_energy_remark(const world *w, char text[SIMULATION_REMARK]);
/* The remark on a duration that is no whole number of steps; false where it is one. */
bool simulation_duration_remark(const scene *s, char text[SIMULATION_REMARK]);

/* document.c: the run as `pinch run --json` prints it; NULL when memory runs out. The static answer at the end, which
 * costs a solve of its own, is null without `with_statics`. */
json_t *simulation_document(const world *w, const simulation_result *result, bool with_statics);

#endif
