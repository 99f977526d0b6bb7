/*
 * What the rows of joints are computed from.
 *
 * At rest the bodies of an island are where they were. Its rows are then those of the last step if all else that they
 * depend on is the same: what ODE's getters show of a joint in these poses, the pose that was noted of it, its servos,
 * the couplings, and the motion of kinematic bodies. To read this takes a fifth of the time that the rows take.
 */
#include "joints/island_joints.h"
#include "joints/row_builder.h"

#include "util/checksum.h"

typedef void (*vector_getter)(dJointID joint, dVector3 vector);

enum { MOST_VECTORS = 4, MOST_PARAMETERS = 2 };

/* What a type shows, beside the coordinates of its servos (coordinate.h). */
typedef struct shown {
    dJointType type;
    vector_getter vector[MOST_VECTORS];
    pinch_parameter_getter parameter;
    int coordinates;
    int motors;                      /* groups of a motor's parameters */
    int parameters[MOST_PARAMETERS]; /* others; 0: none */
} shown;

/* Returns NULL for a type that it does not know. */
static const shown *shown_of(dJointType type)
{
    static const shown known[] = {
        {dJointTypeHinge,
         {dJointGetHingeAnchor, dJointGetHingeAnchor2, dJointGetHingeAxis},
         dJointGetHingeParam,
         1,
         1,
         {0}},
        {dJointTypeSlider, {dJointGetSliderAxis}, dJointGetSliderParam, 1, 1, {0}},
        {dJointTypeFixed, {NULL}, dJointGetFixedParam, 0, 0, {dParamERP, dParamCFM}},
        {dJointTypeUniversal,
         {dJointGetUniversalAnchor, dJointGetUniversalAnchor2, dJointGetUniversalAxis1, dJointGetUniversalAxis2},
         dJointGetUniversalParam,
         2,
         2,
         {0}},
        {dJointTypeHinge2,
         {dJointGetHinge2Anchor, dJointGetHinge2Anchor2, dJointGetHinge2Axis1, dJointGetHinge2Axis2},
         dJointGetHinge2Param,
         2,
         2,
         {dParamSuspensionERP, dParamSuspensionCFM}},
    };
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
        if (known[k].type == type) return &known[k];
    return NULL;
}

static uint64_t add_motor(uint64_t sum, dJointID joint, pinch_parameter_getter get, int group)
{
    pinch_limit_motor m = pinch_read_motor(joint, get, group);
    const pinch_stop stop = pinch_read_stop(&m);
    const double values[] = {m.velocity,   m.fmax,   m.low_stop, m.high_stop, stop.fudge,
                             m.normal_cfm, stop.erp, stop.cfm,   stop.bounce};
    return pinch_checksum(sum, values, sizeof values / sizeof *values);
}

static uint64_t add_shown(uint64_t sum, const shown *s, dJointID joint)
{
    for (int i = 0; i < MOST_VECTORS && s->vector[i]; i++) {
        dVector3 vector;
        s->vector[i](joint, vector);
        sum = pinch_checksum(sum, vector, 3);
    }
    for (int axis = 0; axis < s->coordinates; axis++) {
        double position = pinch_coordinate_of(joint, axis)->position(joint);
        sum = pinch_checksum(sum, &position, 1);
    }
    for (int group = 0; group < s->motors; group++) sum = add_motor(sum, joint, s->parameter, group * dParamGroup);
    for (int i = 0; i < MOST_PARAMETERS && s->parameters[i]; i++) {
        double value = s->parameter(joint, s->parameters[i]);
        sum = pinch_checksum(sum, &value, 1);
    }
    return sum;
}

static uint64_t add_pose(uint64_t sum, const pinch_joint_pose *pose)
{
    const double values[] = {pose->known, pose->axis_length, pose->cosine, pose->sine};
    sum = pinch_checksum(sum, values, sizeof values / sizeof *values);
    sum = pinch_checksum(sum, pose->offset, 3);
    sum = pinch_checksum(sum, pose->turn, 4);
    return pinch_checksum(sum, pose->axis1, 3);
}

static uint64_t add_law(uint64_t sum, const pinch_servo *law)
{
    const double values[] = {law->target, law->kp, law->kd, law->rate, law->max_force};
    return pinch_checksum(sum, values, sizeof values / sizeof *values);
}

static uint64_t add_servos(uint64_t sum, const pinch_joint_servos *servos)
{
    for (int axis = 0; servos && axis < PINCH_JOINT_AXES; axis++) {
        const pinch_servo_axis *of = &servos->axis[axis];
        if (!of->used) continue;
        const double place[] = {axis, of->coordinate.placed, of->coordinate.position};
        sum = pinch_checksum(add_law(sum, &of->law), place, 3);
    }
    return sum;
}

static uint64_t add_kinematic(uint64_t sum, dBodyID body)
{
    sum = pinch_checksum(sum, dBodyGetPosition(body), 3);
    sum = pinch_checksum(sum, dBodyGetQuaternion(body), 4);
    sum = pinch_checksum(sum, dBodyGetLinearVel(body), 3);
    return pinch_checksum(sum, dBodyGetAngularVel(body), 3);
}

/* Adds what the rows of one joint depend on, and finds out whether it ties a kinematic body. Returns false where the
 * rows cannot be told. */
static bool add_joint(pinch_joint_store *store, pinch_step_joint *joint, uint64_t *sum, bool *kinematic)
{
    dBodyID body[2];
    const shown *s = shown_of(dJointGetType(joint->joint));
    if (!s || !pinch_joint_bodies(joint->joint, body)) return false;
    bool reversed = !dJointGetBody(joint->joint, 0);
    const pinch_joint_pose *pose = pinch_joint_pose_of(store->poses, joint->joint, body, &joint->pose);
    *sum = add_shown(*sum + reversed, s, joint->joint);
    if (pose) *sum = add_pose(*sum, pose);
    *sum = add_servos(*sum, pinch_servos_of(&store->servos, joint->joint, &joint->servos));
    for (int side = 0; side < 2; side++) {
        if (!body[side] || joint->body[side] >= 0) continue;
        *sum = add_kinematic(*sum, body[side]);
        *kinematic = true;
    }
    return true;
}

/* The joints of a coupling are among the island's, but for those of bodies that do not move by themselves. */
static bool add_coupling(const pinch_coupling *coupling, uint64_t *sum)
{
    *sum = add_law(*sum, &coupling->law);
    for (int i = 0; i < coupling->count; i++) {
        const pinch_coupled *of = &coupling->coupled[i];
        const double place[] = {of->coordinate.placed, of->coordinate.position};
        if (!pinch_moves_a_body(of->term.joint)) return false;
        *sum = pinch_checksum(*sum, place, 2);
    }
    return true;
}

bool pinch_joint_inputs(pinch_joint_store *store, pinch_island_joints *joints, uint64_t *sum)
{
    bool kinematic = false;
    *sum = pinch_checksum_start(joints->range.count);
    joints->ties_no_kinematic_body = false;
    for (int k = 0; k < joints->range.count; k++)
        if (!add_joint(store, pinch_island_joint(store, joints, k), sum, &kinematic)) return false;
    for (int k = 0; k < joints->couplings.count; k++)
        if (!add_coupling(pinch_island_coupling(store, joints, k), sum)) return false;
    joints->ties_no_kinematic_body = !kinematic;
    return true;
}

/* Tells whether the coordinate, read once more in the same pose, would be the same: the rounding of whole turns may
 * need a few readings to settle. */
static bool settled(dJointID joint, int axis, const pinch_followed *coordinate)
{
    pinch_followed again = *coordinate;
    if (!pinch_coordinate_of(joint, axis)) return true;
    pinch_coordinate_follow(joint, axis, NULL, &again);
    return again.position == coordinate->position;
}

static bool all_settled(const pinch_joint_store *store, const pinch_island_joints *joints)
{
    for (int k = 0; k < joints->range.count; k++) {
        pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        const pinch_joint_servos *servos = pinch_servos_of(&store->servos, joint->joint, &joint->servos);
        for (int axis = 0; servos && axis < PINCH_JOINT_AXES; axis++)
            if (servos->axis[axis].used && !settled(servos->joint, axis, &servos->axis[axis].coordinate)) return false;
    }
    for (int k = 0; k < joints->couplings.count; k++) {
        const pinch_coupling *coupling = pinch_island_coupling(store, joints, k);
        for (int i = 0; i < coupling->count; i++) {
            const pinch_coupled *of = &coupling->coupled[i];
            if (!settled(of->term.joint, of->term.axis, &of->coordinate)) return false;
        }
    }
    return true;
}

void pinch_remember_joint_inputs(pinch_joint_store *store, pinch_island_joints *joints)
{
    joints->inputs_known = pinch_joint_inputs(store, joints, &joints->rest_inputs) && all_settled(store, joints);
}
