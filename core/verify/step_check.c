/*
 * The laws of a step, each written out in a function of its own (equations of core/README.md):
 *
 *     momentum balance     momentum_residual, drive_residual, is_rounding_of_tree          (48) (59)
 *     normal law           check_normal_law                                                (49)
 *     friction cone        check_friction_cone; check_facets where it is linearized        (50)
 *     sticking             check_sticking                                                  (51)
 *     slip direction       check_slip_direction                                            (52)
 *     torsion, rolling     the same three, where they have limits of their own
 *
 * Joint rows have their law in row_check.c (55); here their forces enter the momentum balance.
 */
#include "verify/step_check.h"

#include "verify/check_arithmetic.h"
#include "verify/row_check.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* What several contacts or laws add to one figure is the largest of theirs, or no number where one of them is none. */
static inline void note_largest(double *figure, double value)
{
    if (!(value <= *figure) && !isnan(*figure)) *figure = value;
}

static double held_within(double value, double limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

static double square(double a)
{
    return a * a;
}

static void cross_add(const double *a, const double *b, double sign, double *c)
{
    c[0] += sign * (a[1] * b[2] - a[2] * b[1]);
    c[1] += sign * (a[2] * b[0] - a[0] * b[2]);
    c[2] += sign * (a[0] * b[1] - a[1] * b[0]);
}

/* The impulses on a body, with their sign turned (6), and what they are measured against: linear and angular sums of
 * magnitudes. */
typedef struct balance {
    double left[6];
    double force_size, torque_size;
} balance;

/* A contact, with what several checks of it need. */
typedef struct contact_view {
    const pinch_contact *c;
    double t2[3];
    const pinch_body *body[2]; /* NULL: not of the problem */
    double arm[2][3];          /* from the bodies' centres of mass */
    double rounding[2];        /* m/s, rad/s: of its velocities and spins; 0 where it is not asked for */
} contact_view;

static void view_contact(const pinch_problem *problem, const pinch_contact *c, contact_view *v)
{
    const int body[2] = {c->body1, c->body2};
    v->c = c;
    v->rounding[0] = v->rounding[1] = 0;
    memset(v->t2, 0, sizeof v->t2);
    cross_add(c->normal, c->tangent1, 1, v->t2);
    for (int side = 0; side < 2; side++) {
        v->body[side] = body[side] < 0 ? NULL : &problem->bodies[body[side]];
        for (int i = 0; i < 3 && v->body[side]; i++) v->arm[side][i] = c->position[i] - v->body[side]->position[i];
    }
}

/* Takes the contact's impulse off what is left of its two bodies' momentum. */
static void add_contact_impulse(const pinch_problem *problem, balance *balances, const contact_view *v,
                                pinch_step_result *check)
{
    const pinch_contact *c = v->c;
    const double *n = c->normal, *t = c->tangent1, *r = c->force, h = problem->step;
    double force[3], couple[3];
    for (int i = 0; i < 3; i++) {
        force[i] = r[0] * n[i] + r[1] * t[i] + r[2] * v->t2[i];
        couple[i] = r[3] * n[i];
        if (c->model == PINCH_CONTACT_ROLLING)
            couple[i] += c->rolling_moment[0] * t[i] + c->rolling_moment[1] * v->t2[i];
    }
    double size = pinch_check_norm3(r); /* as of the force: the frame is unit and square */
    for (int side = 0; side < 2; side++) {
        if (!v->body[side]) continue;
        balance *b = &balances[v->body[side] - problem->bodies];
        double away = side ? h : -h, torque[3] = {couple[0], couple[1], couple[2]};
        cross_add(v->arm[side], force, 1, torque);
        for (int i = 0; i < 3; i++) {
            b->left[i] += away * force[i];
            b->left[3 + i] += away * torque[i];
        }
        b->force_size += h * size;
        b->torque_size += h * pinch_check_norm3(torque);
    }
    note_largest(&check->force_scale, size);
}

static void add_joint_impulses(const pinch_problem *problem, balance *balances)
{
    for (int k = 0; k < problem->row_count; k++) {
        const pinch_joint_row *row = &problem->rows[k];
        const int body[2] = {row->body1, row->body2};
        const double *j[2] = {row->j1, row->j2}, impulse = problem->step * row->force, size = fabs(impulse);
        for (int side = 0; side < 2; side++) {
            if (body[side] < 0) continue;
            balance *b = &balances[body[side]];
            double part[6];
            for (int i = 0; i < 6; i++) part[i] = impulse * j[side][i];
            for (int i = 0; i < 6; i++) b->left[i] -= part[i];
            double length[2] = {pinch_check_square3(j[side]), pinch_check_square3(j[side] + 3)};
            for (int i = 0; i < 2; i++) length[i] = sqrt(length[i]); /* both at once */
            b->force_size += size * length[0];
            b->torque_size += size * length[1];
        }
    }
}

/* Returns what the last bits of the velocities are as momentum. A body that flies freely has no forces to measure
 * against, and changes its velocity by no more than this. */
static double momentum_rounding(const pinch_body *body)
{
    static const double ROUNDINGS = 16; /* of the elimination of joint rows and of the products here */
    double angular[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            angular[i] +=
                fabs(body->inertia[3 * i + j]) * (fabs(body->velocity[3 + j]) + fabs(body->velocity_end[3 + j]));
    double linear = body->mass * (pinch_check_norm3(body->velocity) + pinch_check_norm3(body->velocity_end));
    return ROUNDINGS * DBL_EPSILON * (linear + pinch_check_norm3(angular) / body->radius);
}

/* A massless drive balances the forces along its axis alone. */
static double drive_residual(const pinch_problem *problem, const pinch_body *body, const balance *b)
{
    double left = -problem->step * body->drive_force;
    for (int i = 0; i < 3; i++) left += b->left[i] * body->drive_axis[i];
    double size = b->force_size + problem->step * fabs(body->drive_force);
    return size > 0 ? fabs(left) / size : 0;
}

/* What is left over of a body's momentum (1): what it gained, less the impulses on it, and the size of both. */
static double left_over(const pinch_problem *problem, const pinch_body *body, const balance *b, double left[6])
{
    double change[6], gained[6];
    for (int i = 0; i < 6; i++) change[i] = body->velocity_end[i] - body->velocity[i];
    for (int i = 0; i < 3; i++) {
        gained[i] = body->mass * change[i];
        gained[3 + i] = 0;
        for (int j = 0; j < 3; j++) gained[3 + i] += body->inertia[3 * i + j] * change[3 + j];
    }
    for (int i = 0; i < 6; i++) left[i] = b->left[i] + gained[i];
    return b->force_size + problem->step * pinch_check_norm3(body->external) + pinch_check_norm3(gained) +
           (b->torque_size + problem->step * pinch_check_norm3(body->external + 3) + pinch_check_norm3(gained + 3)) /
               body->radius;
}

/* The momentum balance (1) of one body: what is left over, relative to what the body gained and to its impulses. */
static double momentum_residual(const pinch_problem *problem, const pinch_body *body, const balance *b)
{
    double over[6];
    if (body->mass == 0) return drive_residual(problem, body, b);
    double size = left_over(problem, body, b, over), rounding = momentum_rounding(body);
    double linear = pinch_check_norm3(over), angular = pinch_check_norm3(over + 3) / body->radius,
           left = sqrt(linear * linear + angular * angular);
    return size > 0 && left > rounding ? left / size : 0;
}

/* Finds what of a contact's velocity may be rounding: it is a difference of its bodies' motions. */
static void find_rounding(contact_view *v)
{
    static const double ROUNDINGS = 16; /* of the solution of the bodies' velocities and of the products here */
    double speed = 0, spin = 0;
    for (int side = 0; side < 2; side++) {
        if (!v->body[side]) continue;
        const double *end = v->body[side]->velocity_end, turns = pinch_check_norm3(end + 3);
        speed += pinch_check_norm3(end) + turns * pinch_check_norm3(v->arm[side]);
        spin += turns;
    }
    v->rounding[0] = ROUNDINGS * DBL_EPSILON * speed;
    v->rounding[1] = ROUNDINGS * DBL_EPSILON * spin;
}

/* w = G v+ + surface_velocity from the end velocities of the two bodies */
static void relative_velocity(const contact_view *v, double w[6])
{
    const pinch_contact *c = v->c;
    double linear[3] = {0, 0, 0}, spin[3] = {0, 0, 0};
    for (int side = 0; side < 2; side++) {
        if (!v->body[side]) continue;
        const double *end = v->body[side]->velocity_end, sign = side ? -1 : 1;
        for (int i = 0; i < 3; i++) {
            linear[i] += sign * end[i];
            spin[i] += sign * end[3 + i];
        }
        cross_add(end + 3, v->arm[side], sign, linear);
    }
    const double *axes[3] = {c->normal, c->tangent1, v->t2};
    for (int i = 0; i < 3; i++)
        w[i] = c->surface_velocity[i] + axes[i][0] * linear[0] + axes[i][1] * linear[1] + axes[i][2] * linear[2];
    for (int i = 0; i < 3 && c->model >= PINCH_CONTACT_SOFT; i++)
        w[3 + i] = c->surface_velocity[3 + i] + axes[i][0] * spin[0] + axes[i][1] * spin[1] + axes[i][2] * spin[2];
}

/* Returns how far a contact gives way in a row, (m/s)/N or (rad/s)/(N m). */
static double gives_way(const pinch_problem *problem, const pinch_contact *c, int row)
{
    int kind = row == 0 ? 0 : row < 3 ? 1 : 2;
    if (kind == 1 && c->viscous[row - 1] > 0) return c->viscous[row - 1];
    return 1 / (problem->step * c->stiffness[kind] + c->damping[kind]);
}

/*
 * Equation (53): the error of a stiff contact counts as the velocity by which it misses its law, times the inertia that
 * would have to be moved. 1/(h k + c) turns a force into the missed velocity, 1/m + |arm x axis|^2 / I turns a force
 * into the velocity of the free bodies.
 */
static double stiff_error_share(const pinch_problem *problem, const contact_view *v, int row, const double axis[3])
{
    double gives = gives_way(problem, v->c, row), moves = 0;
    for (int side = 0; side < 2; side++) {
        const pinch_body *b = v->body[side];
        double lever[3] = {0, 0, 0}, turns[3];
        if (!b) continue;
        if (row < 3)
            cross_add(v->arm[side], axis, 1, lever);
        else
            memcpy(lever, axis, sizeof lever);
        pinch_check_solve3(b->inertia, lever, turns);
        moves += (row < 3 ? 1 / b->mass : 0) + lever[0] * turns[0] + lever[1] * turns[1] + lever[2] * turns[2];
    }
    return gives / (gives + problem->step * moves);
}

/* Notes by how much a force misses its law in a row. For compliant contacts, where the two are alike, the law itself is
 * the measure and the factor is 1. The factor is never more than that, nor than without levers, to the last bit, and is
 * not found where the error cannot be the largest. */
static inline void note_error(double *largest, double error, const pinch_problem *problem, const contact_view *v,
                              int row, const double axis[3])
{
    if (error <= *largest) return;
    double rounding = v->rounding[row < 3 ? 0 : 1];
    if (rounding > 0 && error * gives_way(problem, v->c, row) <= rounding) return;
    if (!v->c->may_soften) {
        note_largest(largest, error);
        return;
    }
    double gives = gives_way(problem, v->c, row), masses = 0;
    for (int side = 0; side < 2 && row < 3; side++)
        if (v->body[side]) masses += 1 / v->body[side]->mass;
    if (error * (gives / (gives + problem->step * masses)) <= *largest) return;
    note_largest(largest, error * stiff_error_share(problem, v, row, axis));
}

/* One friction row of a contact, with all that its laws need. */
typedef struct friction_row {
    int row; /* of the contact */
    double force, trial;
    double limit, over; /* semi-axis of the limit surface and its inverse; both 0 where there is none */
    double conductance; /* h k + c: how the trial force follows the velocity */
    const double *axis;
} friction_row;

/* Equation (5). An infinite coefficient gives nothing where there is no normal force. */
static double semi_axis(double friction, double limit, double normal)
{
    return normal > 0 ? limit + friction * normal : limit;
}

/* The force of a spring and damper that has stood at `elastic` and moves at w: the trial force (4). */
static double trial_force(double step, double stiffness, double damping, double elastic, double w)
{
    return -stiffness * (elastic + step * w) - damping * w;
}

/* The normal law (3): a spring and damper that only pushes, up to the limit of force. */
static void check_normal_law(const pinch_problem *problem, const contact_view *v, double w, pinch_step_result *check)
{
    const pinch_contact *c = v->c;
    double normal = c->stiffness[0] * (c->depth - problem->step * w) - c->damping[0] * w;
    if (normal < 0) normal = 0;
    if (normal > c->max_force) normal = c->max_force;
    note_error(&check->complementarity, fabs(c->force[0] - normal), problem, v, 0, c->normal);
}

/*
 * The linearized cone (9): no facet may be exceeded, n_k . r <= mu r_n, and what the trial force has beyond r has to
 * lie in the outward normals there: for a convex polygon, beyond . (p - r) <= 0 for each corner p.
 */
static void check_polygon(int faces, double limit, const double *trial, const double *r, pinch_step_result *check)
{
    const double pi = 3.14159265358979323846;
    double beyond[2] = {trial[0] - r[0], trial[1] - r[1]}, inwards = 0;
    for (int k = 0; k < faces && !isinf(limit); k++) {
        double angle = 2 * pi * k / faces, half = pi / faces;
        note_largest(&check->cone, cos(angle) * r[0] + sin(angle) * r[1] - limit);
        double corner[2] = {limit / cos(half) * cos(angle + half), limit / cos(half) * sin(angle + half)};
        if (faces == 2) { /* a strip has sides and no corners */
            corner[0] = k ? -limit : limit;
            corner[1] = r[1];
        }
        inwards = pinch_check_larger(beyond[0] * (corner[0] - r[0]) + beyond[1] * (corner[1] - r[1]), inwards);
    }
    double size = sqrt(square(trial[0]) + square(trial[1]));
    if (size > limit)
        note_largest(&check->slip_direction, inwards / size);
    else
        note_largest(&check->complementarity, sqrt(square(beyond[0]) + square(beyond[1])));
}

/* Friction with a linearized cone, where torsion has its own limit. */
static void check_facets(const pinch_problem *problem, const pinch_contact *c, const double w[6],
                         pinch_step_result *check)
{
    double trial[3];
    for (int i = 0; i < 3; i++) {
        int kind = i < 2 ? 1 : 2;
        trial[i] = trial_force(problem->step, c->stiffness[kind], c->damping[kind], c->elastic[i], w[1 + i]);
    }
    check_polygon(problem->faces, semi_axis(c->friction[0], 0, c->force[0]), trial, c->force + 1, check);
    if (c->model != PINCH_CONTACT_SOFT) return;
    double torsion = held_within(trial[2], semi_axis(c->torsional_friction, 0, c->force[0]));
    note_largest(&check->complementarity, fabs(c->force[3] - torsion));
}

/* N or N m: less is no friction, far below the smallest force that counts. The inverse of its fourth power, as the slip
 * direction has it, is a number with room for stiff springs and large forces. */
static void set_limit(friction_row *row, double limit)
{
    static const double SMALLEST = 1e-60;
    row->limit = limit < SMALLEST ? 0 : limit;
    row->over = row->limit > 0 ? 1 / limit : 0;
}

/* The friction rows that share one limit surface: the tangents, and torsion of a soft contact. Returns how many. */
static int friction_rows(const pinch_problem *problem, const contact_view *v, const double w[6], friction_row rows[3])
{
    const pinch_contact *c = v->c;
    const double *axes[3] = {c->tangent1, v->t2, c->normal};
    const double friction[3] = {c->friction[0], c->friction[1], c->torsional_friction};
    int count = c->model == PINCH_CONTACT_SOFT ? 3 : 2;
    for (int i = 0; i < count; i++) {
        double k = c->stiffness[i < 2 ? 1 : 2], d = c->damping[i < 2 ? 1 : 2];
        double conductance = problem->step * k + d;
        if (i < 2 && c->viscous[i] > 0) { /* no spring: it gives way at this rate */
            k = 0;
            d = conductance = 1 / c->viscous[i];
        }
        rows[i] = (friction_row){.row = 1 + i,
                                 .force = c->force[1 + i],
                                 .trial = trial_force(problem->step, k, d, c->elastic[i], w[1 + i]),
                                 .conductance = conductance,
                                 .axis = axes[i]};
        set_limit(&rows[i], semi_axis(friction[i], c->friction_limit[i], c->force[0]));
    }
    return count;
}

/* The rows of a contact that rolls which have limits of their own: torsion, and the two of rolling, which share one. */
static void rolling_rows(const pinch_problem *problem, const contact_view *v, const double w[6], friction_row rows[3])
{
    const pinch_contact *c = v->c;
    const double *axes[3] = {c->normal, c->tangent1, v->t2};
    const double friction[3] = {c->torsional_friction, c->rolling_friction[0], c->rolling_friction[1]};
    const double moment[3] = {c->force[3], c->rolling_moment[0], c->rolling_moment[1]};
    const double elastic[3] = {c->elastic[2], c->rolling_elastic[0], c->rolling_elastic[1]};
    double k = c->stiffness[2], d = c->damping[2];
    for (int i = 0; i < 3; i++) {
        rows[i] = (friction_row){.row = 3 + i,
                                 .force = moment[i],
                                 .trial = trial_force(problem->step, k, d, elastic[i], w[3 + i]),
                                 .conductance = problem->step * k + d,
                                 .axis = axes[i]};
        set_limit(&rows[i], semi_axis(friction[i], c->friction_limit[2 + i], c->force[0]));
    }
}

static double largest_limit(const friction_row *rows, int count)
{
    double largest = 0;
    for (int i = 0; i < count && i < 2; i++)
        if (!isinf(rows[i].limit)) largest = pinch_check_larger(rows[i].limit, largest);
    return largest;
}

/* The friction cone (6): friction may not leave the limit surface. Returns how far it reaches, squared, 1: up to the
 * surface. */
static double check_friction_cone(const friction_row *rows, int count, pinch_step_result *check)
{
    double reach = 0, force = 0;
    for (int i = 0; i < count; i++) {
        if (rows[i].limit > 0)
            reach += square(rows[i].force * rows[i].over);
        else
            force += square(rows[i].force); /* no friction here: all of it is excess */
    }
    if (!(reach <= 1)) note_largest(&check->cone, (sqrt(reach) - 1) * largest_limit(rows, count));
    if (force != 0) note_largest(&check->cone, sqrt(force));
    return reach;
}

/* How far the trial force reaches, squared; beyond 1 the contact slips. */
static double trial_reach(const friction_row *rows, int count)
{
    double reach = 0;
    for (int i = 0; i < count; i++)
        if (rows[i].limit > 0) reach += square(rows[i].trial * rows[i].over);
    return reach;
}

/* Sticking: friction is the force of the spring and damper itself. */
static void check_sticking(const pinch_problem *problem, const contact_view *v, const friction_row *rows, int count,
                           pinch_step_result *check)
{
    for (int i = 0; i < count; i++)
        if (rows[i].limit > 0)
            note_error(&check->complementarity, fabs(rows[i].force - rows[i].trial), problem, v, rows[i].row,
                       rows[i].axis);
}

/*
 * The slip direction: a contact slips along the outward normal of the limit surface, (trial - r) / g = p r / limit^2
 * with p > 0. The part of trial - r off that direction is an error of the trial force; of r it is smaller by the ratio
 * of the two.
 */
static void check_slip_direction(const pinch_problem *problem, const contact_view *v, const friction_row *rows,
                                 int count, pinch_step_result *check)
{
    double beyond[3] = {0, 0, 0}, outward[3] = {0, 0, 0}, along = 0, outward2 = 0, off = 0;
    double largest = largest_limit(rows, count);
    for (int i = 0; i < count; i++) {
        double limit = rows[i].limit;
        if (!(limit > 0) || isinf(limit)) continue;
        double unit = largest / limit; /* m for the torsional component, so that all are newtons */
        beyond[i] = (rows[i].trial - rows[i].force) * unit;
        outward[i] = rows[i].conductance * rows[i].force / (limit * limit) * unit;
        along += beyond[i] * outward[i];
        outward2 += outward[i] * outward[i];
    }
    double p = outward2 > 0 && along > 0 ? along / outward2 : 0;
    for (int i = 0; i < count; i++) off += square(beyond[i] - p * outward[i]);
    note_error(&check->slip_direction, sqrt(off / trial_reach(rows, count)), problem, v, rows->row, rows->axis);
}

/* The laws of friction of rows that share a limit surface. */
static void check_friction(const pinch_problem *problem, const contact_view *v, const friction_row *rows, int count,
                           pinch_step_result *check)
{
    double reach = check_friction_cone(rows, count, check);
    if (trial_reach(rows, count) <= 1) {
        check_sticking(problem, v, rows, count, check);
        return;
    }
    check_slip_direction(problem, v, rows, count, check);
    /* what slips is at its limit */
    note_largest(&check->complementarity, largest_limit(rows, count) * fabs(1 - sqrt(reach)));
}

/* All laws of one contact, each written in full. */
static void check_contact(const pinch_problem *problem, const contact_view *v, pinch_step_result *check)
{
    const pinch_contact *c = v->c;
    double w[6];
    friction_row rows[3];
    relative_velocity(v, w);
    check_normal_law(problem, v, w[0], check);
    if (c->model == PINCH_CONTACT_FRICTIONLESS) {
        note_largest(&check->cone, sqrt(c->force[1] * c->force[1] + c->force[2] * c->force[2]));
        return;
    }
    if (problem->faces) {
        check_facets(problem, c, w, check);
        return;
    }
    check_friction(problem, v, rows, friction_rows(problem, v, w, rows), check);
    if (c->model != PINCH_CONTACT_ROLLING) return;
    rolling_rows(problem, v, w, rows);
    check_friction(problem, v, rows, 1, check);
    check_friction(problem, v, rows + 1, 2, check);
}

/*
 * Returns what the velocities of a body have been summed up from, in the metric of its inertia: the motions that it
 * began and ended with and all impulses on it, those that cancel each other included. Rounding is relative to this.
 */
static double motion_of(const pinch_body *body, const balance *b)
{
    if (body->mass == 0) return 0;
    double energy = 0, slowest = 0;
    for (int i = 0; i < 3; i++) {
        double momentum[2] = {0, 0}, axis[3] = {i == 0, i == 1, i == 2}, turns[3];
        for (int j = 0; j < 3; j++) {
            momentum[0] += body->inertia[3 * i + j] * body->velocity[3 + j];
            momentum[1] += body->inertia[3 * i + j] * body->velocity_end[3 + j];
        }
        energy += body->mass * (square(body->velocity[i]) + square(body->velocity_end[i])) +
                  body->velocity[3 + i] * momentum[0] + body->velocity_end[3 + i] * momentum[1];
        pinch_check_solve3(body->inertia, axis, turns);
        slowest += turns[i];
    }
    return sqrt(energy) + b->force_size / sqrt(body->mass) + b->torque_size * sqrt(slowest);
}

/* Finds for each body the largest rounding of the velocities of its contacts, m/s. */
static void find_roundings_of_bodies(const pinch_problem *problem, double *rounding)
{
    for (int b = 0; b < problem->body_count; b++) rounding[b] = 0;
    for (int k = 0; k < problem->contact_count; k++) {
        contact_view v;
        view_contact(problem, &problem->contacts[k], &v);
        find_rounding(&v);
        for (int side = 0; side < 2; side++)
            if (v.body[side]) note_largest(&rounding[v.body[side] - problem->bodies], v.rounding[0]);
    }
}

/* Is what is left of a body's momentum rounding of the velocities of its contacts? A body at rest may have nothing
 * else, where what comes near it does not touch it. */
static bool is_rounding_of_contacts(const pinch_problem *problem, const pinch_body *b, const balance *of,
                                    double rounding)
{
    double left[6];
    (void)left_over(problem, b, of, left);
    return pinch_check_norm3(left) + pinch_check_norm3(left + 3) / b->radius <= b->mass * rounding;
}

/* Is what is left of a body's momentum rounding of the forces in its tree of joints (59)? */
static bool is_rounding_of_tree(const pinch_problem *problem, const pinch_body *b, const balance *of,
                                double tree_motion)
{
    static const double ROUNDINGS = 64;
    double left[6], turns[3], length2 = 0;
    (void)left_over(problem, b, of, left);
    pinch_check_solve3(b->inertia, left + 3, turns);
    for (int i = 0; i < 3; i++) length2 += square(left[i]) / b->mass + left[3 + i] * turns[i];
    return sqrt(length2) <= ROUNDINGS * DBL_EPSILON * tree_motion;
}

/* Where a crew shares a check, what the parts find is the largest of each, whoever does them. Fewer items than FEW are
 * not worth it. */
enum { PARTS = 32, FEW = 256 };

typedef struct momentum_check {
    const pinch_problem *problem;
    const balance *balances;
    double found[PARTS];
} momentum_check;

static int part_of(int count, int k)
{
    return (int)((long long)count * k / PARTS);
}

static double largest_of_bodies(const pinch_problem *problem, const balance *balances, int first, int end)
{
    double largest = 0;
    for (int b = first; b < end; b++)
        note_largest(&largest, momentum_residual(problem, &problem->bodies[b], &balances[b]));
    return largest;
}

static void check_momentum_part(void *argument, int first, int end)
{
    momentum_check *s = argument;
    int count = s->problem->body_count;
    for (int k = first; k < end; k++)
        s->found[k] = largest_of_bodies(s->problem, s->balances, part_of(count, k), part_of(count, k + 1));
}

static double largest_momentum_residual(const pinch_problem *problem, const balance *balances)
{
    momentum_check s;
    double largest = 0;
    if (!problem->crew || problem->body_count <= FEW)
        return largest_of_bodies(problem, balances, 0, problem->body_count);
    s.problem = problem;
    s.balances = balances;
    problem->crew->parallel_for(problem->crew->context, PARTS, 1, check_momentum_part, &s);
    for (int k = 0; k < PARTS; k++) note_largest(&largest, s.found[k]);
    return largest;
}

/* The largest momentum residual. Where one is above `most`, trees and contacts are looked at. scratch: 3 doubles per
 * body */
static void check_momentum(const pinch_problem *problem, double most, const balance *balances, double *scratch,
                           pinch_step_result *check)
{
    double *motion = scratch, *tree_motion = motion + problem->body_count,
           *rounding = tree_motion + problem->body_count;
    note_largest(&check->residual_max, largest_momentum_residual(problem, balances));
    if (check->residual_max <= most) return;
    for (int b = 0; b < problem->body_count; b++) motion[b] = motion_of(&problem->bodies[b], &balances[b]);
    if (problem->row_count > 0) pinch_tree_motions(problem, motion, tree_motion);
    find_roundings_of_bodies(problem, rounding); /* in what was scratch of the trees */
    check->residual_max = 0;
    for (int b = 0; b < problem->body_count; b++) {
        const pinch_body *body = &problem->bodies[b];
        double residual = momentum_residual(problem, body, &balances[b]);
        bool rounded = !(residual <= most) && body->mass > 0 &&
                       (is_rounding_of_contacts(problem, body, &balances[b], rounding[b]) ||
                        (problem->row_count > 0 && is_rounding_of_tree(problem, body, &balances[b], tree_motion[b])));
        if (!rounded) note_largest(&check->residual_max, residual);
    }
}

/* Are the laws of contacts checked, and do errors count that may be rounding of velocities? */
typedef enum law_check { NO_LAWS, LAWS, LAWS_BUT_ROUNDING } law_check;

/* Checks the laws of some contacts, or takes their impulses off what is left of the bodies' momentum (balances), or
 * both. */
static void check_some(const pinch_problem *problem, int first, int end, law_check laws, balance *balances,
                       pinch_step_result *check)
{
    for (int k = first; k < end; k++) {
        contact_view v;
        view_contact(problem, &problem->contacts[k], &v);
        if (balances) add_contact_impulse(problem, balances, &v, check);
        if (laws == LAWS_BUT_ROUNDING) find_rounding(&v);
        if (laws != NO_LAWS) check_contact(problem, &v, check);
    }
}

/* A check that a crew shares. The impulses, which are summed up in the order of contacts, are a part of their own, and
 * the first. */
typedef struct shared_check {
    const pinch_problem *problem;
    law_check laws;
    balance *balances;
    pinch_step_result found[PARTS];
} shared_check;

static void check_part(void *argument, int first, int end)
{
    shared_check *s = argument;
    long long count = s->problem->contact_count;
    for (int k = first; k < end; k++) {
        int from = (int)(count * (k - 1) / (PARTS - 1)), to = (int)(count * k / (PARTS - 1));
        if (k > 0)
            check_some(s->problem, from, to, s->laws, NULL, &s->found[k]);
        else if (s->balances)
            check_some(s->problem, 0, (int)count, NO_LAWS, s->balances, &s->found[k]);
    }
}

/* Checks the laws of all contacts, and takes their impulses off the balances where these are given. */
static void check_all(const pinch_problem *problem, law_check laws, balance *balances, pinch_step_result *check)
{
    shared_check s;
    if (!problem->crew || problem->contact_count <= FEW) {
        check_some(problem, 0, problem->contact_count, laws, balances, check);
        return;
    }
    memset(&s, 0, sizeof s);
    s.problem = problem;
    s.laws = laws;
    s.balances = balances;
    problem->crew->parallel_for(problem->crew->context, PARTS, 1, check_part, &s);
    for (int k = 0; k < PARTS; k++) {
        note_largest(&check->force_scale, s.found[k].force_scale);
        note_largest(&check->cone, s.found[k].cone);
        note_largest(&check->complementarity, s.found[k].complementarity);
        note_largest(&check->slip_direction, s.found[k].slip_direction);
    }
}

bool pinch_step_verify(const pinch_problem *problem, double tolerance, double *scratch, pinch_step_result *result)
{
    /* relative, and N for contacts that hardly touch: the laws are evaluated, not iterated, so that they hold to
     * rounding or something is wrong */
    static const double LAW_TOLERANCE = 1e-9, SMALLEST_FORCE = 1e-12;
    /* the residual is measured body by body, the solver's tolerance over the island: a light body among heavy ones may
     * show more */
    static const double LIGHTEST_BODY = 100;
    balance *balances = (balance *)(void *)scratch;
    double *motion = scratch + sizeof(balance) / sizeof(double) * (size_t)problem->body_count;
    result->residual_max = result->cone = result->complementarity = result->slip_direction = result->force_scale = 0;
    memset(balances, 0, sizeof(balance) * (size_t)problem->body_count);
    check_all(problem, LAWS, balances, result);
    add_joint_impulses(problem, balances);
    check_momentum(problem, LIGHTEST_BODY * tolerance, balances, motion, result);
    bool rows_hold = pinch_row_check(problem, NULL, result);
    if (!rows_hold) { /* of many rows, few are so close to zero that their rounding has to be known */
        for (int b = 0; b < problem->body_count; b++) motion[b] = motion_of(&problem->bodies[b], &balances[b]);
        rows_hold = pinch_row_check(problem, motion, result);
    }
    double law = LAW_TOLERANCE * result->force_scale + SMALLEST_FORCE;
    if (!(result->complementarity <= law && result->slip_direction <= law)) { /* forces may be as small as rounding */
        result->cone = result->complementarity = result->slip_direction = 0;
        check_all(problem, LAWS_BUT_ROUNDING, NULL, result);
    }
    return result->residual_max <= LIGHTEST_BODY * tolerance && result->cone <= law && result->complementarity <= law &&
           result->slip_direction <= law && rows_hold;
}
