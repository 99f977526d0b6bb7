/*
 * Where two rims meet the normal is free in both directions. Newton's method goes down from the faces' and sides'
 * normals next to that region, and where bodies are deep in each other from all around it.
 */
#include "rims.h"

#include "rim_arc.h"
#include "support/vec3.h"

#include <float.h>

/* How far `d`, seen from a cylinder's middle, lies beyond what is as far along n (unit) as any of its points: the cap,
 * the line along its side, or a single point of a rim (which nothing lies beyond). In the axes of both vectors. */
static bool beyond_part(const pinch_core *core, const double *axis, const double *n, const double *d, double *e)
{
    static const double FLAT = 1e-9, ON_AXIS = 1e-13; /* sine, 1 less the cosine */
    double up = pinch_v3_dot(axis, n), height = pinch_v3_dot(axis, d);
    if (fabs(up) < FLAT) {
        double over = fabs(height) - core->half[2];
        if (!pinch_core_has_rim(core, height)) return false;
        for (int i = 0; i < 3; i++) e[i] = over > 0 ? copysign(over, height) * axis[i] : 0;
        return over > 0;
    }
    for (int i = 0; i < 3; i++) e[i] = d[i] - height * axis[i];
    double rho = pinch_v3_norm(e);
    if (1 - fabs(up) > ON_AXIS || !(rho > core->radius)) return false;
    pinch_v3_scale(e, 1 - core->radius / rho);
    return true;
}

/* Two rims at n: the overlap, its gradient in the tangent plane, and its second derivative there in the frame (t, n x
 * t) of A's rim. Where an end has no rim there is only f, which is beyond anything. */
typedef struct rims {
    double f, g[3], t[3], M[3];
} rims;

static void look_at_rims(const pinch_core_pair *pair, const double *w, const double *n, rims *at)
{
    const pinch_core *a = pair->a, *b = pair->b;
    double up = pinch_v3_dot(w, n), m[3], across[3], u[3], t[3];
    if (!pinch_core_has_rim(a, -n[2]) || !pinch_core_has_rim(b, up)) {
        at->f = DBL_MAX;
        return;
    }
    double rho_a = sqrt(n[0] * n[0] + n[1] * n[1]), over_a = rho_a > 0 ? a->radius / rho_a : 0;
    pinch_v3_cross(w, n, t);
    pinch_v3_cross(t, w, u); /* n less its part along w; at right angles to w however short it is */
    double rho_b = pinch_v3_norm(u), over_b = rho_b > 0 ? b->radius / rho_b : 0;
    pinch_pair_between_middles(pair, w, m);
    for (int i = 0; i < 3; i++) at->g[i] = m[i] + over_b * u[i] + copysign(b->half[2], up) * w[i];
    at->g[0] += over_a * n[0];
    at->g[1] += over_a * n[1];
    at->g[2] += copysign(a->half[2], n[2]);
    at->f = pinch_v3_dot(at->g, n);
    pinch_v3_add_scaled(at->g, -at->f, n);
    pinch_v3_set(at->t, rho_a > 0 ? -n[1] / rho_a : 1, rho_a > 0 ? n[0] / rho_a : 0, 0);
    pinch_v3_cross(n, at->t, across);
    double scale = rho_b > 0 ? 1 / rho_b : 0, c = scale * pinch_v3_dot(t, at->t), s = scale * pinch_v3_dot(t, across);
    at->M[0] = over_a + over_b * c * c - at->f;
    at->M[1] = over_b * c * s;
    at->M[2] = over_b * s * s - at->f;
}

/* Newton's step; the second derivative is lifted where it is not positive. False where there is nothing to go by. */
static bool newton_step(const rims *at, const double *n, double *y)
{
    static const double LEAST_BEND = 1e-3;
    double across[3], half_trace = 0.5 * (at->M[0] + at->M[2]), skew = 0.5 * (at->M[0] - at->M[2]);
    double spread = sqrt(skew * skew + at->M[1] * at->M[1]), lowest = half_trace - spread;
    double floor = LEAST_BEND * (half_trace + spread), lift = lowest < floor ? floor - lowest : 0;
    if (!(floor > 0)) return false;
    pinch_v3_cross(n, at->t, across);
    double g1 = pinch_v3_dot(at->g, at->t), g2 = pinch_v3_dot(at->g, across);
    double a = at->M[0] + lift, c = at->M[2] + lift, det = a * c - at->M[1] * at->M[1];
    double y1 = (at->M[1] * g2 - c * g1) / det, y2 = (at->M[1] * g1 - a * g2) / det;
    for (int i = 0; i < 3; i++) y[i] = y1 * at->t[i] + y2 * across[i];
    return true;
}

/* Newton's method, made to go down: steps that rise are halved. At its minimum the overlap is flat, and tells normals
 * apart to 1e-8 only: of short steps Newton's method knows better. False where it has not settled. */
static bool descend_on_rims(const pinch_core_pair *pair, const double *w, double *n, pinch_contact_normal *best)
{
    enum { STEPS = 40, HALVINGS = 8 };
    static const double LONGEST = 0.3, SHORT = 1e-5, SETTLED = 1e-9, TIE = 1e-14;
    double rounding = TIE * fmin(pair->a->bound, pair->b->bound), y[3], m[3];
    rims at, next;
    bool settled = false;
    look_at_rims(pair, w, n, &at);
    if (at.f == DBL_MAX) return false;
    for (int k = 0; k < STEPS && !settled; k++) {
        if (!newton_step(&at, n, y)) return true;
        double length = pinch_v3_norm(y), part = length > LONGEST ? LONGEST / length : 1;
        double most = at.f + (length < SHORT ? rounding : 0);
        int tries = 0;
        for (; tries < HALVINGS; tries++, part *= 0.5) {
            pinch_v3_copy(m, n);
            pinch_v3_add_scaled(m, part, y);
            pinch_v3_scale(m, 1 / pinch_v3_norm(m));
            look_at_rims(pair, w, m, &next);
            if (next.f <= most) break;
        }
        if (tries == HALVINGS) break;
        at = next;
        pinch_v3_copy(n, m);
        settled = part == 1 && length < SETTLED;
    }
    if (!(at.f < best->overlap)) return settled;
    best->overlap = at.f;
    pinch_v3_copy(best->normal, n);
    return settled;
}

bool pinch_rims_from(const pinch_core_pair *pair, const pinch_contact_normal *start, pinch_contact_normal *best)
{
    static const double FARTHEST = 0.1; /* rad */
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1};
    double a[3], b[3], d[3], e[3], n[3], up = pinch_v3_dot(w, start->normal), other = up * up;
    double radius = pair->b->radius;
    pinch_pair_support_a(pair, start->normal, a);
    pinch_pair_support_b(pair, start->normal, b);
    b[2] -= pair->a->middle;
    if (beyond_part(pair->a, z, start->normal, b, e)) {
        pinch_v3_scale(e, -1);
    } else {
        pinch_v3_sub(a, pair->p, d);
        pinch_v3_add_scaled(d, -pair->b->middle, w);
        if (!beyond_part(pair->b, w, start->normal, d, e)) return true;
        other = start->normal[2] * start->normal[2];
        radius = pair->a->radius;
    }
    /* the overlap falls by e, and the other rim, turning around, takes back radius/sine per angle */
    double length = pinch_v3_norm(e), into = fmin(FARTHEST, length * sqrt(fmax(1 - other, 1e-12)) / radius);
    pinch_v3_copy(n, start->normal);
    pinch_v3_add_scaled(n, into / length, e);
    pinch_v3_scale(n, 1 / pinch_v3_norm(n));
    return descend_on_rims(pair, w, n, best);
}

/* One point of A's rim, at `out` from its axis, and a rim of B: the normals are at right angles to A's rim there. `m`
 * leads from middle to middle. */
static bool rim_at(const pinch_core_pair *pair, const double *w, const double *m, const double out[2], double side_a,
                   double side_b, pinch_contact_normal *found)
{
    const pinch_core *a = pair->a, *b = pair->b;
    double axis[2] = {side_b * (out[0] * w[0] + out[1] * w[1]), side_b * side_a * w[2]};
    double Q2 = axis[0] * axis[0] + axis[1] * axis[1], c, s;
    if (!(Q2 > 1e-16) || (axis[0] <= 0 && axis[1] <= 0)) return false;
    double sine = sqrt(Q2), across = out[0] * w[1] - out[1] * w[0], x[2] = {axis[0] / sine, axis[1] / sine};
    double P[2] = {a->radius + out[0] * m[0] + out[1] * m[1] + b->half[2] * axis[0],
                   a->half[2] + side_a * m[2] + b->half[2] * axis[1]};
    double X = P[0] * x[0] + P[1] * x[1], Y = P[1] * x[0] - P[0] * x[1], across2 = across * across;
    if (!pinch_rim_least(X, Y, b->radius, across2, Q2, &c, &s)) return false;
    double radial = c * x[0] - s * x[1], up = c * x[1] + s * x[0];
    if (!(radial > 0) || !(up > 0)) return false;
    pinch_v3_set(found->normal, radial * out[0], radial * out[1], side_a * up);
    found->overlap = X * c + Y * s + b->radius * sqrt(across2 + Q2 * s * s);
    return true;
}

/*
 * With the point of A's rim held, the overlap has one local minimum; all around the rim these make a line, whose lowest
 * places Newton's method finishes.
 */
void pinch_search_rims(const pinch_core_pair *pair, double size, pinch_contact_normal *best)
{
    enum { POINTS = 24 };
    static const double STEP = 0.26179938779914943; /* rad */
    /* between two points the line is lower than at them by less than this part of the size */
    static const double BETWEEN = 0.05;
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]};
    double m[3];
    pinch_pair_between_middles(pair, w, m);
    for (int which = 0; which < 4; which++) {
        pinch_contact_normal line[POINTS];
        double side_a = which & 1 ? 1 : -1, side_b = which & 2 ? 1 : -1;
        if (!pinch_core_has_rim(pair->a, -side_a) || !pinch_core_has_rim(pair->b, side_b)) continue;
        for (int k = 0; k < POINTS; k++) {
            const double out[2] = {cos(k * STEP), sin(k * STEP)};
            if (!rim_at(pair, w, m, out, side_a, side_b, &line[k])) line[k].overlap = DBL_MAX;
        }
        for (int k = 0; k < POINTS; k++) {
            double before = line[(k + POINTS - 1) % POINTS].overlap, after = line[(k + 1) % POINTS].overlap;
            if (line[k].overlap > before || line[k].overlap > after) continue;
            if (line[k].overlap < best->overlap + BETWEEN * size) (void)descend_on_rims(pair, w, line[k].normal, best);
        }
    }
}
