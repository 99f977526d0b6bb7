/*
 * Newton's method on the support functions. The gradient of the overlap p(n) = w.n is w(n) = b(n) - a(n). The overlap
 * is least (or the distance extreme) where w is parallel to n, so that its tangential part is zero. The derivative of
 * that on the tangent plane is H - p I, where H is the sum of the support Hessians. A flat face fixes the normal. A
 * straight edge keeps it perpendicular to the edge and leaves one unknown.
 */
#include "refine.h"

#include "collision/shape/superellipsoid.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MAX_STEPS = 12 };

/* the square of the last step */
static const double SETTLED = 1e-15;

/* in squared sizes: how far the two shapes' points may lie beside each other */
static const double ASIDE = 1e-20;

/* Directions this near (rad) to a cylinder's cap or side may mean the cap or side. */
static const double NEAR_FLAT = 0.03;

/* The overlap is flat at its minimum and tells normals apart to 1e-8 only. Where Newton's method has settled, it may
 * replace a normal of equal overlap to this part of the size. */
static const double TIE = 1e-14;

/* The flat part of a shape at the normal: none, an edge along u, or a face with the normal u. */
typedef struct flat_part {
    int kind; /* 0 none, 1 edge, 2 face */
    double u[3];
} flat_part;

/* The distinct vertices of a polytope in the simplex span the feature that touches. */
static flat_part flat_part_of_simplex(const double points[4][3], int count)
{
    flat_part part = {0, {0, 0, 0}};
    double distinct[4][3], e[3];
    int found = 0;
    for (int i = 0; i < count; i++) {
        bool known = false;
        for (int k = 0; k < found; k++) known = known || memcmp(distinct[k], points[i], sizeof distinct[k]) == 0;
        if (!known) memcpy(distinct[found++], points[i], sizeof distinct[0]);
    }
    if (found < 2) return part;
    pinch_v3_sub(distinct[1], distinct[0], part.u);
    part.kind = 1;
    if (found > 2) {
        pinch_v3_sub(distinct[2], distinct[0], e);
        pinch_v3_cross(part.u, e, part.u);
        part.kind = 2;
    }
    double length = pinch_v3_norm(part.u);
    if (!(length > 0)) part.kind = 0;
    if (part.kind) pinch_v3_scale(part.u, 1 / length);
    return part;
}

static flat_part flat_part_of_shape(const pinch_shape *shape, const double *d)
{
    flat_part part = {0, {0, 0, 1}};
    if (shape->kind != PINCH_SHAPE_CYLINDER && shape->kind != PINCH_SHAPE_FLAT_CAPSULE) return part;
    if (fabs(d[2]) < NEAR_FLAT) part.kind = 1;
    bool cap = shape->kind == PINCH_SHAPE_CYLINDER || d[2] < 0;
    if (cap && hypot(d[0], d[1]) < NEAR_FLAT) part.kind = 2;
    return part;
}

/* Finds the edge at the farthest vertex that is nearest to being at right angles to d. */
static void near_edge(const pinch_shape *shape, const double *d, flat_part *part)
{
    double least = NEAR_FLAT, most, u[3];
    if (shape->kind == PINCH_SHAPE_BOX) {
        for (int i = 0; i < 3; i++) {
            if (fabs(d[i]) >= least) continue;
            least = fabs(d[i]);
            part->kind = 1;
            pinch_v3_set(part->u, i == 0, i == 1, i == 2);
        }
        return;
    }
    if (shape->kind != PINCH_SHAPE_HULL) return;
    most = pinch_support_value(shape, d) - 0.1 * NEAR_FLAT * shape->bound;
    for (int e = 0; e < shape->hull->edge_count; e++) {
        const double *x = shape->hull->convex.points + 3 * shape->hull->edges[e].corner[0];
        pinch_v3_sub(shape->hull->convex.points + 3 * shape->hull->edges[e].corner[1], x, u);
        if (pinch_v3_dot(x, d) < most) continue;
        pinch_v3_scale(u, 1 / pinch_v3_norm(u));
        double along = fabs(pinch_v3_dot(u, d));
        if (along >= least) continue;
        least = along;
        part->kind = 1;
        pinch_v3_copy(part->u, u);
    }
}

/* Where no simplex tells, finds the polytope's face nearest to facing d, or the edge nearest to being at right angles
 * to d. */
static flat_part flat_part_of_polytope(const pinch_shape *shape, const double *d)
{
    flat_part part = {0, {0, 0, 0}};
    if (shape->kind == PINCH_SHAPE_SEGMENT) {
        part.kind = fabs(d[2]) < NEAR_FLAT;
        part.u[2] = 1;
        return part;
    }
    double best = 1 - 0.5 * NEAR_FLAT * NEAR_FLAT, f[3];
    for (int k = 0; k < pinch_face_count(shape); k++) {
        pinch_face_normal(shape, k, f);
        double along = pinch_v3_dot(f, d);
        if (along <= best) continue;
        best = along;
        part.kind = 2;
        pinch_v3_copy(part.u, f);
    }
    if (part.kind == 0) near_edge(shape, d, &part);
    return part;
}

static flat_part in_axes_of_a(const pinch_shape_pair *pair, int which, const flat_part *part)
{
    flat_part rotated = *part;
    if (which) pinch_pair_rotate(pair, part->u, rotated.u);
    return rotated;
}

/* Finds the flat part in A's axes. A simplex that has only one vertex may still be next to an edge or face. */
static flat_part flat_part_of(const pinch_shape_pair *pair, int which, const double *n, const pinch_gjk_result *simplex)
{
    const pinch_shape *shape = which ? pair->b : pair->a;
    double d[3] = {-n[0], -n[1], -n[2]};
    if (which) pinch_pair_rotate_back(pair, n, d);
    if (!pinch_is_polytope(shape)) {
        flat_part part = flat_part_of_shape(shape, d);
        return in_axes_of_a(pair, which, &part);
    }
    if (simplex) {
        flat_part part = flat_part_of_simplex(which ? simplex->b : simplex->a, simplex->count);
        if (part.kind) return part;
    }
    flat_part part = flat_part_of_polytope(shape, d);
    return in_axes_of_a(pair, which, &part);
}

static bool step_along(double *n, const double *y)
{
    double length = pinch_v3_norm(y);
    if (!isfinite(length)) return false;
    pinch_v3_add_scaled(n, length > 0.2 ? 0.2 / length : 1, y);
    pinch_v3_scale(n, 1 / pinch_v3_norm(n));
    return true;
}

static void separation(const pinch_shape_pair *pair, const double *n, double *w)
{
    double a[3];
    pinch_pair_support_a(pair, n, a);
    pinch_pair_support_b(pair, n, w);
    pinch_v3_add_scaled(w, -1, a);
}

/* The step is y = -(T'(H - p I)T)^-1 T'w in the tangent plane, or along t1 alone. */
static bool newton_step(const pinch_shape_pair *pair, const double *n, const double *t1, const double *t2, double *y)
{
    double w[3], H[9], H1[3], H2[3] = {0, 0, 0};
    separation(pair, n, w);
    pinch_pair_hessian(pair, n, H);
    double p = pinch_v3_dot(w, n), g1 = pinch_v3_dot(w, t1);
    for (int i = 0; i < 3; i++) H1[i] = pinch_v3_dot(H + 3 * i, t1);
    double a = pinch_v3_dot(t1, H1) - p;
    if (!t2) {
        if (!(a > 0)) return false;
        for (int i = 0; i < 3; i++) y[i] = -g1 / a * t1[i];
        return true;
    }
    for (int i = 0; i < 3; i++) H2[i] = pinch_v3_dot(H + 3 * i, t2);
    double b = pinch_v3_dot(t1, H2), c = pinch_v3_dot(t2, H2) - p, g2 = pinch_v3_dot(w, t2), det = a * c - b * b;
    if (!(a > 0) || !(det > 0)) return false;
    double y1 = (b * g2 - c * g1) / det, y2 = (b * g1 - a * g2) / det;
    for (int i = 0; i < 3; i++) y[i] = y1 * t1[i] + y2 * t2[i];
    return true;
}

/* A superellipsoid's curvature varies without bounds, so Newton's method need not be as good as the square of its last
 * step. */
static bool is_uneven(const pinch_shape *shape)
{
    return shape->kind == PINCH_SHAPE_SUPERELLIPSOID;
}

/* Returns the square of what is left of the gradient. */
static double residual(const pinch_shape_pair *pair, const double *n)
{
    double w[3];
    separation(pair, n, w);
    pinch_v3_make_perpendicular(w, n);
    return pinch_v3_dot(w, w);
}

/*
 * Takes the same step y on the surface of shape `which`: its point moves by H y, and the new normal is the one there.
 * Where the shape is flat that is nearly linear, while the point moves with a small root of the normal's tilt.
 */
static bool step_on_surface(const pinch_shape_pair *pair, int which, const double *start, const double *y, double *n)
{
    const pinch_shape *shape = which ? pair->b : pair->a;
    double d[3] = {-start[0], -start[1], -start[2]}, e[3] = {-y[0], -y[1], -y[2]}, x[3], H[9], f[3];
    if (which) {
        pinch_pair_rotate_back(pair, start, d);
        pinch_pair_rotate_back(pair, y, e);
    }
    pinch_support_point(shape, d, x);
    pinch_support_hessian(shape, d, H);
    for (int i = 0; i < 3; i++) x[i] += pinch_v3_dot(H + 3 * i, e);
    if (!isfinite(x[0] + x[1] + x[2])) return false;
    (void)pinch_superellipsoid_norm(shape->half, shape->power, x, f);
    double length = pinch_v3_norm(f);
    if (!(length > 0)) return false;
    for (int i = 0; i < 3; i++) n[i] = f[i] / (which ? length : -length);
    if (!which) return true;
    pinch_pair_rotate(pair, n, f);
    pinch_v3_copy(n, f);
    return true;
}

/* Takes the step itself or a step on a superellipsoid's surface, whichever leaves least. Returns what it leaves. */
static double best_step(const pinch_shape_pair *pair, const double *start, const double *y, double *n)
{
    double least = residual(pair, n), other[3];
    for (int which = 0; which < 2; which++) {
        if (!is_uneven(which ? pair->b : pair->a) || !step_on_surface(pair, which, start, y, other)) continue;
        double left = residual(pair, other);
        if (!(left < least)) continue;
        least = left;
        pinch_v3_copy(n, other);
    }
    return least;
}

/* The best normal so far, and whether it is known to have the least overlap nearby. */
typedef struct candidate {
    pinch_contact_normal *best;
    bool settled;
} candidate;

/* Iterates from `start`, kept perpendicular to u (NULL: free). */
static void iterate(const pinch_shape_pair *pair, const double *start, const double *u, candidate *c)
{
    double n[3], t1[3], t2[3], y[3], from[3];
    pinch_v3_copy(n, start);
    if (u) {
        pinch_v3_make_perpendicular(n, u);
        double length = pinch_v3_norm(n);
        if (!(length > 0.5)) return;
        pinch_v3_scale(n, 1 / length);
    }
    bool settled = false, uneven = is_uneven(pair->a) || is_uneven(pair->b);
    double before = DBL_MAX, size = fmin(pair->a->bound, pair->b->bound), far = ASIDE * size * size;
    for (int k = 0; k < MAX_STEPS; k++) {
        if (u)
            pinch_v3_cross(n, u, t1);
        else
            pinch_v3_any_perpendicular(n, t1);
        pinch_v3_cross(n, t1, t2);
        pinch_v3_copy(from, n);
        if (!newton_step(pair, n, t1, u ? NULL : t2, y) || !step_along(n, y)) break;
        settled = pinch_v3_dot(y, y) < SETTLED; /* the square of the step is the error that is left */
        double left = uneven && !u ? best_step(pair, from, y, n) : 0;
        if (left > far) settled = false; /* a flat shape's point may be elsewhere at a normal that is just as good */
        if (settled && !(uneven && !u && left < 0.25 * before)) break;
        before = left;
    }
    double overlap = pinch_pair_overlap(pair, n);
    if (!(overlap < c->best->overlap + (settled ? TIE * size : 0))) return;
    c->best->overlap = overlap;
    pinch_v3_copy(c->best->normal, n);
    c->settled = settled;
}

/* Offers the face's normal itself, on the side of the best one. */
static void along_face(const pinch_shape_pair *pair, const double *u, candidate *c)
{
    double n[3];
    pinch_v3_copy(n, u);
    if (pinch_v3_dot(n, c->best->normal) < 0) pinch_v3_scale(n, -1);
    pinch_offer_normal(pair, n, c->best);
    c->settled = c->settled || fabs(pinch_v3_dot(n, c->best->normal)) > 1 - 1e-15;
}

/* All combinations of features that may touch compete, and the least overlap wins. */
static bool refine(const pinch_shape_pair *pair, const pinch_gjk_result *simplex, pinch_contact_normal *best)
{
    double start[3], across[3];
    candidate c = {best, false};
    pinch_v3_copy(start, best->normal);
    flat_part a = flat_part_of(pair, 0, start, simplex), b = flat_part_of(pair, 1, start, simplex);
    double before = best->overlap, rounding = TIE * fmin(pair->a->bound, pair->b->bound);
    if (a.kind == 2) along_face(pair, a.u, &c);
    if (b.kind == 2) along_face(pair, b.u, &c);
    /* the face gives the normal to rounding, or a better one; a kink has no smooth neighbours to look at */
    if (c.settled && (best->overlap < before - rounding || fabs(pinch_v3_dot(start, best->normal)) > 1 - 1e-15))
        return true;
    if (a.kind == 1 && b.kind == 1) {
        pinch_v3_cross(a.u, b.u, across);
        double length = pinch_v3_norm(across);
        if (length > 1e-6) {
            pinch_v3_scale(across, 1 / length);
            along_face(pair, across, &c);
        }
    }
    if (a.kind == 1) iterate(pair, start, a.u, &c);
    if (b.kind == 1) iterate(pair, start, b.u, &c);
    iterate(pair, start, NULL, &c);
    return c.settled;
}

bool pinch_refine_normal(const pinch_shape_pair *pair, const pinch_gjk_result *simplex, pinch_contact_normal *best)
{
    bool settled = refine(pair, simplex, best);
    /* the simplex may have kept vertices that do not belong to the edge next to the answer */
    bool polytope = pinch_is_polytope(pair->a) || pinch_is_polytope(pair->b);
    if (simplex && polytope) settled = refine(pair, NULL, best);
    return settled;
}
