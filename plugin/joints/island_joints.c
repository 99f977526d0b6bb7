#include "joints/island_joints.h"

#include "joints/hinge_reference.h"
#include "joints/joint_aside.h"
#include "util/checksum.h"

#include "support/dense.h"
#include "support/extremes.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* Where less than this is left of a row beside the others it depends on (pinch_joint_row.pivot), ODE's own compliance
 * decides how the rows share what they carry. */
static const double INDEPENDENT = 1e-3;
/* Moves a kinematic body's motion, which is given, to the right hand side. */
static void follow_kinematic(pinch_joint_rows *rows, dBodyID body, int side)
{
    for (int k = 0; k < rows->count; k++) {
        const double *j = side ? rows->row[k].j2 : rows->row[k].j1;
        rows->row[k].rhs -= pinch_v3_dot(j, dBodyGetLinearVel(body)) + pinch_v3_dot(j + 3, dBodyGetAngularVel(body));
    }
}

/* The bodies of a joint, as of pinch_joint_bodies. */
static void find_bodies(const pinch_step_bodies *bodies, const pinch_step_joint *joint, dBodyID body[2])
{
    if (joint->body[0] < 0 || joint->body[1] < 0)
        (void)pinch_joint_bodies(joint->joint, body);
    else
        for (int side = 0; side < 2; side++) body[side] = bodies->items[joint->body[side]].body;
}

/* What has been read of a joint in this step; NULL where it is neither hinge nor slider. */
static const pinch_axis_reading *reading_of(const pinch_step_joint *joint)
{
    return joint->reading.known ? &joint->reading : NULL;
}

/* Makes room for what is read of a joint, and reads a hinge. */
static pinch_axis_reading *begin_reading(pinch_step_joint *joint, const dBodyID body[2])
{
    joint->reading.known = false;
    if (joint->reference >= 0) pinch_read_hinge(joint->joint, body, &joint->reading);
    return &joint->reading;
}

/* Computes the rows of a joint, those of its servos included. */
static void compute_rows(pinch_joint_store *store, const pinch_step_context *context, const dBodyID body[2],
                         pinch_step_joint *joint, pinch_joint_rows *rows)
{
    double axis[3];
    rows->reading = begin_reading(joint, body);
    pinch_joint_pose *pose = pinch_joint_pose_of(store->poses, joint->joint, body, &joint->pose);
    if (pose && joint->reference >= 0 && !pinch_hinge_pose_holds(pose, rows->reading)) pose = NULL;
    int reference = pose ? -1 : joint->reference;
    const double *axis2 = pinch_hinge_reference_axis(&store->references, reference, body[0], context->number, axis);
    pinch_joint_rows_of(context, joint->joint, body, axis2, pose, rows);
    pinch_joint_servos *servos = pinch_servos_of(&store->servos, joint->joint, &joint->servos);
    const pinch_axis_reading *reading = reading_of(joint);
    joint->servo_rows = servos ? pinch_servo_rows(servos, reading, body, context->h, rows->row + rows->count) : 0;
    rows->count += joint->servo_rows;
    joint->exact = rows->exact;
}

/* Adds what a joint's motors apply beside its rows to the external forces of its bodies. */
static void apply_motors(pinch_step_joint *joint, const pinch_joint_rows *rows, const int index[2], pinch_body *solved,
                         uint64_t *applied_bits)
{
    for (int k = 0; k < 12; k++) {
        int side = k / 6, i = k % 6;
        if (index[side] < 0) continue;
        joint->motors_add_wrench = joint->motors_add_wrench || rows->applied[side][i] != 0;
        solved[index[side]].external[i] += rows->applied[side][i];
    }
    if (!joint->motors_add_wrench) return;
    *applied_bits = pinch_checksum(*applied_bits, rows->applied[0], 6);
    *applied_bits = pinch_checksum(*applied_bits, rows->applied[1], 6);
}

/* Fills in the rows of one joint, and returns how many they are. */
static int fill_joint(pinch_joint_store *store, const pinch_step_context *context, const pinch_step_bodies *bodies,
                      pinch_island_joints *joints, pinch_step_joint *joint, pinch_body *solved, pinch_joint_row *row)
{
    dBodyID body[2];
    int index[2];
    pinch_joint_rows rows;
    rows.row = row;
    find_bodies(bodies, joint, body);
    compute_rows(store, context, body, joint, &rows);
    bool warm = joint->forces.count == rows.count;
    for (int side = 0; side < 2; side++)
        index[side] = joint->body[side] >= 0 ? bodies->items[joint->body[side]].local : PINCH_STATIC_BODY;
    joint->drives = 0;
    for (int k = 0; k < rows.count; k++) {
        bool drives = pinch_row_may_drive(&row[k]);
        joint->drives |= (unsigned)drives << k;
        joint->closing[k] = drives || (rows.driven >> k & 1) ? 0 : row[k].rhs;
        row[k].body1 = index[0];
        row[k].body2 = index[1];
        if (warm) row[k].force = joint->forces.force[k];
    }
    joint->may_give_energy = (rows.driven & ~joint->drives) != 0;
    joint->motors_add_wrench = false;
    if (rows.applies) apply_motors(joint, &rows, index, solved, &joints->applied_bits);
    joints->error = pinch_larger(joints->error, rows.error);
    joints->error_angle = pinch_larger(joints->error_angle, rows.error_angle);
    for (int side = 0; side < 2; side++) {
        if (index[side] >= 0 || !body[side]) continue;
        follow_kinematic(&rows, body[side], side);
        joint->may_give_energy = true;
        /* the speed of its drive is found with the contacts, not in these rows */
        if (pinch_drive_of(&bodies->drives, body[side]) >= 0) joint->exact = false;
    }
    return rows.count;
}

/* Fills in the rows of a coupling, whose joints have theirs, and returns how many they are. */
static int fill_coupling(const pinch_joint_store *store, const pinch_step_context *context,
                         const pinch_step_bodies *bodies, pinch_coupling *coupling, pinch_joint_row *row)
{
    pinch_term_reading readings[PINCH_COUPLING_TERMS];
    for (int i = 0; i < coupling->count; i++) {
        pinch_coupled *of = &coupling->coupled[i];
        int index = pinch_step_joint_of(store, of->term.joint, &of->joint);
        pinch_step_joint *joint = index < 0 ? NULL : &store->items[index];
        readings[i].axis = joint ? reading_of(joint) : NULL;
        for (int side = 0; side < 2; side++) readings[i].body[side] = joint ? joint->body[side] : PINCH_NOT_A_STEP_BODY;
    }
    return pinch_coupling_rows(coupling, readings, bodies, context->h, row);
}

void pinch_fill_joints(pinch_joint_store *store, const pinch_step_context *context, const pinch_step_bodies *bodies,
                       pinch_island_joints *joints, pinch_problem *problem)
{
    int count = 0;
    joints->applied_bits = pinch_checksum_start(joints->range.count);
    joints->error = joints->error_angle = 0;
    for (int k = 0; k < joints->range.count; k++) {
        pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        joint->rows.first = count;
        joint->rows.count = fill_joint(store, context, bodies, joints, joint, problem->bodies, problem->rows + count);
        count += joint->rows.count;
    }
    joints->joint_rows = count;
    for (int k = 0; k < joints->couplings.count; k++) {
        pinch_coupling *coupling = pinch_island_coupling(store, joints, k);
        coupling->rows.first = count;
        coupling->rows.count = fill_coupling(store, context, bodies, coupling, problem->rows + count);
        count += coupling->rows.count;
    }
    joints->row_count = problem->row_count = count;
}

uint64_t pinch_joint_bits(const pinch_island_joints *joints, const pinch_problem *problem)
{
    uint64_t sum = joints->applied_bits;
    for (int k = 0; k < joints->row_count; k++) {
        const pinch_joint_row *row = &problem->rows[k];
        double values[16];
        memcpy(values, row->j1, 6 * sizeof *values);
        memcpy(values + 6, row->j2, 6 * sizeof *values);
        values[12] = row->rhs;
        values[13] = row->cfm + row->yield;
        values[14] = row->low;
        values[15] = row->high;
        sum = pinch_checksum(sum, values, 16);
    }
    return sum;
}

static bool is_hard(const pinch_joint_row *row)
{
    return row->cfm == 0 && row->low == -INFINITY && row->high == INFINITY;
}

/* Sums up the joint's force and torque on the two bodies it was attached to. */
static void sum_rows(pinch_step_joint *joint, const pinch_joint_row *row)
{
    pinch_lanes sum[6] = {{0, 0}};
    for (int k = 0; k < joint->rows.count; k++) {
        const pinch_lanes both = {row[k].force, row[k].force};
        for (int i = 0; i < 3; i++) sum[i] += both * pinch_lanes_at(row[k].j1 + 2 * i);
        for (int i = 0; i < 3; i++) sum[3 + i] += both * pinch_lanes_at(row[k].j2 + 2 * i);
    }
    for (int i = 0; i < 6; i++) {
        pinch_lanes_put(sum[i], joint->wrench[i / 3] + 2 * (i % 3));
        pinch_lanes_put(sum[i], joint->given[i / 3] + 2 * (i % 3));
    }
}

/* Keeps the forces that the next solve begins with. Hard rows are solved for without; and where rows depend on each
 * other, forces are as large as what the rows miss, which changes from step to step. Returns whether hard rows do not.
 */
static bool keep_forces(pinch_step_joint *joint, const pinch_joint_row *row)
{
    bool hold = true;
    joint->forces.joint = joint->joint;
    joint->forces.count = joint->rows.count;
    for (int k = 0; k < joint->rows.count; k++) {
        bool hard = is_hard(&row[k]);
        hold = hold && (!hard || row[k].pivot >= INDEPENDENT);
        joint->forces.force[k] = hard ? 0 : row[k].force;
    }
    return hold;
}

void pinch_read_joints(pinch_joint_store *store, pinch_island_joints *joints, const pinch_problem *problem)
{
    joints->rows_hold = true;
    joints->includes_couplings = false;
    for (int k = 0; k < joints->range.count; k++) {
        pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        joints->rows_hold &= keep_forces(joint, problem->rows + joint->rows.first);
    }
    for (int k = 0; k < joints->range.count; k++) {
        pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        if (!joints->rows_hold) joint->forces.count = 0;
        if (!joints->rows_hold) continue;
        sum_rows(joint, problem->rows + joint->rows.first);
        if (joint->servo_rows > 0)
            pinch_read_servo_rows(pinch_servos_of(&store->servos, joint->joint, &joint->servos),
                                  problem->rows + joint->rows.first + joint->rows.count - joint->servo_rows);
    }
    for (int k = 0; k < joints->couplings.count; k++) {
        pinch_coupling *coupling = pinch_island_coupling(store, joints, k);
        coupling->force = problem->rows[coupling->rows.first].force;
    }
}

/* ---- forces ---- */

/* Computes the wrench that takes a body from the velocity it would have by itself to the one solved for. */
static void whole_wrench(const pinch_body *b, double h, double wrench[6])
{
    double change[6];
    for (int i = 0; i < 6; i++) change[i] = (b->velocity_end[i] - b->velocity[i]) / h;
    for (int i = 0; i < 3; i++) {
        wrench[i] = b->mass * change[i];
        wrench[3 + i] = pinch_v3_dot(b->inertia + 3 * i, change + 3);
    }
}

void pinch_share_joint_forces(pinch_joint_store *store, const pinch_step_bodies *bodies, pinch_range range,
                              pinch_island_joints *joints, const pinch_problem *problem, bool contacts_round)
{
    joints->includes_couplings = true;
    for (int k = 0; k < range.count; k++) pinch_island_body(bodies, range, k)->carrier = -1;
    for (int k = 0; k < joints->range.count; k++) {
        pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        memset(joint->given, 0, sizeof joint->given);
    }
    for (int k = joints->range.count - 1; k >= 0; k--) {
        pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        for (int side = 0; side < 2; side++)
            if (joint->body[side] >= 0) bodies->items[joint->body[side]].carrier = 2 * k + side;
    }
    for (int k = 0; k < range.count; k++) {
        pinch_step_body *b = pinch_island_body(bodies, range, k);
        if (b->drive >= 0) continue;
        if (b->carrier < 0) {
            if (contacts_round) whole_wrench(&problem->bodies[k], problem->step, b->wrench);
            continue;
        }
        double *given = pinch_island_joint(store, joints, b->carrier / 2)->given[b->carrier % 2];
        whole_wrench(&problem->bodies[k], problem->step, given);
        for (int i = 0; i < 6; i++) given[i] -= b->wrench[i];
    }
}

/* Tells whether ODE would have to solve nothing on the island's bodies but joints whose rows are known in full, and
 * whether all joints that were solved are still there, where either may have changed since they were collected. */
static bool all_known_still(pinch_joint_store *store, const pinch_step_bodies *bodies, pinch_range range,
                            const pinch_island_joints *solved)
{
    for (int k = 0; k < range.count; k++) {
        const pinch_step_body *b = pinch_island_body(bodies, range, k);
        if (b->drive >= 0) continue;
        int count = dBodyGetNumJoints(b->body), enabled = 0, nowhere = 0;
        for (int i = pinch_first_joint(b); i < count; i++) {
            dJointID joint = dBodyGetJoint(b->body, i);
            if (!dJointIsEnabled(joint)) continue;
            bool attached = enabled < b->joint_count; /* as a rule it is this one, in the order of ODE's list */
            int *hint = attached ? &store->attached.items[b->first_joint + enabled++].hint : &nowhere;
            if (dJointGetType(joint) == dJointTypeNull) continue;
            int index = pinch_step_joint_of(store, joint, hint);
            if (index < 0 || !store->items[index].exact) return false;
            store->items[index].found = true;
        }
    }
    for (int k = 0; k < solved->range.count; k++)
        if (!pinch_island_joint(store, solved, k)->found) return false;
    return true;
}

/* The same in the step at hand: as long as nobody can change a joint, those on the bodies are those that were
 * collected.
 */
static bool all_known(pinch_joint_store *store, const pinch_step_context *context, const pinch_step_bodies *bodies,
                      pinch_range range, const pinch_island_joints *solved)
{
    if (!context->solve_and_advance || !store->all_modelled) return all_known_still(store, bodies, range, solved);
    for (int k = 0; k < solved->range.count; k++)
        if (!pinch_island_joint(store, solved, k)->exact) return false;
    return true;
}

/* Fills in ODE's feedback: what the joint's rows exert, first on its first body that is not NULL, without what its
 * motors add besides. */
static void give_feedback(const pinch_step_joint *joint)
{
    dJointFeedback *feedback = dJointGetFeedback(joint->joint);
    if (!feedback) return;
    pinch_v3_copy(feedback->f1, joint->wrench[0]);
    pinch_v3_copy(feedback->t1, joint->wrench[0] + 3);
    bool both = joint->body[0] >= 0 && joint->body[1] >= 0;
    if (!both && (!dJointGetBody(joint->joint, 0) || !dJointGetBody(joint->joint, 1))) return;
    pinch_v3_copy(feedback->f2, joint->wrench[1]);
    pinch_v3_copy(feedback->t2, joint->wrench[1] + 3);
}

/* Adds what a joint's motors apply to its bodies, beside its rows, to what these get. */
static void add_motors(const pinch_joint_store *store, const pinch_step_context *context, pinch_step_joint *joint,
                       double given[2][6])
{
    pinch_joint_row row[PINCH_JOINT_MAX_ROWS];
    pinch_joint_rows rows = {.row = row};
    dBodyID body[2];
    (void)pinch_joint_bodies(joint->joint, body);
    rows.reading = begin_reading(joint, body);
    pinch_joint_pose *pose = pinch_joint_pose_of(store->poses, joint->joint, body, &joint->pose);
    pinch_joint_rows_of(context, joint->joint, body, NULL, pose, &rows);
    for (int k = 0; k < 12 && rows.applies; k++) given[k / 6][k % 6] += rows.applied[k / 6][k % 6];
}

/* Tells the servos of a joint who has found their forces in the step at hand. */
static void tell_servos(const pinch_joint_store *store, pinch_step_joint *joint, bool by_pinch)
{
    pinch_joint_servos *servos = pinch_servos_of(&store->servos, joint->joint, &joint->servos);
    if (servos) servos->by_pinch = by_pinch;
}

/* Takes up what ODE has of forces on the island's bodies. To add to that in ODE would be a call for each force. */
static void take_up_loads(const pinch_step_bodies *bodies, pinch_range range)
{
    for (int k = 0; k < range.count; k++) {
        pinch_step_body *b = pinch_island_body(bodies, range, k);
        pinch_v3_copy(b->load, dBodyGetForce(b->body));
        pinch_v3_copy(b->load + 3, dBodyGetTorque(b->body));
    }
}

static void put_loads_back(const pinch_step_bodies *bodies, pinch_range range)
{
    for (int k = 0; k < range.count; k++) {
        const pinch_step_body *b = pinch_island_body(bodies, range, k);
        dBodySetForce(b->body, b->load[0], b->load[1], b->load[2]);
        dBodySetTorque(b->body, b->load[3], b->load[4], b->load[5]);
    }
}

static void take_over(const pinch_joint_store *store, const pinch_step_context *context,
                      const pinch_step_bodies *bodies, pinch_step_joint *joint)
{
    double given[2][6];
    memcpy(given, joint->given, sizeof given);
    if (joint->motors_add_wrench) add_motors(store, context, joint, given);
    give_feedback(joint);
    for (int side = 0; side < 2; side++) {
        if (joint->body[side] >= 0) pinch_add_multiple6(1, given[side], bodies->items[joint->body[side]].load);
    }
    tell_servos(store, joint, true);
    pinch_set_joint_aside(joint->joint, &joint->aside);
}

/* Gives the force of a coupling to its bodies, by the rows that it was solved with. */
static void give_solved_coupling(const pinch_coupling *coupling, const pinch_step_bodies *bodies, pinch_range range,
                                 const pinch_problem *problem)
{
    for (int k = 0; k < 2 * coupling->rows.count; k++) {
        const pinch_joint_row *row = &problem->rows[coupling->rows.first + k / 2];
        int local = k % 2 ? row->body2 : row->body1;
        if (local >= 0)
            pinch_add_multiple6(coupling->force, k % 2 ? row->j2 : row->j1,
                                pinch_island_body(bodies, range, local)->load);
    }
}

void pinch_give_joint_forces(pinch_joint_store *store, const pinch_step_context *context,
                             const pinch_step_bodies *bodies, pinch_range range, pinch_island_joints *joints,
                             const pinch_problem *problem)
{
    joints->by_pinch = joints->range.count > 0 && joints->rows_hold && !context->settings.joints_by_ode &&
                       all_known(store, context, bodies, range, joints);
    joints->alone = joints->by_pinch && context->solve_and_advance && store->all_modelled;
    joints->skipped_by_ode = false;
    bool given = joints->by_pinch && joints->includes_couplings;
    int solved_couplings = problem && !given ? joints->couplings.count : 0;
    if (joints->by_pinch || solved_couplings > 0) {
        take_up_loads(bodies, range);
        for (int k = 0; k < joints->range.count && joints->by_pinch; k++) {
            pinch_step_joint *joint = pinch_island_joint(store, joints, k);
            take_over(store, context, bodies, joint);
            joints->alone = joints->alone && !joint->aside.enabled;
        }
        for (int k = 0; k < solved_couplings; k++)
            give_solved_coupling(pinch_island_coupling(store, joints, k), bodies, range, problem);
        put_loads_back(bodies, range);
    }
    for (int k = 0; k < joints->couplings.count; k++) {
        pinch_coupling *coupling = pinch_island_coupling(store, joints, k);
        coupling->by_pinch = true;
        if (!problem && !given) pinch_give_coupling_force(coupling, bodies);
    }
}

void pinch_reuse_joints(const pinch_joint_store *store, pinch_island_joints *joints, bool bodies_disabled)
{
    joints->skipped_by_ode = bodies_disabled && joints->ties_no_kinematic_body;
    for (int k = 0; k < joints->range.count; k++) {
        pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        give_feedback(joint);
        tell_servos(store, joint, true);
        if (!joints->skipped_by_ode) pinch_set_joint_aside(joint->joint, &joint->aside);
    }
    for (int k = 0; k < joints->couplings.count; k++) pinch_island_coupling(store, joints, k)->by_pinch = true;
}

void pinch_enable_joints(const pinch_joint_store *store, const pinch_island_joints *joints)
{
    for (int k = 0; k < joints->couplings.count; k++) pinch_island_coupling(store, joints, k)->by_pinch = false;
    if (!joints->by_pinch || (joints->skipped_by_ode && store->servos.count == 0)) return;
    for (int k = 0; k < joints->range.count; k++) {
        pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        tell_servos(store, joint, false);
        if (!joints->skipped_by_ode) pinch_put_joint_back(joint->joint, &joint->aside);
    }
}
