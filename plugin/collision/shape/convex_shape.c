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

void pinch_core_support(const pinch_core *core, const double d[3], double point[3])
{
    switch (core->kind) {
    case PINCH_CORE_POINT:
        pinch_v3_set(point, 0, 0, 0);
        return;
    case PINCH_CORE_SEGMENT:
        pinch_v3_set(point, 0, 0, copysign(core->half[2], d[2]));
        return;
    case PINCH_CORE_TRIANGLE: {
        const double *c = core->corner, *best = c;
        if (pinch_v3_dot(c + 3, d) > pinch_v3_dot(best, d)) best = c + 3;
        if (pinch_v3_dot(c + 6, d) > pinch_v3_dot(best, d)) best = c + 6;
        pinch_v3_copy(point, best);
        return;
    }
    case PINCH_CORE_BOX:
        for (int i = 0; i < 3; i++) point[i] = copysign(core->half[i], d[i]);
        return;
    case PINCH_CORE_HULL:
        pinch_v3_copy(point, core->hull->convex.points + 3 * pinch_hull_farthest(core->hull, d));
        return;
    case PINCH_CORE_CYLINDER:
        disc_support(core->radius, copysign(core->half[2], d[2]), d, point);
        return;
    case PINCH_CORE_FLAT_CAPSULE:
        if (d[2] > 0) {
            double scale = core->radius / pinch_v3_norm(d);
            pinch_v3_set(point, scale * d[0], scale * d[1], scale * d[2] + core->half[2] + core->middle);
        } else {
            disc_support(core->radius, core->middle - core->half[2], d, point);
        }
        return;
    case PINCH_CORE_ELLIPSOID: {
        const double *r = core->half;
        double t[3] = {r[0] * d[0], r[1] * d[1], r[2] * d[2]}, scale = 1 / pinch_v3_norm(t);
        for (int i = 0; i < 3; i++) point[i] = r[i] * t[i] * scale;
        return;
    }
    default: {
        double value;
        pinch_superellipsoid_at(core->half, core->power, d, &value, point, NULL);
    }
    }
}

double pinch_core_reach(const pinch_core *core, const double d[3])
{
    double point[3];
    switch (core->kind) {
    case PINCH_CORE_POINT:
        return 0;
    case PINCH_CORE_SEGMENT:
        return core->half[2] * fabs(d[2]);
    case PINCH_CORE_BOX:
        return core->half[0] * fabs(d[0]) + core->half[1] * fabs(d[1]) + core->half[2] * fabs(d[2]);
    case PINCH_CORE_CYLINDER:
        return core->radius * sqrt(d[0] * d[0] + d[1] * d[1]) + core->half[2] * fabs(d[2]);
    case PINCH_CORE_ELLIPSOID: {
        double t[3] = {core->half[0] * d[0], core->half[1] * d[1], core->half[2] * d[2]};
        return pinch_v3_norm(t);
    }
    default:
        pinch_core_support(core, d, point);
        return pinch_v3_dot(point, d);
    }
}

void pinch_core_bend(const pinch_core *core, const double d[3], double H[9])
{
    memset(H, 0, 9 * sizeof *H);
    bool ball = core->kind == PINCH_CORE_FLAT_CAPSULE && d[2] > 0;
    if (ball) {
        for (int i = 0; i < 9; i++) H[i] = core->radius * ((i % 4 ? 0 : 1) - d[i / 3] * d[i % 3]);
    } else if (core->kind == PINCH_CORE_CYLINDER || core->kind == PINCH_CORE_FLAT_CAPSULE) {
        double rho = sqrt(d[0] * d[0] + d[1] * d[1]);
        if (!(rho > 1e-12)) return;
        double t[3] = {-d[1] / rho, d[0] / rho, 0}; /* the rim turns its support point around */
        for (int i = 0; i < 9; i++) H[i] = core->radius / rho * t[i / 3] * t[i % 3];
    } else if (core->kind == PINCH_CORE_ELLIPSOID) {
        double s[3], h = pinch_core_reach(core, d);
        pinch_core_support(core, d, s);
        for (int i = 0; i < 9; i++)
            H[i] = ((i % 4 ? 0 : core->half[i / 3] * core->half[i / 3]) - s[i / 3] * s[i % 3]) / h;
    } else if (core->kind == PINCH_CORE_SUPERELLIPSOID) {
        double value;
        pinch_superellipsoid_at(core->half, core->power, d, &value, NULL, H);
    }
}

int pinch_core_axes(const pinch_core *core, double axes[3][3])
{
    int count = 0;
    memset(axes, 0, 9 * sizeof(double));
    switch (core->kind) {
    case PINCH_CORE_SEGMENT:
    case PINCH_CORE_CYLINDER:
    case PINCH_CORE_FLAT_CAPSULE:
        axes[0][2] = 1;
        return 1;
    case PINCH_CORE_TRIANGLE: {
        double u[3], v[3];
        pinch_v3_sub(core->corner + 3, core->corner, u);
        pinch_v3_sub(core->corner + 6, core->corner, v);
        pinch_v3_cross(u, v, axes[0]);
        double length = pinch_v3_norm(axes[0]);
        if (!(length > 0)) return 0;
        pinch_v3_scale(axes[0], 1 / length);
        return 1;
    }
    case PINCH_CORE_BOX:
    case PINCH_CORE_ELLIPSOID:
    case PINCH_CORE_SUPERELLIPSOID:
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

double pinch_core_inner_ball(const pinch_core *core, double centre[3])
{
    pinch_v3_set(centre, 0, 0, 0);
    switch (core->kind) {
    case PINCH_CORE_BOX:
    case PINCH_CORE_ELLIPSOID:
        return least_half(core->half);
    case PINCH_CORE_CYLINDER:
        return core->radius < core->half[2] ? core->radius : core->half[2];
    case PINCH_CORE_HULL:
        pinch_v3_copy(centre, core->hull->centre);
        return core->hull->inner;
    case PINCH_CORE_TRIANGLE:
        for (int k = 0; k < 3; k++) pinch_v3_add_scaled(centre, 1.0 / 3, core->corner + 3 * k);
        return 0;
    default:
        return 0;
    }
}

void pinch_core_slide_ball(const pinch_core *core, const double x[3], double radius, double centre[3])
{
    if (core->kind != PINCH_CORE_BOX && core->kind != PINCH_CORE_CYLINDER) return;
    int first = core->kind == PINCH_CORE_BOX ? 0 : 2;
    for (int i = first; i < 3; i++) {
        double room = core->half[i] - radius, at = x[i] < room ? x[i] : room;
        centre[i] = at > -room ? at : -room;
    }
    if (first == 0) return;
    double rho = sqrt(x[0] * x[0] + x[1] * x[1]), room = core->radius - radius, scale = rho > room ? room / rho : 1;
    centre[0] = scale * x[0];
    centre[1] = scale * x[1];
}

int pinch_core_face_count(const pinch_core *core)
{
    return core->kind == PINCH_CORE_BOX        ? 6
           : core->kind == PINCH_CORE_HULL     ? (int)core->hull->convex.plane_count
           : core->kind == PINCH_CORE_TRIANGLE ? 2
                                               : 0;
}

void pinch_core_face_normal(const pinch_core *core, int face, double normal[3])
{
    if (core->kind == PINCH_CORE_HULL) {
        pinch_v3_copy(normal, core->hull->convex.planes + 4 * face);
    } else if (core->kind == PINCH_CORE_BOX) {
        pinch_v3_set(normal, 0, 0, 0);
        normal[face / 2] = face % 2 ? -1 : 1;
    } else {
        double axes[3][3];
        (void)pinch_core_axes(core, axes);
        for (int i = 0; i < 3; i++) normal[i] = face ? -axes[0][i] : axes[0][i];
    }
}

int pinch_core_corner_count(const pinch_core *core)
{
    switch (core->kind) {
    case PINCH_CORE_POINT:
        return 1;
    case PINCH_CORE_SEGMENT:
        return 2;
    case PINCH_CORE_TRIANGLE:
        return 3;
    case PINCH_CORE_BOX:
        return 8;
    default:
        return core->kind == PINCH_CORE_HULL ? (int)core->hull->convex.point_count : 0;
    }
}

void pinch_core_corner(const pinch_core *core, int k, double corner[3])
{
    const double *h = core->half;
    if (core->kind == PINCH_CORE_TRIANGLE)
        pinch_v3_copy(corner, core->corner + 3 * k);
    else if (core->kind == PINCH_CORE_HULL)
        pinch_v3_copy(corner, core->hull->convex.points + 3 * k);
    else /* half edges that the kind does not have are 0 */
        pinch_v3_set(corner, k & 2 ? h[0] : -h[0], k & 4 ? h[1] : -h[1], k & 1 ? h[2] : -h[2]);
}

pinch_core pinch_core_of_triangle(const double corners[9])
{
    pinch_core core;
    memset(&core, 0, sizeof core);
    core.kind = PINCH_CORE_TRIANGLE;
    memcpy(core.corner, corners, sizeof core.corner);
    for (int k = 0; k < 3; k++) core.bound = fmax(core.bound, pinch_v3_norm(corners + 3 * k));
    return core;
}

/* Half ball (height of its centre of mass 3 r/8 over its flat side) on a cylinder: where the cylinder's middle lies,
 * seen from the centre of mass of both. */
static double flat_capsule_middle(double r, double l)
{
    double tube = l, dome = 2.0 / 3.0 * r; /* volumes over pi r^2 */
    return -dome * (0.5 * l + 0.375 * r) / (tube + dome);
}

static void hull_core(pinch_core *core, const pinch_core_hull *hull)
{
    core->kind = PINCH_CORE_HULL;
    core->hull = hull;
    core->bound = hull->outer + core->skin;
}

pinch_core pinch_core_of_tip(const pinch_tip *tip, const pinch_core_hull *hull)
{
    pinch_core core;
    const double *s = tip->size;
    memset(&core, 0, sizeof core);
    switch (tip->type) {
    case PINCH_TIP_SPHERE:
        core.skin = core.bound = s[0];
        break;
    case PINCH_TIP_CAPSULE:
        core.kind = PINCH_CORE_SEGMENT;
        core.half[2] = 0.5 * s[1];
        core.skin = s[0];
        core.bound = core.half[2] + s[0];
        break;
    case PINCH_TIP_FLAT_CAPSULE:
        core.kind = PINCH_CORE_FLAT_CAPSULE;
        core.radius = s[0];
        core.half[2] = 0.5 * s[1];
        core.middle = flat_capsule_middle(s[0], s[1]);
        core.bound = fmax(core.middle + core.half[2] + s[0], hypot(s[0], core.half[2] - core.middle));
        break;
    case PINCH_TIP_BOX:
        core.kind = PINCH_CORE_BOX;
        core.skin = tip->skin;
        for (int i = 0; i < 3; i++) core.half[i] = 0.5 * s[i] - tip->skin;
        core.bound = pinch_v3_norm(core.half) + tip->skin;
        break;
    case PINCH_TIP_CYLINDER:
        core.kind = PINCH_CORE_CYLINDER;
        core.skin = tip->skin;
        core.radius = s[0] - tip->skin;
        core.half[2] = 0.5 * s[1] - tip->skin;
        core.bound = hypot(core.radius, core.half[2]) + tip->skin;
        break;
    case PINCH_TIP_ELLIPSOID: {
        double least = fmin(s[0], fmin(s[1], s[2])), most = fmax(s[0], fmax(s[1], s[2]));
        core.kind = PINCH_CORE_ELLIPSOID;
        pinch_v3_copy(core.half, s);
        core.bound = most;
        core.erosion = 0.999 * least * least / most;
        break;
    }
    case PINCH_TIP_SUPERELLIPSOID:
        core.kind = PINCH_CORE_SUPERELLIPSOID;
        pinch_v3_copy(core.half, s);
        core.bound = pinch_v3_norm(s);
        for (int i = 0; i < 2; i++) core.power[i] = 2 / (2 - tip->exponent[i]); /* 1/p + 1/q = 1 with p = 2/e */
        break;
    default:
        core.skin = tip->skin;
        hull_core(&core, hull);
    }
    return core;
}
