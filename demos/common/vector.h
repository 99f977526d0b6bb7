#ifndef PINCH_COMMON_VECTOR_H
#define PINCH_COMMON_VECTOR_H

#include <math.h>
#include <stdbool.h>

/* Strict C11 has no M_PI. */
#define SCENE_PI 3.14159265358979323846

/*
 * Three-vectors and (w, x, y, z) quaternions. The solver's own header is not used here: demos/ includes public headers
 * only, and a scene's lengths may be of any size, which the norm here allows for.
 */

static inline double scene_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void scene_cross(const double a[3], const double b[3], double c[3])
{
    double x = a[1] * b[2] - a[2] * b[1];
    double y = a[2] * b[0] - a[0] * b[2];
    double z = a[0] * b[1] - a[1] * b[0];
    c[0] = x;
    c[1] = y;
    c[2] = z;
}

/* hypot keeps the squares of very small or large numbers from vanishing or overflowing. */
static inline double scene_norm(const double a[3])
{
    return hypot(hypot(a[0], a[1]), a[2]);
}

/* Does `direction` point inwards by more than rounding, where `outward` (of any length) is the outward normal? */
static inline bool scene_points_inward(const double outward[3], const double direction[3])
{
    return scene_dot(outward, direction) < -1e-9 * scene_norm(outward);
}

static inline void scene_copy(const double a[3], double b[3])
{
    b[0] = a[0];
    b[1] = a[1];
    b[2] = a[2];
}

static inline void scene_subtract(const double a[3], const double b[3], double c[3])
{
    for (int i = 0; i < 3; i++) c[i] = a[i] - b[i];
}

/* y += s x */
static inline void scene_add_scaled(double y[3], double s, const double x[3])
{
    for (int i = 0; i < 3; i++) y[i] += s * x[i];
}

/* Turns v by the unit quaternion q: v + 2 w (u x v) + 2 u x (u x v), with u the vector part. */
static inline void scene_rotate(const double q[4], const double v[3], double out[3])
{
    double uv[3], uuv[3];
    scene_cross(q + 1, v, uv);
    scene_cross(q + 1, uv, uuv);
    for (int i = 0; i < 3; i++) out[i] = v[i] + 2.0 * (q[0] * uv[i] + uuv[i]);
}

static inline void scene_rotate_back(const double q[4], const double v[3], double out[3])
{
    double inverse[4] = {q[0], -q[1], -q[2], -q[3]};
    scene_rotate(inverse, v, out);
}

/* c = a b turns first by b, then by a. */
static inline void scene_quaternion_product(const double a[4], const double b[4], double c[4])
{
    double w = a[0] * b[0] - scene_dot(a + 1, b + 1);
    double v[3];
    scene_cross(a + 1, b + 1, v);
    scene_add_scaled(v, a[0], b + 1);
    scene_add_scaled(v, b[0], a + 1);
    c[0] = w;
    scene_copy(v, c + 1);
}

static inline void scene_quaternion_from_rotation(const double rotation[3], double q[4])
{
    double angle = scene_norm(rotation);
    /* sin(a/2)/a has the limit 1/2, which is exact to rounding long before the division becomes inaccurate. */
    double s = angle > 1e-8 ? sin(0.5 * angle) / angle : 0.5;
    q[0] = cos(0.5 * angle);
    for (int i = 0; i < 3; i++) q[i + 1] = s * rotation[i];
}

#endif
