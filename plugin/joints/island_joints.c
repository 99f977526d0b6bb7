/* The joints of an island: their rows before its solve, and what those came to after it. */
#include "util/checksum.h"
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* What is left of a row beside the others it depends on (pinch_joint_row.pivot): below, ODE's own compliance decides
 * how the rows share what they carry. */
static const double INDEPENDENT = 1e-3;
/* Error of a row's law, relative to the velocities in it. */
static const double LAW_TOLERANCE = 1e-8;

/* A kinematic body's motion is given: it belongs to the right hand side. */
static void follow_kinematic(pinch_joint_rows *rows, dBodyID body, int side)
{
    for (int k = 0; k < rows->count; k++) {
        const double *j = side ? rows->row[k].j2 : rows->row[k].j1;
        rows->row[k].rhs -= pinch_v3_dot(j, dBodyGetLinearVel(body)) + pinch_v3_dot(j + 3, dBodyGetAngularVel(body));
    }
}

void pinch_joint_applied(const pinch_ode *p, const pinch_step_joint *joint, double h, double applied[2][6])
{
    pinch_joint_row row[PINCH_JOINT_MAX_ROWS];
    pinch_joint_rows rows = {.row = row};
    dBodyID body[2];
    (void)pinch_joint_bodies(joint->joint, body);
    pinch_joint_rows_of(joint->joint, body, p->world, h, NULL, NULL, &rows);
    memcpy(applied, rows.applied, sizeof rows.applied);
}

/* The rows of one joint; how many. */
static int fill_joint(pinch_ode *p, pinch_step_joint *joint, double h, pinch_body *bodies, pinch_joint_row *row,
                      uint64_t *applied_bits)
{
    dBodyID body[2];
    int index[2];
    pinch_joint_rows rows = {.row = row};
    (void)pinch_joint_bodies(joint->joint, body);
    double kept[3];
    const double *axis2 = pinch_joint_reference_axis(p, joint->reference, body[0], kept);
    pinch_joint_rows_of(joint->joint, body, p->world, h, axis2, pinch_joint_pose_of(p->joint_poses, joint->joint, body),
                        &rows);
    joint->exact = rows.exact;
    joint->applies = false;
    for (int side = 0; side < 2; side++) {
        index[side] = joint->body[side] >= 0 ? p->bodies.items[joint->body[side]].local : PINCH_STATIC_BODY;
        for (int i = 0; i < 6 && index[side] >= 0; i++) {
            joint->applies = joint->applies || rows.applied[side][i] != 0;
            bodies[index[side]].external[i] += rows.applied[side][i];
        }
        if (!body[side] || !dBodyIsKinematic(body[side])) continue;
        follow_kinematic(&rows, body[side], side);
        /* its drive's speed is found with the contacts, not in these rows */
        if (pinch_drive_of(p, body[side]) >= 0) joint->exact = false;
    }
    if (joint->applies) {
        *applied_bits = pinch_checksum(*applied_bits, rows.applied[0], 6);
        *applied_bits = pinch_checksum(*applied_bits, rows.applied[1], 6);
    }
    for (int k = 0; k < rows.count; k++) {
        row[k].body1 = index[0];
        row[k].body2 = index[1];
    }
    return rows.count;
}

void pinch_fill_joints(pinch_ode *p, pinch_island *island, double h, pinch_problem *problem)
{
    int count = 0;
    island->applied_bits = pinch_checksum_start(island->joint_count);
    for (int k = 0; k < island->joint_count; k++) {
        pinch_step_joint *joint = pinch_island_joint(p, island, k);
        joint->first_row = count;
        joint->row_count = fill_joint(p, joint, h, problem->bodies, problem->rows + count, &island->applied_bits);
        count += joint->row_count;
    }
    island->row_count = problem->row_count = count;
}

/* A checksum of what the joints demand: their rows, and what motors apply that run into their stops. */
uint64_t pinch_joint_bits(const pinch_island *island, const pinch_joint_row *rows, int count)
{
    uint64_t sum = island->applied_bits;
    for (int k = 0; k < count; k++) {
        double values[16];
        memcpy(values, rows[k].j1, 6 * sizeof *values);
        memcpy(values + 6, rows[k].j2, 6 * sizeof *values);
        values[12] = rows[k].rhs;
        values[13] = rows[k].cfm;
        values[14] = rows[k].low;
        values[15] = rows[k].high;
        sum = pinch_checksum(sum, values, 16);
    }
    return sum;
}

static double row_velocity(const pinch_body *bodies, const pinch_joint_row *row, double *size)
{
    const int body[2] = {row->body1, row->body2};
    const double *j[2] = {row->j1, row->j2};
    double sum = 0;
    for (int side = 0; side < 2; side++) {
        if (body[side] < 0) continue;
        const double *v = bodies[body[side]].velocity_end;
        for (int i = 0; i < 6; i++) {
            sum += j[side][i] * v[i];
            *size += fabs(j[side][i] * v[i]);
        }
    }
    return sum;
}

/* Does the row's law hold for what was solved? Checked here from the velocities, whatever solved it. */
static bool row_holds(const pinch_body *bodies, const pinch_joint_row *row)
{
    double size = fabs(row->rhs), v = row_velocity(bodies, row, &size), give = row->cfm * row->force;
    double missing = row->rhs - v - give, allowed = LAW_TOLERANCE * (size + fabs(give)) + 1e-12;
    bool hard = row->cfm == 0 && row->low == -INFINITY && row->high == INFINITY;
    if ((hard && !(row->pivot >= INDEPENDENT)) || !isfinite(row->force)) return false;
    /* too slow only where the force is at its upper limit, too fast only at its lower */
    if (missing > allowed) return row->force >= row->high * (1 - LAW_TOLERANCE * copysign(1, row->high));
    if (missing < -allowed) return row->force <= row->low * (1 + LAW_TOLERANCE * copysign(1, row->low));
    return true;
}

/* The joint's force and torque on the two bodies it was attached to. */
static void sum_rows(pinch_step_joint *joint, const pinch_joint_row *row)
{
    memset(joint->wrench, 0, sizeof joint->wrench);
    for (int k = 0; k < joint->row_count; k++)
        for (int i = 0; i < 6; i++) {
            joint->wrench[0][i] += row[k].force * row[k].j1[i];
            joint->wrench[1][i] += row[k].force * row[k].j2[i];
        }
}

void pinch_read_joints(pinch_ode *p, pinch_island *island, const pinch_problem *problem)
{
    island->rows_hold = true;
    for (int k = 0; k < problem->row_count && island->rows_hold; k++)
        island->rows_hold = row_holds(problem->bodies, &problem->rows[k]);
    for (int k = 0; k < island->joint_count && island->rows_hold; k++) {
        pinch_step_joint *joint = pinch_island_joint(p, island, k);
        sum_rows(joint, problem->rows + joint->first_row);
    }
}
