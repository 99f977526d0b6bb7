#include "support/referee.h"

#include "support/arithmetic.h"
#include "support/cmocka_all.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

static double larger(double a, double b)
{
    return a > b || isnan(a) ? a : b;
}

/* The velocity of the body's material point and its angular velocity; zero for the static world. */
static void point_velocity(const pinch_problem *p, int body, const double *x, double linear[3], double angular[3])
{
    memset(linear, 0, 3 * sizeof *linear);
    memset(angular, 0, 3 * sizeof *angular);
    if (body < 0) return;
    const double *v = p->bodies[body].velocity_end;
    double arm[3];
    for (int i = 0; i < 3; i++) arm[i] = x[i] - p->bodies[body].position[i];
    memcpy(angular, v + 3, 3 * sizeof *angular);
    cross(angular, arm, linear);
    for (int i = 0; i < 3; i++) linear[i] += v[i];
}

/*
 * The closest point of sum (r_i / a_i)^2 <= 1 to s in the metric sum (r_i - s_i)^2 / g_i, by bisection for the
 * multiplier m >= 0 of  (s_i - r_i) / g_i = m r_i / a_i^2,  i.e.  r_i = s_i / (1 + m g_i / a_i^2).
 */
static void closest(int n, const double *a, const double *g, const double *s, double *r)
{
    double low = 0, high = 1, reach = 0;
    for (int i = 0; i < n; i++) {
        r[i] = a[i] > 0 ? s[i] : 0;
        if (a[i] > 0) reach += s[i] / a[i] * (s[i] / a[i]);
    }
    if (reach <= 1) return;
    for (int k = 0; k < 2000; k++) {
        double m = k < 1000 && low == 0 ? high : 0.5 * (low + high);
        reach = 0;
        for (int i = 0; i < n; i++) {
            if (!(a[i] > 0)) continue;
            r[i] = isinf(a[i]) ? s[i] : s[i] / (1 + m * g[i] / a[i] / a[i]);
            reach += r[i] / a[i] * (r[i] / a[i]);
        }
        if (reach > 1) {
            if (m >= high) high *= 4;
            low = m;
        } else {
            high = m;
            if (low == 0) low = DBL_MIN;
        }
        if (high - low <= 1e-16 * high) return;
    }
}

static void judge_contact(const pinch_problem *p, const pinch_contact *c, referee_verdict *v)
{
    double h = p->step, t2[3], u1[3], u2[3], w1[3], w2[3], u[3], spin[3], w[4];
    cross(c->normal, c->tangent1, t2);
    point_velocity(p, c->body1, c->position, u1, w1);
    point_velocity(p, c->body2, c->position, u2, w2);
    for (int i = 0; i < 3; i++) {
        u[i] = u1[i] - u2[i];
        spin[i] = w1[i] - w2[i];
    }
    w[0] = dot(c->normal, u) + c->surface_velocity[0];
    w[1] = dot(c->tangent1, u) + c->surface_velocity[1];
    w[2] = dot(t2, u) + c->surface_velocity[2];
    w[3] = dot(c->normal, spin) + c->surface_velocity[3];
    double speed = length(u1) + length(u2) + fabs(c->surface_velocity[0]) + fabs(c->surface_velocity[1]) +
                   fabs(c->surface_velocity[2]);
    v->rounding = larger((h * c->stiffness[0] + c->damping[0]) * speed * DBL_EPSILON, v->rounding);

    const double *r = c->force;
    double normal = c->stiffness[0] * (c->depth - h * w[0]) - c->damping[0] * w[0];
    normal = fmin(fmax(normal, 0), c->max_force);
    v->normal = larger(fabs(r[0] - normal), v->normal);
    v->scale = larger(hypot(hypot(r[0], r[1]), r[2]), v->scale); /* squares of small forces would be zero */
    if (c->model == PINCH_CONTACT_FRICTIONLESS) {
        v->cone = larger(hypot(r[1], r[2]) + fabs(r[3]), v->cone);
        return;
    }

    int n = c->model == PINCH_CONTACT_SOFT ? 3 : 2;
    double s[3], g[3], a[3], want[3];
    for (int i = 0; i < 3; i++) {
        double k = c->stiffness[i < 2 ? 1 : 2], d = c->damping[i < 2 ? 1 : 2];
        s[i] = -k * (c->elastic[i] + h * w[1 + i]) - d * w[1 + i];
        g[i] = h * k + d;
        a[i] = (i < 2 ? c->friction[i] : c->torsional_friction) * r[0];
    }
    closest(n, a, g, s, want);
    /* torques count as the force at the lever that the two stiffnesses make: sqrt(ktau / kt); that of a contact which
     * dampers alone hold one way is made with them */
    bool springs = c->stiffness[1] > 0 && c->stiffness[2] > 0;
    double lever = springs ? sqrt(c->stiffness[2] / c->stiffness[1]) : sqrt(g[2] / g[0]), reach = 0, off = 0;
    for (int i = 0; i < n; i++) {
        off = hypot(off, (r[1 + i] - want[i]) / (i < 2 ? 1 : lever));
        if (a[i] > 0) reach = hypot(reach, r[1 + i] / a[i]);
        if (!(a[i] > 0)) v->cone = larger(fabs(r[1 + i]), v->cone);
    }
    if (n == 2) v->cone = larger(fabs(r[3]), v->cone);
    v->friction = larger(off, v->friction);
    double limit = fmax(a[0], a[1]);
    if (reach > 1 && isfinite(limit)) v->cone = larger((reach - 1) * limit, v->cone);
    /* friction of a slipping isotropic point opposes its slip increment */
    double slip = hypot(c->slip[0], c->slip[1]);
    if (n == 2 && c->friction[0] == c->friction[1] && slip > 0 && c->state == PINCH_CONTACT_SLIP) {
        double along = (r[1] * c->slip[0] + r[2] * c->slip[1]) / slip;
        v->direction = larger(along + hypot(r[1], r[2]), v->direction);
    }
}

static void add_contact_forces(const pinch_problem *p, const pinch_contact *c, double (*f)[6])
{
    double t2[3], force[3];
    cross(c->normal, c->tangent1, t2);
    for (int i = 0; i < 3; i++)
        force[i] = c->force[0] * c->normal[i] + c->force[1] * c->tangent1[i] + c->force[2] * t2[i];
    for (int side = 0; side < 2; side++) {
        int body = side ? c->body2 : c->body1;
        if (body < 0) continue;
        double arm[3], torque[3];
        for (int i = 0; i < 3; i++) arm[i] = c->position[i] - p->bodies[body].position[i];
        cross(arm, force, torque);
        for (int i = 0; i < 3; i++) {
            f[body][i] += (side ? -1 : 1) * force[i];
            f[body][3 + i] += (side ? -1 : 1) * (torque[i] + c->force[3] * c->normal[i]);
        }
    }
}

static void judge_row(const pinch_problem *p, const pinch_joint_row *row, referee_verdict *v)
{
    double u = 0;
    for (int i = 0; i < 6; i++) {
        if (row->body1 >= 0) u += row->j1[i] * p->bodies[row->body1].velocity_end[i];
        if (row->body2 >= 0) u += row->j2[i] * p->bodies[row->body2].velocity_end[i];
    }
    double error = u + row->cfm * row->force - row->rhs; /* > 0: moves more than asked for */
    if (row->cfm > 0) {
        double force = fmin(fmax((row->rhs - u) / row->cfm, row->low), row->high);
        v->compliant = larger(fabs(force - row->force), v->compliant);
    } else if (isinf(row->low) && isinf(row->high)) {
        v->joint = larger(fabs(error), v->joint);
    } else {
        double slack = 1e-12 * (1 + fabs(row->force));
        v->limited = larger(fmax(row->low - row->force, row->force - row->high), v->limited);
        if (row->force > row->low + slack) v->limited = larger(error, v->limited);   /* it could pull back */
        if (row->force < row->high - slack) v->limited = larger(-error, v->limited); /* it could push on */
    }
}

void referee_judge(const pinch_problem *p, referee_verdict *v)
{
    enum { BODIES = 512 };
    double f[BODIES][6];
    assert_true(p->body_count <= BODIES);
    memset(v, 0, sizeof *v);
    memset(f, 0, sizeof f);
    for (int k = 0; k < p->contact_count; k++) {
        judge_contact(p, &p->contacts[k], v);
        add_contact_forces(p, &p->contacts[k], f);
    }
    for (int k = 0; k < p->row_count; k++) {
        const pinch_joint_row *row = &p->rows[k];
        judge_row(p, row, v);
        for (int i = 0; i < 6; i++) {
            if (row->body1 >= 0) f[row->body1][i] += row->force * row->j1[i];
            if (row->body2 >= 0) f[row->body2][i] += row->force * row->j2[i];
        }
    }
    for (int b = 0; b < p->body_count; b++) {
        const pinch_body *body = &p->bodies[b];
        if (body->mass == 0) {
            v->drive = larger(fabs(dot(f[b], body->drive_axis) + body->drive_force), v->drive);
            v->scale = larger(body->drive_force, v->scale);
            continue;
        }
        double left[6], gain[6];
        for (int i = 0; i < 6; i++) {
            gain[i] = 0;
            if (i < 3) gain[i] = body->mass * (body->velocity_end[i] - body->velocity[i]) / p->step;
            for (int j = 0; j < 3 && i >= 3; j++)
                gain[i] +=
                    body->inertia[3 * (i - 3) + j] * (body->velocity_end[3 + j] - body->velocity[3 + j]) / p->step;
            left[i] = gain[i] - f[b][i];
        }
        v->balance = larger(hypot(length(left), length(left + 3) / body->radius), v->balance);
        v->scale = larger(length(f[b]) + length(f[b] + 3) / body->radius, v->scale);
        v->scale = larger(length(gain), v->scale);
        v->rounding = larger(body->mass / p->step * (length(body->velocity) + length(body->velocity_end)) * DBL_EPSILON,
                             v->rounding);
    }
}
