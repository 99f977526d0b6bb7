/*
 * Where two rims meet, the normal is free in both directions. Newton's method goes down from the normals of faces and
 * sides next to that region, and from those cells of it that no bound excludes.
 */
#include "rim_pair.h"

#include "support/vec3.h"

#include <float.h>

/* The overlap of two rims at n, with its gradient and its second derivative in the tangent plane. The plane's axes are
 * the tangent t of A's rim and n x t. */
typedef struct rims {
    double f, rho, over, rho_b, g[2], M[3];
} rims;

/*
 * With u = (cosine, 0, -sine), the component of n across B's axis is (n.u) u + ny y, of length rho_b. The tangents of
 * the rims, (-ny, nx, 0)/rho and (-cosine ny, n.u, sine ny)/rho_b, rotate with n by radius/rho per angle. c leads from
 * the middle of one rim to that of the other.
 */
static void rims_at(const pinch_rim_frame *k, const double *c, const double *n, rims *at)
{
    double x = n[0], y = n[1], z = n[2], nu = k->cosine * x - k->sine * z;
    double rho = sqrt(x * x + y * y), rho_b = sqrt(nu * nu + y * y);
    double over = rho > 0 ? 1 / rho : 0, over_b = rho_b > 0 ? 1 / rho_b : 0;
    double hessian_a = over * k->pair->a->radius, hessian_b = over_b * k->pair->b->radius;
    double g[3] = {c[0] + hessian_a * x + hessian_b * nu * k->cosine, c[1] + (hessian_a + hessian_b) * y,
                   c[2] - hessian_b * nu * k->sine};
    double cos_t = over * over_b * (k->cosine * y * y + nu * x), sin_t = over * over_b * k->sine * y;
    at->f = pinch_v3_dot(g, n);
    at->rho = rho;
    at->over = over;
    at->rho_b = rho_b;
    at->g[0] = over * (x * g[1] - y * g[0]);
    at->g[1] = rho * g[2] - over * z * (x * g[0] + y * g[1]);
    at->M[0] = hessian_a + hessian_b * cos_t * cos_t - at->f;
    at->M[1] = hessian_b * cos_t * sin_t;
    at->M[2] = hessian_b * sin_t * sin_t - at->f;
}

/* Finds Newton's step at n in the tangent plane. Where the overlap is concave, it goes as far the other way. `fall` is
 * twice how far the overlap would fall if it were quadratic. Returns false where there is nothing to go by. */
static bool newton_step(const rims *at, const double *n, double step[3], double *fall)
{
    static const double LEAST_BEND = 1e-6;
    double a = at->M[0], b = at->M[1], c = at->M[2], trace = a + c, det = a * c - b * b;
    if (!(trace > 0 && det > LEAST_BEND * trace * trace)) {
        double skew = 0.5 * (a - c), spread = sqrt(skew * skew + b * b), lowest = 0.5 * trace - spread;
        double least = LEAST_BEND * (0.5 * trace + spread), lift = (-lowest > least ? -lowest : least) - lowest;
        if (!(spread > 0)) return false;
        double along =
            0.5 * lift * skew / spread; /* the projection on that direction is (1 - (M - trace/2)/spread)/2 */
        a += 0.5 * lift - along;
        c += 0.5 * lift + along;
        b -= 0.5 * lift * b / spread;
        det = a * c - b * b;
    }
    double scale = 1 / det, y0 = scale * (b * at->g[1] - c * at->g[0]), y1 = scale * (b * at->g[0] - a * at->g[1]);
    double turn = at->over * y0, up = at->over * y1 * n[2];
    if (at->rho > 0)
        pinch_v3_set(step, -turn * n[1] - up * n[0], turn * n[0] - up * n[1], at->rho * y1);
    else
        pinch_v3_set(step, 0, y0, 0);
    *fall = -(y0 * at->g[0] + y1 * at->g[1]);
    return true;
}

/* m is n + part step, made a unit vector. */
static void rotated(const double *n, const double *step, double part, double length2, double *m)
{
    double scale = 1 / sqrt(1 + part * part * length2);
    for (int i = 0; i < 3; i++) m[i] = scale * (n[i] + part * step[i]);
}

/* Returns the part of the step that stays at acute angles to the axes on these sides. */
static double part_inside(const pinch_rim_frame *k, const double *n, const double *step, const int side[2])
{
    double at[2] = {side[0] * n[2], side[1] * (k->sine * n[0] + k->cosine * n[2])};
    double by[2] = {side[0] * step[2], side[1] * (k->sine * step[0] + k->cosine * step[2])}, part = 1;
    for (int i = 0; i < 2; i++)
        if (at[i] + part * by[i] < 0) part = at[i] > 0 ? -at[i] / by[i] : 0;
    return part;
}

static bool is_outside(const pinch_rim_frame *k, const double *n, const int side[2])
{
    return side[0] * n[2] < 0 || side[1] * (k->sine * n[0] + k->cosine * n[2]) < 0;
}

/*
 * Newton's method for the rims on these sides starts from n (unit, in the frame), which it moves, and takes its end if
 * that is less. It gives up next to `known` (unit, in the frame; may be NULL), where it would end. It returns false
 * where the end is not between these rims or the method has not settled.
 *
 * Steps that rise are halved. Beyond right angles to the axes other rims count, so steps that lead there, or whose
 * slope ends above `best` before that, are given up. At its minimum the overlap is flat and tells normals apart to 1e-8
 * only, so short steps may rise by rounding. The error after a step is about its square, by a factor that the last two
 * steps tell.
 */
static bool descend_on_rims(const pinch_rim_frame *k, const int side[2], const double *known, double n[3],
                            pinch_contact_normal *best)
{
    enum { STEPS = 40, HALVINGS = 8 };
    static const double LONGEST = 0.3, SHORT = 1e-5, SETTLED = 1e-9, LEFT = 1e-13, TIE = 1e-14, BEYOND = 1e-3,
                        NEARBY = 0.995;
    const pinch_shape *a = k->pair->a, *b = k->pair->b;
    double rounding = TIE * (a->bound < b->bound ? a->bound : b->bound), y[3], m[3], before = DBL_MAX;
    const double c[3] = {k->m[0] + side[1] * b->half[2] * k->sine, k->m[1],
                         k->m[2] + side[0] * a->half[2] + side[1] * b->half[2] * k->cosine};
    rims at, next;
    pinch_rim_cap caps[2];
    int outside = is_outside(k, n, side);
    bool settled = false;
    if (known && pinch_v3_dot(n, known) > NEARBY) return false;
    pinch_rim_caps(k, side, caps);
    rims_at(k, c, n, &at);
    for (int step = 0; step < STEPS && !settled; step++) {
        double fall, up = k->sine * n[0] + k->cosine * n[2], least = best->overlap - rounding;
        if (pinch_rim_cap_is_less(&caps[0], side[0] * n[2], at.rho, least) ||
            pinch_rim_cap_is_less(&caps[1], side[1] * up, at.rho_b, least))
            return false;
        if (!newton_step(&at, n, y, &fall)) return false;
        if (!(at.f - fall * (BEYOND + part_inside(k, n, y, side)) < best->overlap)) return false;
        double length2 = pinch_v3_dot(y, y), length = sqrt(length2), part = 1;
        if (length > LONGEST) part = LONGEST / length;
        double most = at.f + (length < SHORT ? rounding : 0);
        int tries = 0;
        for (; tries < HALVINGS; tries++, part *= 0.5) {
            rotated(n, y, part, length2, m);
            rims_at(k, c, m, &next);
            if (next.f <= most) break;
        }
        if (tries == HALVINGS) break;
        at = next;
        pinch_v3_copy(n, m);
        outside = is_outside(k, n, side) ? outside + 1 : 0;
        if (outside == 2 || (known && pinch_v3_dot(n, known) > NEARBY)) return false;
        bool second = before < DBL_MAX;
        settled =
            part == 1 && (length < SETTLED || (second && length < SHORT && length2 * length < LEFT * before * before));
        before = part == 1 ? length : DBL_MAX;
    }
    if (!(at.f < best->overlap) || outside > 0) return settled;
    best->overlap = at.f;
    for (int i = 0; i < 3; i++) best->normal[i] = n[0] * k->axis[0][i] + n[1] * k->axis[1][i] + n[2] * k->axis[2][i];
    return settled;
}

/* Finds how far d, seen from a cylinder's middle, lies beyond the part that is farthest along the unit vector n: the
 * cap, the line along its side, or a single point of a rim, beyond which nothing lies. All are in the same axes. */
static bool beyond_part(const pinch_shape *shape, const double *axis, const double *n, const double *d, double *e)
{
    static const double FLAT = 1e-9, ON_AXIS = 1e-13; /* a sine; 1 less a cosine */
    double up = pinch_v3_dot(axis, n), height = pinch_v3_dot(axis, d);
    if (fabs(up) < FLAT) {
        double over = fabs(height) - shape->half[2];
        if (!pinch_has_rim(shape, height)) return false;
        for (int i = 0; i < 3; i++) e[i] = over > 0 ? copysign(over, height) * axis[i] : 0;
        return over > 0;
    }
    for (int i = 0; i < 3; i++) e[i] = d[i] - height * axis[i];
    double rho = pinch_v3_norm(e);
    if (1 - fabs(up) > ON_AXIS || !(rho > shape->radius)) return false;
    pinch_v3_scale(e, 1 - shape->radius / rho);
    return true;
}

/* The ends of a side that lies nearly flat on a cap are equally far along its normal. The one nearer to the cap's axis
 * decides. x is one end, `length` from the other along `along`. The cap has the middle `centre` and the axis `axis`. */
static void take_nearer_end(double *x, const double *along, double length, const double *centre, const double *axis)
{
    double to[3], other[3];
    pinch_v3_sub(x, centre, to);
    pinch_v3_copy(other, to);
    pinch_v3_add_scaled(other, length, along);
    pinch_v3_make_perpendicular(to, axis);
    pinch_v3_make_perpendicular(other, axis);
    if (pinch_v3_dot(other, other) < pinch_v3_dot(to, to)) pinch_v3_add_scaled(x, length, along);
}

bool pinch_descend_into_rims(const pinch_rim_frame *frame, const pinch_contact_normal *start,
                             pinch_contact_normal *best)
{
    static const double FARTHEST = 0.1, LYING = 1e-4, ON_AXIS = 1e-13; /* rad; a sine; 1 less a cosine */
    const pinch_shape_pair *pair = frame->pair;
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1}, origin[3] = {0, 0, 0};
    const pinch_shape *A = pair->a, *B = pair->b;
    double a[3], b[3], d[3], e[3], n[3], up = pinch_v3_dot(w, start->normal), other = up * up, z_up = start->normal[2];
    double radius = B->radius;
    pinch_pair_support_a(pair, start->normal, a);
    pinch_pair_support_b(pair, start->normal, b);
    bool on_b = 1 - fabs(up) < ON_AXIS && fabs(z_up) < LYING && A->kind == PINCH_SHAPE_CYLINDER;
    bool on_a = 1 - fabs(z_up) < ON_AXIS && fabs(up) < LYING && B->kind == PINCH_SHAPE_CYLINDER;
    if (on_b) take_nearer_end(a, z, -2 * copysign(A->half[2], a[2]), pair->p, w);
    if (on_a) take_nearer_end(b, w, -2 * copysign(B->half[2], up), origin, z);
    b[2] -= A->middle;
    if (!on_b && beyond_part(A, z, start->normal, b, e)) {
        pinch_v3_scale(e, -1);
    } else {
        pinch_v3_sub(a, pair->p, d);
        pinch_v3_add_scaled(d, -B->middle, w);
        if (on_a || !beyond_part(B, w, start->normal, d, e)) return true;
        other = z_up * z_up;
        radius = A->radius;
    }
    /* the overlap falls by e per angle, and the other rim, which rotates, takes back radius/sine */
    double length = pinch_v3_norm(e), into = fmin(FARTHEST, length * sqrt(fmax(1 - other, 1e-12)) / radius);
    pinch_v3_copy(d, start->normal);
    pinch_v3_add_scaled(d, into / length, e);
    for (int i = 0; i < 3; i++) n[i] = pinch_v3_dot(frame->axis[i], d);
    pinch_v3_scale(n, 1 / pinch_v3_norm(n));
    const int side[2] = {n[2] < 0 ? -1 : 1, pinch_v3_dot(w, d) < 0 ? -1 : 1};
    if (!pinch_has_rim(pair->a, -side[0]) || !pinch_has_rim(pair->b, side[1])) return false;
    return descend_on_rims(frame, side, NULL, n, best);
}

/* Where a rim lies a little beyond a cap's border, the way down from the cap's normal is too narrow to be met by
 * chance. `left` has a bit for every cap from which the search has started. */
static void descend_from_caps(const pinch_rim_frame *frame, const pinch_rim_cell *cell,
                              const pinch_contact_normal *from, unsigned *left, pinch_contact_normal *best)
{
    static const double LITTLE = 1, SAME = 1 - 1e-12;
    const double *R = frame->pair->R;
    pinch_rim_cap caps[2];
    if (!pinch_rim_cell_at_cap(cell, 0) && !pinch_rim_cell_at_cap(cell, 1)) return;
    pinch_rim_caps(frame, cell->side, caps);
    for (int which = 0; which < 2; which++) {
        double side = cell->side[which], radius = which ? frame->pair->b->radius : frame->pair->a->radius;
        unsigned bit = 1U << (2 * which + (side > 0));
        if (!pinch_rim_cell_at_cap(cell, which) || (*left & bit) || caps[which].inside > 0) continue;
        if (caps[which].inside < -LITTLE * radius) continue;
        pinch_contact_normal cap = {.normal = {0, 0, side}};
        for (int i = 0; i < 3 && which; i++) cap.normal[i] = side * R[3 * i + 2];
        *left |= bit;
        if (pinch_v3_dot(cap.normal, from->normal) < SAME) (void)pinch_descend_into_rims(frame, &cap, best);
    }
}

void pinch_search_rim_pairs(const pinch_rim_frame *frame, const pinch_contact_normal *from, pinch_contact_normal *best)
{
    pinch_rim_cell cells[PINCH_RIM_CELLS];
    int count = pinch_rim_cells(frame, best->overlap, cells);
    unsigned left = 0;
    while (count > 0) {
        int least = 0;
        double known[3];
        for (int k = 1; k < count; k++)
            if (cells[k].bound < cells[least].bound) least = k;
        if (!(cells[least].bound < best->overlap)) return;
        descend_from_caps(frame, &cells[least], from, &left, best);
        for (int i = 0; i < 3; i++) known[i] = pinch_v3_dot(frame->axis[i], best->normal);
        bool on_rims = best->overlap < from->overlap && pinch_rim_pair_is_level(frame->pair, best);
        (void)descend_on_rims(frame, cells[least].side, on_rims ? known : NULL, cells[least].n, best);
        cells[least] = cells[--count];
    }
}
