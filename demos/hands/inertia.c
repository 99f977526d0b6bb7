/* Masses and inertias: moving, adding and checking them. */

#include "inertia.h"

#include <float.h>

void mass_in_outer(const hand_pose *frame, const hand_mass *mass, hand_mass *out)
{
    double r[9], turned[9] = {0}, inertia[9] = {0}, centre[3];
    pose_matrix(frame->orientation, r);
    for (int i = 0; i < 9; i++)
        for (int k = 0; k < 3; k++) turned[i] += r[3 * (i / 3) + k] * mass->inertia[3 * k + i % 3];
    for (int i = 0; i < 9; i++)
        for (int k = 0; k < 3; k++) inertia[i] += turned[3 * (i / 3) + k] * r[3 * (i % 3) + k];
    pose_point(frame, mass->centre, centre);
    out->mass = mass->mass;
    scene_copy(centre, out->centre);
    /* The product is symmetric but for rounding. */
    for (int i = 0; i < 9; i++) out->inertia[i] = 0.5 * (inertia[i] + inertia[3 * (i % 3) + i / 3]);
}

/* Adds the inertia of a mass point at d. */
static void add_point(double mass, const double d[3], double inertia[9])
{
    double square = scene_dot(d, d);
    for (int i = 0; i < 9; i++) inertia[i] += mass * ((i % 4 ? 0 : square) - d[i / 3] * d[i % 3]);
}

void mass_add(hand_mass *sum, const hand_mass *more)
{
    if (!(more->mass > 0)) return;
    if (!(sum->mass > 0)) {
        *sum = *more;
        return;
    }
    double mass = sum->mass + more->mass, centre[3], d[3];
    for (int i = 0; i < 3; i++) centre[i] = (sum->mass * sum->centre[i] + more->mass * more->centre[i]) / mass;
    scene_subtract(sum->centre, centre, d);
    add_point(sum->mass, d, sum->inertia);
    scene_subtract(more->centre, centre, d);
    add_point(more->mass, d, sum->inertia);
    for (int i = 0; i < 9; i++) sum->inertia[i] += more->inertia[i];
    scene_copy(centre, sum->centre);
    sum->mass = mass;
}

/* A Jacobi rotation by which the element (p, q) of a becomes zero. */
static void rotate(double a[9], double v[9], int p, int q)
{
    double off = a[3 * p + q];
    if (off == 0) return;
    double tau = (a[4 * q] - a[4 * p]) / (2 * off);
    double t = (tau >= 0 ? 1 : -1) / (fabs(tau) + hypot(1, tau)), c = 1 / hypot(1, t), s = t * c;
    for (int k = 0; k < 3; k++) {
        double x = a[3 * k + p], y = a[3 * k + q];
        a[3 * k + p] = c * x - s * y;
        a[3 * k + q] = s * x + c * y;
    }
    for (int k = 0; k < 3; k++) {
        double x = a[3 * p + k], y = a[3 * q + k];
        a[3 * p + k] = c * x - s * y;
        a[3 * q + k] = s * x + c * y;
        x = v[3 * k + p];
        y = v[3 * k + q];
        v[3 * k + p] = c * x - s * y;
        v[3 * k + q] = s * x + c * y;
    }
    a[3 * p + q] = a[3 * q + p] = 0;
}

static void swap_columns(double values[3], double axes[9], int p, int q)
{
    double value = values[p];
    values[p] = values[q];
    values[q] = value;
    for (int k = 0; k < 3; k++) {
        double x = axes[3 * k + p]; /* one column changes its sign, so that the axes stay a rotation */
        axes[3 * k + p] = axes[3 * k + q];
        axes[3 * k + q] = -x;
    }
}

void inertia_principal(const double inertia[9], double values[3], double axes[9])
{
    double a[9], v[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    memcpy(a, inertia, sizeof a);
    /* Each sweep squares the size of what is off the diagonal; 50 would be enough for any matrix of doubles. */
    for (int sweep = 0; sweep < 50; sweep++) {
        double off = fabs(a[1]) + fabs(a[2]) + fabs(a[5]);
        if (off == 0 || off < DBL_EPSILON * DBL_EPSILON * (fabs(a[0]) + fabs(a[4]) + fabs(a[8]))) break;
        rotate(a, v, 0, 1);
        rotate(a, v, 0, 2);
        rotate(a, v, 1, 2);
    }
    for (int i = 0; i < 3; i++) values[i] = a[4 * i];
    memcpy(axes, v, sizeof v);
    if (values[0] < values[1]) swap_columns(values, axes, 0, 1);
    if (values[1] < values[2]) swap_columns(values, axes, 1, 2);
    if (values[0] < values[1]) swap_columns(values, axes, 0, 1);
}

void inertia_from_principal(const double values[3], const double axes[9], double inertia[9])
{
    for (int i = 0; i < 9; i++) {
        inertia[i] = 0;
        for (int k = 0; k < 3; k++) inertia[i] += axes[3 * (i / 3) + k] * values[k] * axes[3 * (i % 3) + k];
    }
}

/* The largest of the four squares is at least 1/4, so the division is safe. */
void inertia_quaternion(const double r[9], double q[4])
{
    double squares[4] = {1 + r[0] + r[4] + r[8], 1 + r[0] - r[4] - r[8], 1 - r[0] + r[4] - r[8],
                         1 - r[0] - r[4] + r[8]};
    double off[4][4] = {{0, r[7] - r[5], r[2] - r[6], r[3] - r[1]},
                        {r[7] - r[5], 0, r[3] + r[1], r[2] + r[6]},
                        {r[2] - r[6], r[3] + r[1], 0, r[7] + r[5]},
                        {r[3] - r[1], r[2] + r[6], r[7] + r[5], 0}};
    int best = 0;
    for (int i = 1; i < 4; i++)
        if (squares[i] > squares[best]) best = i;
    for (int i = 0; i < 4; i++) q[i] = i == best ? squares[i] : off[best][i];
    pose_normalize(q);
}

bool inertia_is_possible(const double inertia[9], double part)
{
    double values[3], axes[9];
    inertia_principal(inertia, values, axes);
    if (!isfinite(values[0])) return false;
    return values[2] >= -INERTIA_DIGITS * values[0] && values[0] <= (1 + part) * (values[1] + values[2]);
}
