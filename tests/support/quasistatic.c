#include "support/quasistatic.h"

#include "support/arithmetic.h"

#include <math.h>
#include <string.h>

typedef struct contact {
    const scene_finger *finger;
    tip_contact touch;
    double elastic[3], twist; /* of the tangential and the torsional spring: m, rad */
    double force[3], torque;  /* N; N m about the normal */
} contact;

typedef struct motion {
    int count;
    contact contact[QUASISTATIC_FINGERS];
    double u[3], q[4];
    double wrench[6];
    double size, unit, give; /* m; N; m: what a spring gives under the unit force */
} motion;

/* (R(q) - 1) v, to its own last digit however small the turn */
static void turned_by(const double *q, const double *v, double *out)
{
    double once[3], twice[3];
    cross(q + 1, v, once);
    cross(q + 1, once, twice);
    for (int i = 0; i < 3; i++) out[i] = 2 * (q[0] * once[i] + twice[i]);
}

/* out = exp(turn) q */
static void turn(const double *q, const double *turn, double *out)
{
    double angle = sqrt(dot(turn, turn)), p[4], x[3];
    double scale = angle > 1e-6 ? sin(0.5 * angle) / angle : 0.5;
    p[0] = cos(0.5 * angle);
    for (int i = 0; i < 3; i++) p[1 + i] = scale * turn[i];
    cross(p + 1, q + 1, x);
    for (int i = 0; i < 3; i++) out[1 + i] = p[0] * q[1 + i] + q[0] * p[1 + i] + x[i];
    out[0] = sqrt(1 - dot(out + 1, out + 1));
}

/*
 * The sphere's centre starts at p - radius n and moves by closing n; with the outward face normal a = -n it is at
 * c = p + radius a - closing a - u from the centre of mass. The face, at p . a along R a, is overlapped by
 * radius + p . a - c . R a; written so that only small numbers are subtracted.
 */
tip_contact tip_contact_at(const scene_finger *finger, double closed, const double u[3], const double q[4])
{
    tip_contact t;
    double a[3], da[3], c[3], radius = finger->tip.u.sphere.radius, closing = closed * finger->closing;
    for (int i = 0; i < 3; i++) a[i] = -finger->normal[i];
    turned_by(q, a, da);
    for (int i = 0; i < 3; i++) c[i] = finger->point[i] + (radius - closing) * a[i] - u[i];
    t.depth = closing + dot(u, a) - dot(c, da);
    for (int i = 0; i < 3; i++) {
        t.normal[i] = -(a[i] + da[i]);
        t.arm[i] = c[i] + (radius - t.depth) * t.normal[i];
    }
    return t;
}

/* The closest point of the friction limit in the metric of the compliance: a multiplier, by bisection. */
static void limit_friction(const scene_finger *f, double normal_force, double *tangential, double *torque)
{
    double mu = f->friction.static_, slide = dot(tangential, tangential) / (mu * mu), twist = 0, ratio = 0;
    if (f->model == SCENE_SOFT) {
        double radius = f->torsional_friction;
        twist = *torque * *torque / (radius * radius);
        ratio = f->stiffness.torsional / (radius * radius) / (f->stiffness.tangential / (mu * mu));
    }
    double reach2 = normal_force * normal_force, low = 0, high = 1;
    if (slide + twist <= reach2) return;
#define EXCESS(m) (slide / ((1 + (m)) * (1 + (m))) + twist / ((1 + ratio * (m)) * (1 + ratio * (m))) - reach2)
    while (EXCESS(high) > 0) high *= 4;
    for (int i = 0; i < 200 && high - low > 1e-16 * high; i++) {
        double middle = 0.5 * (low + high);
        if (EXCESS(middle) > 0)
            low = middle;
        else
            high = middle;
    }
#undef EXCESS
    for (int i = 0; i < 3; i++) tangential[i] /= 1 + high;
    *torque /= 1 + ratio * high;
}

/*
 * The contact after the object moved on by du, dturn to u, q. The springs go with the contact: with all of the object's
 * turn across the normal and, between a tip that stands still and an object that turns, with half of it about the
 * normal.
 */
static contact carried(const contact *from, const double *du, const double *dturn, const double *u, const double *q,
                       double closed, double dclosed)
{
    contact to = *from;
    const scene_finger *f = from->finger;
    to.touch = tip_contact_at(f, closed, u, q);
    memset(to.force, 0, sizeof to.force);
    to.torque = 0;
    if (to.touch.depth <= 0) {
        memset(to.elastic, 0, sizeof to.elastic);
        to.twist = 0;
        return to;
    }
    double arm[3], n[3], shear[3], with[3], carry[3];
    for (int i = 0; i < 3; i++) {
        arm[i] = 0.5 * (from->touch.arm[i] + to.touch.arm[i]);
        n[i] = 0.5 * (from->touch.normal[i] + to.touch.normal[i]);
    }
    double spin = dot(n, dturn);
    cross(dturn, arm, shear);
    for (int i = 0; i < 3; i++) {
        shear[i] += du[i] - dclosed * f->closing * f->normal[i];
        with[i] = dturn[i] - 0.5 * spin * n[i];
    }
    cross(with, from->elastic, carry);
    double along = dot(shear, n);
    for (int i = 0; i < 3; i++) to.elastic[i] += carry[i] + shear[i] - along * n[i];
    along = dot(to.elastic, to.touch.normal);
    for (int i = 0; i < 3; i++) to.elastic[i] -= along * to.touch.normal[i];
    to.twist += spin;

    double kt = f->stiffness.tangential, normal_force = f->stiffness.normal * to.touch.depth, friction[3];
    for (int i = 0; i < 3; i++) friction[i] = -kt * to.elastic[i];
    if (f->model == SCENE_SOFT) to.torque = -f->stiffness.torsional * to.twist;
    limit_friction(f, normal_force, friction, &to.torque);
    for (int i = 0; i < 3; i++) {
        to.elastic[i] = -friction[i] / kt;
        to.force[i] = normal_force * to.touch.normal[i] + friction[i];
    }
    to.twist = f->model == SCENE_SOFT ? -to.torque / f->stiffness.torsional : 0;
    return to;
}

/* `to`: the motion after the object moved on by `move` (m, the turn counted at the object's size); what is left of
 * forces and moments, in the unit of force. */
static double advance(const motion *from, const double *move, double closed, double dclosed, double load, motion *to,
                      double *left)
{
    double dturn[3];
    *to = *from;
    for (int i = 0; i < 3; i++) {
        to->u[i] += move[i];
        dturn[i] = move[3 + i] / from->size;
    }
    turn(from->q, dturn, to->q);
    for (int i = 0; i < 6; i++) left[i] = load * from->wrench[i];
    for (int k = 0; k < from->count; k++) {
        contact *c = &to->contact[k];
        double moment[3];
        *c = carried(&from->contact[k], move, dturn, to->u, to->q, closed, dclosed);
        cross(c->touch.arm, c->force, moment);
        for (int i = 0; i < 3; i++) {
            left[i] += c->force[i];
            left[3 + i] += moment[i] + c->torque * c->touch.normal[i];
        }
    }
    double sum = 0;
    for (int i = 0; i < 6; i++) {
        left[i] /= from->unit * (i < 3 ? 1 : from->size);
        sum += left[i] * left[i];
    }
    return sqrt(sum);
}

/* x <- A^-1 x by Gauss' elimination; false: singular */
static bool eliminate(double A[6][6], double *x)
{
    for (int k = 0; k < 6; k++) {
        int pivot = k;
        for (int i = k + 1; i < 6; i++)
            if (fabs(A[i][k]) > fabs(A[pivot][k])) pivot = i;
        if (A[pivot][k] == 0) return false;
        for (int j = 0; j < 6; j++) {
            double row = A[k][j];
            A[k][j] = A[pivot][j];
            A[pivot][j] = row;
        }
        double right = x[k];
        x[k] = x[pivot];
        x[pivot] = right;
        for (int i = k + 1; i < 6; i++) {
            double factor = A[i][k] / A[k][k];
            for (int j = k; j < 6; j++) A[i][j] -= factor * A[k][j];
            x[i] -= factor * x[k];
        }
    }
    for (int k = 5; k >= 0; k--) {
        for (int j = k + 1; j < 6; j++) x[k] -= A[k][j] * x[j];
        x[k] /= A[k][k];
    }
    return true;
}

static const double BALANCED = 1e-10; /* of the unit of force; rounding leaves less */

/* The next equilibrium by Newton's method from `move`, which receives how the object got there. */
static bool balance(motion *m, double *move, double closed, double dclosed, double load)
{
    motion next;
    double left[6], step = 1e-7 * m->give;
    double error = advance(m, move, closed, dclosed, load, &next, left);
    for (int iteration = 0; iteration < 60 && error > 1e-13; iteration++) {
        double slope[6][6], trial[6], ahead[6], behind[6];
        for (int j = 0; j < 6; j++) {
            memcpy(trial, move, sizeof trial);
            trial[j] = move[j] + step;
            advance(m, trial, closed, dclosed, load, &next, ahead);
            trial[j] = move[j] - step;
            advance(m, trial, closed, dclosed, load, &next, behind);
            for (int i = 0; i < 6; i++) slope[i][j] = (ahead[i] - behind[i]) / (2 * step) * m->give;
        }
        if (!eliminate(slope, left)) return false;
        double part = 1, better = INFINITY;
        for (int halvings = 0; halvings < 12; halvings++, part *= 0.5) {
            for (int i = 0; i < 6; i++) trial[i] = move[i] - part * m->give * left[i];
            better = advance(m, trial, closed, dclosed, load, &next, ahead);
            if (better < (1 - 1e-4 * part) * error) break;
        }
        if (!(better < error)) break;
        memcpy(move, trial, sizeof trial);
        memcpy(left, ahead, sizeof left);
        error = better;
    }
    if (!(error <= BALANCED)) return false;
    advance(m, move, closed, dclosed, load, &next, left);
    *m = next;
    return true;
}

static motion start(const scene *s)
{
    motion m = {.count = (int)s->finger_count, .q = {1}, .size = s->objects[0].shape.bounding_radius};
    const scene_entry *last = &s->schedule[s->entry_count - 1];
    for (int k = 0; k < m.count; k++) {
        const scene_finger *f = &s->fingers[k];
        m.contact[k] = (contact){.finger = f, .touch = tip_contact_at(f, 0, m.u, m.q)};
        m.unit = fmax(m.unit, f->closing * f->stiffness.normal);
        m.give = fmax(m.give, f->closing);
    }
    for (int i = 0; i < 3; i++) {
        m.wrench[i] = last->channels[SCENE_FORCE].value[i];
        m.wrench[3 + i] = last->channels[SCENE_TORQUE].value[i];
    }
    return m;
}

bool quasistatic_motion(const scene *s, int increments, double force[QUASISTATIC_FINGERS][3])
{
    motion m = start(s);
    const double whole = 1.0 / increments;
    /* `at` goes from 0 to 1 while the fingers close, from 1 to 2 with the wrench */
    double at = 0, part = whole, pace[6] = {0};
    while (at < 2) {
        double end = at < 1 ? 1 : 2, to = end - at < 1.001 * part ? end : at + part, move[6] = {0};
        double closed = fmin(to, 1), load = fmax(to - 1, 0), dclosed = closed - fmin(at, 1);
        motion before = m;
        for (int i = 0; i < 6; i++) move[i] = pace[i] * (to - at);
        if (!balance(&m, move, closed, dclosed, load)) {
            m = before;
            memset(move, 0, sizeof move);
            if (!balance(&m, move, closed, dclosed, load)) {
                m = before;
                part *= 0.5;
                if (part < 1e-6 * whole) return false;
                continue;
            }
        }
        /* the pace of closing says nothing about that of the wrench */
        for (int i = 0; i < 6; i++) pace[i] = to == 1 ? 0 : move[i] / (to - at);
        at = to;
        part = fmin(1.2 * part, whole);
    }
    for (int k = 0; k < m.count; k++) memcpy(force[k], m.contact[k].force, sizeof force[k]);
    return true;
}
