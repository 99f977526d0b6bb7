/*
 * Couplings: springs, dampers or rigid ties on sums of joint coordinates, x = sum a_i q_i, with a target and a bound.
 *
 * Over a step, implicitly, the force along x is clamp(kp (target - x - h x'+) + kd (rate - x'+), -max, max), as that of
 * a servo, and a_i times that acts on coordinate i. It is one row for all bodies of the coupling,
 *
 *     sum a_i J_i v+ + C lambda = C (kp (target - x) + kd rate),     C = 1 / (h kp + kd),
 *
 * with C = 0 and (target - x) / h on the right where kp is infinite. The bodies of a coupling are of one island,
 * whether anything touches them or not. ODE has no such row: where an island is left to it, the coupling acts by an
 * explicit force, that of its row if its bodies were free.
 */
#ifndef PINCH_JOINTS_COUPLING_H
#define PINCH_JOINTS_COUPLING_H

#include "bodies/step_bodies.h"
#include "joints/coordinate.h"
#include "util/list.h"

typedef struct pinch_coupled {
    pinch_coupling_term term;
    pinch_followed coordinate;
    int joint; /* hint: where its joint was found among those of the step last */
} pinch_coupled;

typedef struct pinch_coupling {
    bool used;
    pinch_servo law;
    int count;
    pinch_coupled coupled[PINCH_COUPLING_TERMS];
    bool placed;      /* `position` has been read since the coupling was made */
    double position;  /* x at the start of the step */
    double force;     /* lambda of the last step */
    bool acts;        /* in the step at hand: its joints are enabled, and tie bodies that move by themselves */
    bool by_pinch;    /* in the step at hand, a solve has found its force */
    int body;         /* one of its step bodies */
    pinch_range rows; /* among its island's */
} pinch_coupling;

typedef struct pinch_couplings {
    pinch_coupling *items; /* by their numbers; some are not used */
    int count, room;
    bool changed; /* one was made or ended since the islands were built */
    PINCH_LIST(int) by_island;
} pinch_couplings;

/* As pinch_ode_couple and pinch_ode_set_coupling. */
pinch_status pinch_coupling_make(pinch_couplings *couplings, const pinch_coupling_term *terms, int count,
                                 const pinch_servo *law, int *number);
pinch_status pinch_coupling_set(pinch_couplings *couplings, int number, const pinch_servo *law);
/* Returns NULL for a number that no coupling has. */
const pinch_coupling *pinch_coupling_of(const pinch_couplings *couplings, int number);

/* Adds the bodies of all couplings to those of the step, each coupling's to one island. Returns false when memory runs
 * out. */
bool pinch_collect_couplings(pinch_couplings *couplings, pinch_step_bodies *bodies);
/* Tells whether forces move a body of the joint. */
bool pinch_moves_a_body(dJointID joint);
/* Tells whether the coupling has a law by which it acts, and whether its joints let it: they are enabled, and tie
 * bodies that move by themselves. */
bool pinch_coupling_has_law(const pinch_coupling *coupling);
bool pinch_coupling_can_act(const pinch_coupling *coupling);

/* What its joint's rows have found of a term in this step. */
typedef struct pinch_term_reading {
    const pinch_axis_reading *axis; /* NULL: it is neither hinge nor slider, and has not been read */
    int body[2];                    /* step bodies, as in pinch_step_joint */
} pinch_term_reading;

/* Writes the rows of a coupling that acts, at most one for each of its terms, and returns how many there are. readings:
 * one for each term. */
int pinch_coupling_rows(pinch_coupling *coupling, const pinch_term_reading *readings, const pinch_step_bodies *bodies,
                        double h, pinch_joint_row *rows);
/* Gives the force of its last solve to its bodies. */
void pinch_give_coupling_force(pinch_coupling *coupling, const pinch_step_bodies *bodies);
/* Has the couplings that no solve has found a force for act explicitly. To be called just before ODE steps. */
void pinch_leave_couplings_to_ode(pinch_couplings *couplings, const pinch_step_context *context,
                                  const pinch_step_bodies *bodies);
/* Forgets who has found which force. To be called just after. */
void pinch_couplings_stepped(pinch_couplings *couplings);

void pinch_couplings_free(pinch_couplings *couplings);

#endif
