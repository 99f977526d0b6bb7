#include "convex_shape.h"

#include "superellipsoid.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

static void disc_support(double radius, double z, const double *d, double *point)
{
    double rho = sqrt(d[0] * d[0] + d[1] * d[1]), scale = rho > 0 ? radius / rho : 0;
    point[0] = scale * d[0];
    point[1] = scale * d[1];
    point[2] = z;
}

void pinch_support_point(const pinch_shape *shape, const double d[3], double point[3])
{
    switch (shape->kind) {
    case PINCH_SHAPE_POINT:
        pinch_v3_set(point, 0, 0, 0);
        return;
    case PINCH_SHAPE_SEGMENT:
        pinch_v3_set(point, 0, 0, copysign(shape->half[2], d[2]));
        return;
    case PINCH_SHAPE_TRIANGLE: {
        const double *c = shape->corner, *best = c;
        if (pinch_v3_dot(c + 3, d) > pinch_v3_dot(best, d)) best = c + 3;
        if (pinch_v3_dot(c + 6, d) > pinch_v3_dot(best, d)) best = c + 6;
        pinch_v3_copy(point, best);
        return;
    }
    case PINCH_SHAPE_BOX:
        for (int i = 0; i < 3; i++) point[i] = copysign(shape->half[i], d[i]);
        return;
    case PINCH_SHAPE_HULL:
        pinch_v3_copy(point, shape->hull->convex.points + 3 * pinch_hull_support_vertex(shape->hull, d));
        return;
    case PINCH_SHAPE_CYLINDER:
        disc_support(shape->radius, copysign(shape->half[2], d[2]), d, point);
        return;
    case PINCH_SHAPE_FLAT_CAPSULE:
        if (d[2] > 0) {
            double scale = shape->radius / pinch_v3_norm(d);
            pinch_v3_set(point, scale * d[0], scale * d[1], scale * d[2] + shape->half[2] + shape->middle);
        } else {
            disc_support(shape->radius, shape->middle - shape->half[2], d, point);
        }
        return;
    case PINCH_SHAPE_ELLIPSOID: {
        const double *r = shape->half;
        double t[3] = {r[0] * d[0], r[1] * d[1], r[2] * d[2]}, scale = 1 / pinch_v3_norm(t);
        for (int i = 0; i < 3; i++) point[i] = r[i] * t[i] * scale;
        return;
    }
    default: {
        double value;
        pinch_superellipsoid_at(shape->half, shape->power, d, &value, point, NULL);
    }
    }
}

double pinch_support_value(const pinch_shape *shape, const double d[3])
{
    double point[3];
    switch (shape->kind) {
    case PINCH_SHAPE_POINT:
        return 0;
    case PINCH_SHAPE_SEGMENT:
        return shape->half[2] * fabs(d[2]);
    case PINCH_SHAPE_BOX:
        return shape->half[0] * fabs(d[0]) + shape->half[1] * fabs(d[1]) + shape->half[2] * fabs(d[2]);
    case PINCH_SHAPE_CYLINDER:
        return shape->radius * sqrt(d[0] * d[0] + d[1] * d[1]) + shape->half[2] * fabs(d[2]);
    case PINCH_SHAPE_ELLIPSOID: {
        double t[3] = {shape->half[0] * d[0], shape->half[1] * d[1], shape->half[2] * d[2]};
        return pinch_v3_norm(t);
    }
    default:
        pinch_support_point(shape, d, point);
        return pinch_v3_dot(point, d);
    }
}

double pinch_support_at_least(const pinch_shape *shape, const double d[3])
{
    if (!pinch_is_large_hull(shape)) return pinch_support_value(shape, d);
    return pinch_v3_dot(shape->hull->convex.points + 3 * (size_t)pinch_hull_near_vertex(shape->hull, d), d);
}

void pinch_support_hessian(const pinch_shape *shape, const double d[3], double H[9])
{
    memset(H, 0, 9 * sizeof *H);
    bool ball = shape->kind == PINCH_SHAPE_FLAT_CAPSULE && d[2] > 0;
    if (ball) {
        for (int i = 0; i < 9; i++) H[i] = shape->radius * ((i % 4 ? 0 : 1) - d[i / 3] * d[i % 3]);
    } else if (shape->kind == PINCH_SHAPE_CYLINDER || shape->kind == PINCH_SHAPE_FLAT_CAPSULE) {
        double rho = sqrt(d[0] * d[0] + d[1] * d[1]);
        if (!(rho > 1e-12)) return;
        double t[3] = {-d[1] / rho, d[0] / rho, 0}; /* the support point moves around the rim */
        for (int i = 0; i < 9; i++) H[i] = shape->radius / rho * t[i / 3] * t[i % 3];
    } else if (shape->kind == PINCH_SHAPE_ELLIPSOID) {
        double s[3], h = pinch_support_value(shape, d);
        pinch_support_point(shape, d, s);
        for (int i = 0; i < 9; i++)
            H[i] = ((i % 4 ? 0 : shape->half[i / 3] * shape->half[i / 3]) - s[i / 3] * s[i % 3]) / h;
    } else if (shape->kind == PINCH_SHAPE_SUPERELLIPSOID) {
        double value;
        pinch_superellipsoid_at(shape->half, shape->power, d, &value, NULL, H);
    }
}

int pinch_shape_axes(const pinch_shape *shape, double axes[3][3])
{
    int count = 0;
    memset(axes, 0, 9 * sizeof(double));
    switch (shape->kind) {
    case PINCH_SHAPE_SEGMENT:
    case PINCH_SHAPE_CYLINDER:
    case PINCH_SHAPE_FLAT_CAPSULE:
        axes[0][2] = 1;
        return 1;
    case PINCH_SHAPE_TRIANGLE: {
        double u[3], v[3];
        pinch_v3_sub(shape->corner + 3, shape->corner, u);
        pinch_v3_sub(shape->corner + 6, shape->corner, v);
        pinch_v3_cross(u, v, axes[0]);
        double length = pinch_v3_norm(axes[0]);
        if (!(length > 0)) return 0;
        pinch_v3_scale(axes[0], 1 / length);
        return 1;
    }
    case PINCH_SHAPE_BOX:
    case PINCH_SHAPE_ELLIPSOID:
    case PINCH_SHAPE_SUPERELLIPSOID:
        for (; count < 3; count++) axes[count][count] = 1;
        return count;
    default:
        return 0;
    }
}

static double least_half(const double *h)
{
    double least = h[0] < h[1] ? h[0] : h[1];
    return least < h[2] ? least : h[2];
}

double pinch_inner_ball(const pinch_shape *shape, double centre[3])
{
    pinch_v3_set(centre, 0, 0, 0);
    switch (shape->kind) {
    case PINCH_SHAPE_BOX:
    case PINCH_SHAPE_ELLIPSOID:
        return least_half(shape->half);
    case PINCH_SHAPE_CYLINDER:
        return shape->radius < shape->half[2] ? shape->radius : shape->half[2];
    case PINCH_SHAPE_HULL:
        pinch_v3_copy(centre, shape->hull->centre);
        return shape->hull->inner;
    case PINCH_SHAPE_TRIANGLE:
        for (int k = 0; k < 3; k++) pinch_v3_add_scaled(centre, 1.0 / 3, shape->corner + 3 * k);
        return 0;
    default:
        return 0;
    }
}

void pinch_slide_inner_ball(const pinch_shape *shape, const double x[3], double radius, double centre[3])
{
    if (shape->kind != PINCH_SHAPE_BOX && shape->kind != PINCH_SHAPE_CYLINDER) return;
    int first = shape->kind == PINCH_SHAPE_BOX ? 0 : 2;
    for (int i = first; i < 3; i++) {
        double room = shape->half[i] - radius, at = x[i] < room ? x[i] : room;
        centre[i] = at > -room ? at : -room;
    }
    if (first == 0) return;
    double rho = sqrt(x[0] * x[0] + x[1] * x[1]), room = shape->radius - radius, scale = rho > room ? room / rho : 1;
    centre[0] = scale * x[0];
    centre[1] = scale * x[1];
}

int pinch_face_count(const pinch_shape *shape)
{
    return shape->kind == PINCH_SHAPE_BOX        ? 6
           : shape->kind == PINCH_SHAPE_HULL     ? (int)shape->hull->convex.plane_count
           : shape->kind == PINCH_SHAPE_TRIANGLE ? 2
                                                 : 0;
}

void pinch_face_normal(const pinch_shape *shape, int face, double normal[3])
{
    if (shape->kind == PINCH_SHAPE_HULL) {
        pinch_v3_copy(normal, shape->hull->convex.planes + 4 * face);
    } else if (shape->kind == PINCH_SHAPE_BOX) {
        pinch_v3_set(normal, 0, 0, 0);
        normal[face / 2] = face % 2 ? -1 : 1;
    } else {
        double axes[3][3];
        (void)pinch_shape_axes(shape, axes);
        for (int i = 0; i < 3; i++) normal[i] = face ? -axes[0][i] : axes[0][i];
    }
}

int pinch_vertex_count(const pinch_shape *shape)
{
    switch (shape->kind) {
    case PINCH_SHAPE_POINT:
        return 1;
    case PINCH_SHAPE_SEGMENT:
        return 2;
    case PINCH_SHAPE_TRIANGLE:
        return 3;
    case PINCH_SHAPE_BOX:
        return 8;
    default:
        return shape->kind == PINCH_SHAPE_HULL ? (int)shape->hull->convex.point_count : 0;
    }
}

void pinch_vertex(const pinch_shape *shape, int k, double corner[3])
{
    const double *h = shape->half;
    if (shape->kind == PINCH_SHAPE_TRIANGLE)
        pinch_v3_copy(corner, shape->corner + 3 * k);
    else if (shape->kind == PINCH_SHAPE_HULL)
        pinch_v3_copy(corner, shape->hull->convex.points + 3 * k);
    else /* half lengths that a kind does not have are 0 */
        pinch_v3_set(corner, k & 2 ? h[0] : -h[0], k & 4 ? h[1] : -h[1], k & 1 ? h[2] : -h[2]);
}

pinch_shape pinch_shape_of_triangle(const double corners[9])
{
    pinch_shape shape;
    memset(&shape, 0, sizeof shape);
    shape.kind = PINCH_SHAPE_TRIANGLE;
    memcpy(shape.corner, corners, sizeof shape.corner);
    for (int k = 0; k < 3; k++) shape.bound = fmax(shape.bound, pinch_v3_norm(corners + 3 * k));
    return shape;
}

/* A flat capsule is a half ball on a cylinder. The half ball's centre of mass lies 3 r/8 above its flat side. Returns z
 * of the cylinder's middle, measured from the centre of mass of both. */
static double flat_capsule_middle(double r, double l)
{
    double tube = l, dome = 2.0 / 3.0 * r; /* volumes, divided by pi r^2 */
    return -dome * (0.5 * l + 0.375 * r) / (tube + dome);
}

static void set_hull(pinch_shape *shape, const pinch_hull *hull)
{
    shape->kind = PINCH_SHAPE_HULL;
    shape->hull = hull;
    shape->bound = hull->outer + shape->margin;
}

pinch_shape pinch_shape_of_tip(const pinch_tip *tip, const pinch_hull *hull)
{
    pinch_shape shape;
    const double *s = tip->size;
    memset(&shape, 0, sizeof shape);
    switch (tip->type) {
    case PINCH_TIP_SPHERE:
        shape.margin = shape.bound = s[0];
        break;
    case PINCH_TIP_CAPSULE:
        shape.kind = PINCH_SHAPE_SEGMENT;
        shape.half[2] = 0.5 * s[1];
        shape.margin = s[0];
        shape.bound = shape.half[2] + s[0];
        break;
    case PINCH_TIP_FLAT_CAPSULE:
        shape.kind = PINCH_SHAPE_FLAT_CAPSULE;
        shape.radius = s[0];
        shape.half[2] = 0.5 * s[1];
        shape.middle = flat_capsule_middle(s[0], s[1]);
        shape.bound = fmax(shape.middle + shape.half[2] + s[0], hypot(s[0], shape.half[2] - shape.middle));
        break;
    case PINCH_TIP_BOX:
        shape.kind = PINCH_SHAPE_BOX;
        shape.margin = tip->skin;
        for (int i = 0; i < 3; i++) shape.half[i] = 0.5 * s[i] - tip->skin;
        shape.bound = pinch_v3_norm(shape.half) + tip->skin;
        break;
    case PINCH_TIP_CYLINDER:
        shape.kind = PINCH_SHAPE_CYLINDER;
        shape.margin = tip->skin;
        shape.radius = s[0] - tip->skin;
        shape.half[2] = 0.5 * s[1] - tip->skin;
        shape.bound = hypot(shape.radius, shape.half[2]) + tip->skin;
        break;
    case PINCH_TIP_ELLIPSOID: {
        double least = fmin(s[0], fmin(s[1], s[2])), most = fmax(s[0], fmax(s[1], s[2]));
        shape.kind = PINCH_SHAPE_ELLIPSOID;
        pinch_v3_copy(shape.half, s);
        shape.bound = most;
        shape.erosion = 0.999 * least * least / most;
        break;
    }
    case PINCH_TIP_SUPERELLIPSOID:
        shape.kind = PINCH_SHAPE_SUPERELLIPSOID;
        pinch_v3_copy(shape.half, s);
        shape.bound = pinch_v3_norm(s);
        for (int i = 0; i < 2; i++)
            shape.power[i] = 2 / (2 - tip->exponent[i]); /* conjugate exponents: 1/p + 1/q = 1 with p = 2/e */
        break;
    default:
        shape.margin = tip->skin;
        set_hull(&shape, hull);
    }
    return shape;
}
