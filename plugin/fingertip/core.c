#include "core.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

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
    for (unsigned i = 0; i < hull->convex.point_count; i++)
        core->bound = fmax(core->bound, pinch_v3_norm(hull->convex.points + 3 * i));
    core->bound += core->skin;
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

static void hull_support(const pinch_convex *convex, const double *d, double *point)
{
    const double *best = convex->points, *x = convex->points;
    double most = pinch_v3_dot(best, d);
    for (unsigned i = 1; i < convex->point_count; i++) {
        x += 3;
        double along = pinch_v3_dot(x, d);
        if (along <= most) continue;
        most = along;
        best = x;
    }
    pinch_v3_copy(point, best);
}

static void disc_support(double radius, double z, const double *d, double *point)
{
    double rho = sqrt(d[0] * d[0] + d[1] * d[1]), scale = rho > 0 ? radius / rho : 0;
    point[0] = scale * d[0];
    point[1] = scale * d[1];
    point[2] = z;
}

/*
 * The superellipsoid is the unit ball of a norm that nests two p-norms; its support function is the dual norm,
 * h(d) = ((|a x|^q2 + |b y|^q2)^(q1/q2) + |c z|^q1)^(1/q1), and its support point the gradient.
 */
typedef struct dual_norm {
    double value, d1, d2; /* of N(u, v) = (u^q + v^q)^(1/q), u, v >= 0 */
    double d11, d12, d22;
} dual_norm;

static dual_norm dual_norm_at(double u, double v, double q)
{
    dual_norm n;
    memset(&n, 0, sizeof n);
    double scale = fmax(u, v);
    if (!(scale > 0)) return n;
    u /= scale;
    v /= scale;
    n.value = pow(pow(u, q) + pow(v, q), 1 / q);
    u /= n.value; /* now u^q + v^q = 1 */
    v /= n.value;
    n.value *= scale;
    n.d1 = pow(u, q - 1);
    n.d2 = pow(v, q - 1);
    /* d1 = u^(q-1) at norm 1; its derivatives are of degree -1. At u or v = 0 with q < 2 they are infinite: a flat
     * spot, bent as far as a double can be divided by. */
    double small = 1e-100, uu = pow(fmax(u, small), q - 2), vv = pow(fmax(v, small), q - 2);
    n.d11 = (q - 1) / n.value * uu * pow(v, q);
    n.d22 = (q - 1) / n.value * vv * pow(u, q);
    n.d12 = -(q - 1) / n.value * n.d1 * n.d2;
    return n;
}

static void superellipsoid_at(const pinch_core *core, const double *d, double *value, double *point, double *H)
{
    double u[3], sign[3];
    for (int i = 0; i < 3; i++) {
        u[i] = core->half[i] * fabs(d[i]);
        sign[i] = d[i] < 0 ? -1 : 1;
    }
    dual_norm across = dual_norm_at(u[0], u[1], core->power[1]);
    dual_norm all = dual_norm_at(across.value, u[2], core->power[0]);
    double g[3] = {across.d1 * core->half[0] * sign[0], across.d2 * core->half[1] * sign[1], 0};
    double z[3] = {0, 0, core->half[2] * sign[2]};
    *value = all.value;
    if (point)
        for (int i = 0; i < 3; i++) point[i] = all.d1 * g[i] + all.d2 * z[i];
    if (!H) return;
    double x = core->half[0] * sign[0], y = core->half[1] * sign[1];
    H[0] += all.d1 * across.d11 * x * x;
    H[4] += all.d1 * across.d22 * y * y;
    H[1] += all.d1 * across.d12 * x * y;
    H[3] += all.d1 * across.d12 * x * y;
    for (int i = 0; i < 9; i++) {
        int r = i / 3, c = i % 3;
        H[i] += all.d11 * g[r] * g[c] + all.d12 * (g[r] * z[c] + z[r] * g[c]) + all.d22 * z[r] * z[c];
    }
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
        hull_support(&core->hull->convex, d, point);
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
        superellipsoid_at(core, d, &value, point, NULL);
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
        superellipsoid_at(core, d, &value, NULL, H);
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

void pinch_pair_support_a(const pinch_core_pair *pair, const double n[3], double a[3])
{
    const double d[3] = {-n[0], -n[1], -n[2]};
    pinch_core_support(pair->a, d, a);
}

void pinch_pair_support_b(const pinch_core_pair *pair, const double n[3], double b[3])
{
    double d[3], local[3];
    pinch_pair_turn_back(pair, n, d);
    pinch_core_support(pair->b, d, local);
    pinch_pair_turn(pair, local, b);
    pinch_v3_add_scaled(b, 1, pair->p);
}

double pinch_pair_overlap(const pinch_core_pair *pair, const double n[3])
{
    double d[3];
    const double back[3] = {-n[0], -n[1], -n[2]};
    pinch_pair_turn_back(pair, n, d);
    return pinch_core_reach(pair->a, back) + pinch_core_reach(pair->b, d) + pinch_v3_dot(n, pair->p);
}

void pinch_pair_bend(const pinch_core_pair *pair, const double n[3], double H[9])
{
    const double back[3] = {-n[0], -n[1], -n[2]};
    double d[3], HB[9];
    pinch_core_bend(pair->a, back, H);
    if (pinch_core_is_polytope(pair->b)) return;
    pinch_pair_turn_back(pair, n, d);
    pinch_core_bend(pair->b, d, HB);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 9; k++) H[3 * i + j] += pair->R[3 * i + k / 3] * HB[k] * pair->R[3 * j + k % 3];
}
