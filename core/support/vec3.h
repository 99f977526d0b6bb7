/* Vectors of three, inline. The verification keeps its own: it shares nothing. */
#ifndef PINCH_SUPPORT_VEC3_H
#define PINCH_SUPPORT_VEC3_H

#include <math.h>

static inline double pinch_v3_dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void pinch_v3_cross(const double *a, const double *b, double *c)
{
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    c[0] = x;
    c[1] = y;
    c[2] = z;
}

static inline void pinch_v3_set(double *a, double x, double y, double z)
{
    a[0] = x;
    a[1] = y;
    a[2] = z;
}

static inline void pinch_v3_copy(double *to, const double *from)
{
    to[0] = from[0];
    to[1] = from[1];
    to[2] = from[2];
}

static inline void pinch_v3_sub(const double *a, const double *b, double *c)
{
    c[0] = a[0] - b[0];
    c[1] = a[1] - b[1];
    c[2] = a[2] - b[2];
}

/* c += s a */
static inline void pinch_v3_add_scaled(double *c, double s, const double *a)
{
    c[0] += s * a[0];
    c[1] += s * a[1];
    c[2] += s * a[2];
}

static inline void pinch_v3_scale(double *a, double s)
{
    a[0] *= s;
    a[1] *= s;
    a[2] *= s;
}

static inline double pinch_v3_norm(const double *a)
{
    return sqrt(pinch_v3_dot(a, a));
}

/* a <- a without its part along the unit vector n */
static inline void pinch_v3_make_perpendicular(double *a, const double *n)
{
    pinch_v3_add_scaled(a, -pinch_v3_dot(a, n), n);
}

/* the axis of the largest component, of equal ones the first */
static inline int pinch_v3_main_axis(const double *a)
{
    int axis = fabs(a[1]) > fabs(a[0]) ? 1 : 0;
    return fabs(a[2]) > fabs(a[axis]) ? 2 : axis;
}

/* a unit vector perpendicular to the unit vector n: the axis least aligned with it (ties x, y, z), made perpendicular
 */
static inline void pinch_v3_any_perpendicular(const double *n, double *t)
{
    double x = fabs(n[0]), y = fabs(n[1]), z = fabs(n[2]);
    pinch_v3_set(t, 0, 0, 0);
    t[x <= y && x <= z ? 0 : y <= z ? 1 : 2] = 1;
    pinch_v3_make_perpendicular(t, n);
    pinch_v3_scale(t, 1 / pinch_v3_norm(t));
}

/* The smallest rotation that takes one unit vector to another, `to`. */
typedef struct pinch_v3_turn {
    double axis[3];             /* of the length of the sine */
    double cosine, over, to[3]; /* over: 1/(1 + cosine) */
} pinch_v3_turn;

static inline pinch_v3_turn pinch_v3_turn_between(const double *from, const double *to)
{
    pinch_v3_turn turn = {.cosine = pinch_v3_dot(from, to), .to = {to[0], to[1], to[2]}};
    pinch_v3_cross(from, to, turn.axis);
    double apart = 1 - turn.cosine, little = 1e-8; /* below it the series' next term is less than the last place */
    turn.over = fabs(apart) < little ? 0.5 + 0.25 * apart : 1 / (1 + turn.cosine);
    return turn;
}

/* Rotates v. A half turn may be about any axis. */
static inline void pinch_v3_rotate(const pinch_v3_turn *turn, double *v)
{
    double turned[3], c = turn->cosine;
    if (c < -1 + 1e-12) {
        pinch_v3_make_perpendicular(v, turn->to);
        return;
    }
    pinch_v3_cross(turn->axis, v, turned);
    double along = pinch_v3_dot(turn->axis, v) * turn->over;
    for (int i = 0; i < 3; i++) v[i] = c * v[i] + turned[i] + along * turn->axis[i];
}

#endif
