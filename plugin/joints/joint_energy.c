/*
 * The energy that joints put in, and the pace that keeps it small.
 *
 * Rows of joints and stops take energy out of bodies, but where they take errors of position back: a row that asks for
 * the velocity c besides what its bodies would do by themselves puts in h lambda c. Loops that are nearly locked need
 * large motions for small errors. There an error that is far smaller than anybody sees, as turning bodies make one in
 * each step, throws the mechanism about if it is taken back at once.
 *
 * In an implicit step, the kinetic energy changes by
 *
 *     the sum over all forces of h f.w+   less   |v+ - v|^2 / 2 in the metric of the inertia,
 *
 * weight included, as ODE moves bodies by v+. What is not the part of weight, force control, motors, springs and
 * contacts in this sum is the work of the joints. It may not be more than they have taken out before
 * (islands/energy_account.c). At the pace p, errors are taken back by p times what ODE asks for; at p = 0 rows only
 * keep them from growing, and what they do takes energy out. The forces of rows that contradict each other are huge and
 * cancel, so that these are not summed up. What lifting takes is told row by row, where forces are no larger than the
 * weight of all.
 */
#include "joints/island_joints.h"

#include "support/extremes.h"
#include "support/loop.h"
#include "support/vec3.h"

#include <math.h>

bool pinch_row_may_drive(const pinch_joint_row *row)
{
    return row->cfm > 0 || (row->low > -INFINITY && row->high < INFINITY);
}

/* Returns u^T M u / 2 (J), with the body's mass and inertia M. */
static double kinetic_energy(const pinch_body *b, const double u[6])
{
    double spin = 0;
    for (int i = 0; i < 3; i++) spin += u[3 + i] * pinch_v3_dot(b->inertia + 3 * i, u + 3);
    return 0.5 * (b->mass * pinch_v3_dot(u, u) + spin);
}

/* Returns j v+ of a row. */
static double velocity_along(const pinch_problem *problem, const pinch_joint_row *row)
{
    double sum = 0;
    for (int side = 0; side < 2; side++) {
        int body = side ? row->body2 : row->body1;
        const double *j = side ? row->j2 : row->j1;
        if (body < 0) continue;
        const double *v = problem->bodies[body].velocity_end;
        for (int i = 0; i < 6; i++) sum += j[i] * v[i];
    }
    return sum;
}

/* Returns the work (J) of what may put energy in: motors, springs, and the kinematic partners of other joints. */
static double driven_work(const pinch_joint_store *store, const pinch_island_joints *joints,
                          const pinch_problem *problem)
{
    double work = 0;
    for (int k = 0; k < joints->range.count; k++) {
        const pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        const pinch_joint_row *row = problem->rows + joint->rows.first;
        bool all = joint->may_give_energy || joints->pace != 1; /* otherwise the other rows ask for errors alone */
        for (int i = 0; i < joint->rows.count; i++) {
            if (!all && !(joint->drives >> i & 1)) continue;
            double speed = joint->drives >> i & 1 ? velocity_along(problem, &row[i])
                                                  : row[i].rhs - joints->pace * joint->closing[i];
            work += problem->step * row[i].force * speed;
        }
    }
    for (int k = joints->joint_rows; k < problem->row_count; k++)
        work += problem->step * problem->rows[k].force * velocity_along(problem, &problem->rows[k]);
    return work;
}

double pinch_work_taken_by_drive(const pinch_problem *problem, const pinch_joint_row *row)
{
    static const double ALL = 1 - 1e-9; /* of its force */
    bool springs = row->cfm > 0, drives = row->low > -INFINITY && row->high < INFINITY;
    if (!springs && !drives) return 0;
    double speed = velocity_along(problem, row);
    if (springs) return fmin(problem->step * row->force * speed, 0);
    bool forwards = row->rhs > 0 && speed < 0 && row->force > 0 && row->force >= ALL * row->high;
    bool backwards = row->rhs < 0 && speed > 0 && row->force < 0 && row->force <= ALL * row->low;
    return forwards || backwards ? problem->step * row->force * speed : 0;
}

double pinch_contact_work(const pinch_problem *problem)
{
    double work = 0;
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        for (int i = 0; i < 4; i++)
            work += problem->step * c->force[i] * (c->relative_velocity[i] - c->surface_velocity[i]);
    }
    return work;
}

typedef struct gain_task {
    const pinch_step_bodies *bodies;
    pinch_range range;
    const pinch_problem *problem;
    int from; /* the first body */
    double gain[64], lag[64];
} gain_task;

static void sum_gains(void *argument, int first, int end)
{
    gain_task *task = argument;
    const pinch_problem *problem = task->problem;
    double gain = 0, lag = 0;
    for (int b = task->from + first; b < task->from + end; b++) {
        const pinch_body *body = &problem->bodies[b];
        dBodyID moved = pinch_island_body(task->bodies, task->range, b)->body;
        double before[6], weight = 0, change = 0;
        pinch_v3_copy(before, dBodyGetLinearVel(moved));
        pinch_v3_copy(before + 3, dBodyGetAngularVel(moved));
        for (int i = 0; i < 6; i++) {
            weight += body->external[i] * body->velocity_end[i];
            change += body->external[i] * (body->velocity_end[i] - before[i]);
        }
        weight += body->drive_force * pinch_v3_dot(body->drive_axis, body->velocity_end); /* of force control */
        gain += kinetic_energy(body, body->velocity_end) - kinetic_energy(body, before) - problem->step * weight;
        lag += 0.5 * problem->step * change;
    }
    task->lag[first / PINCH_CHUNK] = lag;
    task->gain[first / PINCH_CHUNK] = gain;
}

double pinch_kinetic_gain(const pinch_step_bodies *bodies, pinch_range range, const pinch_problem *problem, double *lag)
{
    gain_task task; /* whose sums are written before they are read */
    task.bodies = bodies;
    task.range = range;
    task.problem = problem;
    const int most = PINCH_CHUNK * (int)(sizeof task.gain / sizeof *task.gain);
    double gain = 0;
    *lag = 0;
    for (task.from = 0; task.from < problem->body_count; task.from += most) {
        int left = problem->body_count - task.from, count = left < most ? left : most;
        pinch_loop(problem->crew, count, sum_gains, &task);
        for (int k = 0; k < pinch_chunk_count(count); k++) {
            gain += task.gain[k];
            *lag += task.lag[k];
        }
    }
    return gain;
}

double pinch_joint_work(const pinch_joint_store *store, const pinch_island_joints *joints,
                        const pinch_step_bodies *bodies, pinch_range range, const pinch_problem *problem)
{
    double lag, gain = pinch_kinetic_gain(bodies, range, problem, &lag);
    return gain - driven_work(store, joints, problem) - pinch_contact_work(problem);
}

/* Of errors that ask for less than this, an upper bound of their energy is summed up, 1e-12 J/kg at most: rounding
 * makes such errors in all rows of a mechanism that moves. Rows are at least as long as their axis, which is a unit
 * vector. */
static const double LITTLE_ASKED_FOR = 1e-6; /* m/s, rad/s */

/* Where joints make a tree, it is lifted by this many times the velocity that gravity adds in a step. */
static const double FALLS = 10;

double pinch_weight_of_all(const pinch_problem *problem)
{
    double weight = 0;
    for (int b = 0; b < problem->body_count; b++) weight += pinch_v3_norm(problem->bodies[b].external);
    return weight;
}

/* Returns the sum of the torques (N m) that act on bodies from outside of the problem. */
static double torque_on_all(const pinch_problem *problem)
{
    double torque = 0;
    for (int b = 0; b < problem->body_count; b++) torque += pinch_v3_norm(problem->bodies[b].external + 3);
    return torque;
}

bool pinch_body_is_thrown(dBodyID body, const pinch_body *solved, double fall)
{
    double change[3];
    pinch_v3_sub(solved->velocity_end, dBodyGetLinearVel(body), change);
    return !(pinch_v3_norm(change) <= fall);
}

/* Returns the longest arm (m) at which weights may turn joints: of bodies from each other, or from an anchor. */
static double longest_arm(const pinch_problem *problem)
{
    double longest = 0;
    for (int b = 1; b < problem->body_count; b++) {
        double arm[3];
        pinch_v3_sub(problem->bodies[b].position, problem->bodies[0].position, arm);
        longest = fmax(longest, pinch_v3_norm(arm));
    }
    for (int k = 0; k < problem->row_count; k++) {
        const double *j = problem->rows[k].body1 >= 0 ? problem->rows[k].j1 : problem->rows[k].j2;
        double along = pinch_v3_norm(j);
        if (along > 0) longest = fmax(longest, pinch_v3_norm(j + 3) / along);
    }
    return longest;
}

/* Tells whether a body of a joint is thrown. */
static bool is_thrown(const pinch_step_bodies *bodies, const pinch_step_joint *joint, const pinch_problem *problem,
                      double fall)
{
    for (int side = 0; side < 2; side++) {
        const pinch_step_body *b = joint->body[side] < 0 ? NULL : &bodies->items[joint->body[side]];
        if (b && pinch_body_is_thrown(b->body, &problem->bodies[b->local], fall)) return true;
    }
    return false;
}

/* What loads a problem's joints from outside: all weights (N), torques (N m), and the longest arm (m) of weights. */
typedef struct loads {
    double weight, torque, arm;
} loads;

static loads loads_of(const pinch_problem *problem)
{
    return (loads){pinch_weight_of_all(problem), torque_on_all(problem), longest_arm(problem)};
}

/* Returns what a force of all these does at most along a row. *lever: what the weight has of that. */
static double load_along(const loads *all, const pinch_joint_row *row, double *lever)
{
    const double *j = row->body1 >= 0 ? row->j1 : row->j2;
    double along = pinch_v3_norm(j);
    *lever = along > 0 ? along : all->arm * pinch_v3_norm(j + 3);
    return all->weight * *lever + (along > 0 ? 0 : all->torque * pinch_v3_norm(j + 3));
}

/* Tells whether rows ask for different things. */
static bool rows_contradict(const pinch_problem *problem)
{
    static const double MISSED = 1e-9; /* m/s, rad/s */
    for (int k = 0; k < problem->row_count; k++)
        if (fabs(problem->rows[k].violation) > MISSED) return true;
    return false;
}

double pinch_work_of_closing(const pinch_joint_store *store, const pinch_island_joints *joints,
                             const pinch_problem *problem, bool jammed)
{
    if (rows_contradict(problem)) return 0;
    bool known = false;
    loads all = {0};
    double lever, work = 0;
    for (int k = 0; k < joints->range.count; k++) {
        const pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        const pinch_joint_row *row = problem->rows + joint->rows.first;
        for (int i = 0; i < joint->rows.count; i++) {
            if (fabs(joint->closing[i]) < LITTLE_ASKED_FOR) continue;
            if (!known) all = loads_of(problem); /* most steps have nothing to close */
            known = true;
            double force = load_along(&all, &row[i], &lever);
            if (!jammed) force = fmax(fabs(row[i].force), force);
            work += problem->step * force * fabs(joint->closing[i]);
        }
    }
    return work;
}

double pinch_joint_lifting(const pinch_joint_store *store, const pinch_island_joints *joints,
                           const pinch_step_bodies *bodies, const pinch_problem *problem, bool loops, double fall)
{
    loads all = loads_of(problem);
    double lever, work = 0;
    for (int k = 0; k < joints->range.count; k++) {
        const pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        const pinch_joint_row *row = problem->rows + joint->rows.first;
        if (loops && is_thrown(bodies, joint, problem, fall)) continue;
        for (int i = 0; i < joint->rows.count; i++) {
            double closing = joint->closing[i], asked = joints->pace * fabs(closing);
            if (fabs(closing) < LITTLE_ASKED_FOR) continue;
            double load = load_along(&all, &row[i], &lever);
            if (!loops) asked = fmin(asked, FALLS * fall / lever);
            double speed = closing > 0 ? velocity_along(problem, &row[i]) : -velocity_along(problem, &row[i]);
            work += problem->step * fmin(fabs(row[i].force), load) * fmin(speed, asked);
        }
    }
    return fmax(work, 0);
}

double pinch_energy_in_motion(const pinch_problem *problem)
{
    double mass = 0, momentum[3] = {0, 0, 0}, energy = 0;
    for (int b = 0; b < problem->body_count; b++) {
        const pinch_body *body = &problem->bodies[b];
        mass += body->mass;
        pinch_v3_add_scaled(momentum, body->mass, body->velocity);
        energy += kinetic_energy(body, body->velocity);
    }
    return mass > 0 ? fmax(energy - 0.5 * pinch_v3_dot(momentum, momentum) / mass, 0) : 0;
}

/* Returns the energy (J) of the row's two bodies where they move along the row as fast as its error asks for. */
static double energy_asked_for(const pinch_problem *problem, const pinch_joint_row *row, double closing)
{
    double length2 = 0, resists = 0;
    for (int side = 0; side < 2 && closing != 0; side++) {
        int body = side ? row->body2 : row->body1;
        const double *j = side ? row->j2 : row->j1;
        if (body < 0) continue;
        for (int i = 0; i < 6; i++) length2 += j[i] * j[i];
        resists += 2 * kinetic_energy(&problem->bodies[body], j);
    }
    return length2 > 0 ? 0.5 * closing * closing * resists / (length2 * length2) : 0;
}

/* Returns the most that a body's inertia resists along a row, as a part of the square of the row's length. */
static double most_resistance(const pinch_problem *problem, int body)
{
    const pinch_body *b = body < 0 ? NULL : &problem->bodies[body];
    return b ? pinch_larger(b->mass, b->inertia[0] + b->inertia[4] + b->inertia[8]) : 0;
}

double pinch_energy_of_errors(const pinch_joint_store *store, const pinch_island_joints *joints,
                              const pinch_problem *problem)
{
    double energy = 0;
    for (int k = 0; k < joints->range.count; k++) {
        const pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        const pinch_joint_row *row = &problem->rows[joint->rows.first];
        double little = 0;
        for (int i = 0; i < joint->rows.count; i++) {
            double closing = joint->closing[i];
            if (fabs(closing) < LITTLE_ASKED_FOR)
                little += closing * closing;
            else
                energy += energy_asked_for(problem, &row[i], closing);
        }
        if (little > 0)
            energy +=
                0.5 * little * pinch_larger(most_resistance(problem, row->body1), most_resistance(problem, row->body2));
    }
    return energy;
}

void pinch_set_closing_pace(const pinch_joint_store *store, const pinch_island_joints *joints, pinch_problem *problem,
                            double from, double to)
{
    for (int k = 0; k < joints->range.count; k++) {
        const pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        for (int i = 0; i < joint->rows.count; i++)
            problem->rows[joint->rows.first + i].rhs += (to - from) * joint->closing[i];
    }
}
