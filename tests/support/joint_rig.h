#ifndef PINCH_TEST_JOINT_RIG_H
#define PINCH_TEST_JOINT_RIG_H

#include "support/draw.h"

#include <pinch/ode.h>

/* A joint of any kind that Pinch has rows for holds a body that a fingertip touches. */

typedef enum joint_partner {
    JOINT_TWO_BODIES = 0,
    JOINT_STATIC_WORLD,
    JOINT_KINEMATIC_BODY,
    JOINT_PARTNERS
} joint_partner;

/* What motors and stops the joint has. */
typedef enum joint_variant {
    JOINT_FREE = 0,
    JOINT_MOTOR,
    JOINT_WEAK_MOTOR,
    JOINT_AT_LOW_STOP,
    JOINT_AT_HIGH_STOP,
    JOINT_LOCKED,
    JOINT_MOTOR_AT_STOP,
    JOINT_BOUNCING,
    JOINT_VARIANTS
} joint_variant;

extern const char *const joint_partner_names[JOINT_PARTNERS];
extern const char *const joint_variant_names[JOINT_VARIANTS];

/* A fingertip presses on the first body; the joint ties it to the second one or to the world. */
typedef struct joint_rig {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID body[2]; /* the second one NULL for the static world */
    dGeomID geom, tip;
    dBodyID tip_body;
    double tip_normal[3]; /* into the body */
    pinch_random random;
} joint_rig;

typedef struct joint_kind {
    const char *name;
    bool needs_two, motorized, linear, has_stops;
    bool known; /* all of what ODE solves for it is known: ODE shows it, or it was noted */
    dJointID (*make)(joint_rig *r, dBodyID a, dBodyID b);
    void (*set)(dJointID joint, int parameter, dReal value);
    double (*position)(dJointID joint);
} joint_kind;

extern const joint_kind joint_kinds[];
extern const int joint_kind_count;

/* The bodies move with `speed` (m/s) and turn with 20 times that in rad/s. by_ode is pinch_ode_settings.joints_by_ode.
 */
void joint_rig_make(joint_rig *r, uint64_t seed, joint_partner with, double speed, bool by_ode);
void joint_rig_free(joint_rig *r);
/* `swapped` attaches the joint the other way round. */
dJointID joint_rig_attach(const joint_kind *kind, joint_rig *r, joint_partner with, bool swapped);
/* Whether the kind goes with this partner, way and variant. */
bool joint_rig_possible(const joint_kind *kind, joint_partner with, bool swapped, joint_variant v);
/* Whether ODE has the joint leap away from where it was made, and perhaps from the tip: its arm or axis is the wrong
 * way round.
 */
bool joint_rig_leaps(const joint_kind *kind, joint_partner with, bool swapped);
/* Whether Pinch does not solve the joint as ODE would, as ODE's rows have its arm or angles the wrong way round
 * (see prismatic_rows.c and motor_rows.c). test_joint_errors looks at its rows. */
bool joint_rig_mends(const joint_kind *kind, joint_partner with, bool swapped);
/* How many steps the rig makes sense for, at most `most`: one where the joint leaps, ten for wheels, which nothing else
 * holds at each other. */
int joint_rig_steps(const joint_kind *kind, joint_partner with, bool swapped, int most);
/* Sets motors and stops at the joint's present position. */
void joint_rig_set(const joint_kind *kind, dJointID j, joint_variant v);

#endif
