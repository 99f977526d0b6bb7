/*
 * Sharp cylinders that overlap boxes and each other. Where the overlap p(n) = h_A(-n) + h_B(n) is least and positive,
 * the difference of the bodies has a smooth surface (no ball touches a sharp edge from inside), so one of these meets
 * there: a face and anything (n is its normal); side and edge or side and side (n is their common perpendicular); side
 * and corner (n is at right angles to the axis, towards the corner); rim and edge, or rim and side (n is at right
 * angles to the straight one, which leaves one unknown); or two rims, with two unknowns.
 *
 * With one unknown, n = c a + s b on a quarter of a great circle, the overlap is
 * f = K + Pa c + Pb s + r sqrt(1 - q^2) + H |q|, q = wa c + wb s. Its ends bound it from below (a support function
 * lies above the plane of each of its support points), so that few quarters are ever searched.
 */
#include "normal.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>

/* Up to this part of the size the overlap is convex enough along its arcs for one search each. */
static const double SHALLOW = 0.03;

/* A face gives the steadier contact: anything else must be better by this much of the size. */
static const double FACE_BONUS = 1e-9;

/* Two rims: starts this much worse (of the size) than the best lead nowhere better. */
static const double HOPELESS = 0.15;
static const double NEARBY = 0.995; /* cosine of 0.1 rad */

typedef struct arc {
    double a[3], b[3]; /* unit, at right angles */
    double K, Pa, Pb;  /* m */
    double r, H;       /* the cylinder's, m */
    double wa, wb, m;  /* its axis along a, b, and the square of the rest */
    bool finely;
} arc;

/* A place on an arc, its overlap, and the first two derivatives along the arc. */
typedef struct place {
    double c, s, f, slope, bend;
} place;

/* side: of q, where it is 0 */
static void look(const arc *k, double c, double s, double side, place *at)
{
    double q = k->wa * c + k->wb * s, turn = k->wb * c - k->wa * s, away2 = k->m + turn * turn, away = sqrt(away2);
    double over = away > 0 ? k->r / away : 0, sign = q != 0 ? copysign(1, q) : side, flat = k->Pa * c + k->Pb * s;
    at->c = c;
    at->s = s;
    at->f = k->K + flat + k->r * away + k->H * sign * q;
    at->slope = k->Pb * c - k->Pa * s - over * q * turn + k->H * sign * turn;
    at->bend = -flat + over * (q * q - turn * turn - (away > 0 ? q * q * turn * turn / away2 : 0)) - k->H * sign * q;
}

static void offer_place(const arc *k, const place *at, double bonus, pinch_contact_normal *best)
{
    if (!(at->f < best->overlap - bonus)) return;
    best->overlap = at->f;
    for (int i = 0; i < 3; i++) best->normal[i] = at->c * k->a[i] + at->s * k->b[i];
}

/* Onwards by the angle whose tangent is t. */
static void turned_by(const place *from, double t, double *c, double *s)
{
    double scale = 1 / sqrt(1 + t * t);
    *c = scale * (from->c - t * from->s);
    *s = scale * (from->s + t * from->c);
}

/* Between two places with the same side of q: Newton's method for the slope's root, kept between bounds. */
static void search(const arc *k, place low, place high, double side, double bonus, pinch_contact_normal *best)
{
    enum { STEPS = 40 };
    if (!(low.slope < 0 && high.slope > 0)) return;
    double cosine = low.c * high.c + low.s * high.s, sine = low.c * high.s - low.s * high.c;
    double f = high.f * cosine - high.slope * sine, slope = high.f * sine + high.slope * cosine;
    double t = (low.f - f) / (slope - low.slope); /* where the two bounds from below cross */
    if (t > 0 && low.f > 0 && (low.f + low.slope * t) / sqrt(1 + t * t) >= best->overlap - bonus) return;
    place at;
    double c, s;
    turned_by(&low, t, &c, &s);
    bool last = false;
    for (int step = 0; step < STEPS; step++) {
        if (!last && !(low.c * s - low.s * c > 0 && c * high.s - s * high.c > 0)) {
            c = low.c + high.c;
            s = low.s + high.s;
            double scale = 1 / sqrt(c * c + s * s);
            c *= scale;
            s *= scale;
        }
        look(k, c, s, side, &at);
        if (last) break;
        if (at.slope < 0)
            low = at;
        else
            high = at;
        t = at.bend > 0 ? -at.slope / at.bend : copysign(1, -at.slope);
        turned_by(&at, t, &c, &s);
        last = fabs(t) < 1e-8; /* its square is left */
    }
    offer_place(k, &at, bonus, best);
}

/* Deep bodies: piece by piece. */
static void search_between(const arc *k, const place *low, const place *high, double side, double bonus,
                           pinch_contact_normal *best)
{
    enum { PIECES = 24 };
    place from = *low, to;
    for (int piece = 1; piece < PIECES && k->finely; piece++) {
        double part = (double)piece / PIECES, c = (1 - part) * low->c + part * high->c;
        double s = (1 - part) * low->s + part * high->s, scale = 1 / sqrt(c * c + s * s);
        look(k, scale * c, scale * s, side, &to);
        search(k, from, to, side, bonus, best);
        from = to;
    }
    search(k, from, *high, side, bonus, best);
}

/*
 * From where q = 0 to another place. The rim's radius of curvature in this projection, r m/away^3, is least at q = 0
 * and grows from there; where it is less than the overlap, that is concave, and a minimum beyond may be hidden behind a
 * maximum: the parts are looked at on their own. Deep bodies' arcs are cut up finely instead.
 */
static void search_beside(const arc *k, const place *kink, const place *end, double side, double bonus,
                          pinch_contact_normal *best)
{
    double turn = k->wb * kink->c - k->wa * kink->s, whole2 = turn * turn;
    double sign = kink->c * end->s - kink->s * end->c > 0 ? 1 : -1; /* the way from the kink to the end */
    place from = *kink, to;
    if (!k->finely && k->r * k->m < best->overlap) {
        double away = cbrt(k->r * k->m / best->overlap), turn2 = away * away - k->m;
        if (turn2 > 0 && turn2 < whole2) { /* the axis' part in this plane is `turn` at q = 0, and turns from there */
            double c = sqrt(turn2 / whole2), s = sign * sqrt(1 - turn2 / whole2);
            double x = c * kink->c - s * kink->s, y = s * kink->c + c * kink->s;
            if (sign * (x * end->s - y * end->c) > 0) {
                look(k, x, y, side, &to);
                search(k, sign > 0 ? from : to, sign > 0 ? to : from, side, bonus, best);
                from = to;
            }
        }
    }
    search_between(k, sign > 0 ? &from : end, sign > 0 ? end : &from, side, bonus, best);
}

static void search_arc(const arc *k, double bonus, pinch_contact_normal *best)
{
    static const double INSIDE = 1e-12; /* the ends themselves may be kinks */
    /* K + c Pa + s Pb + min(r, H) is not above the overlap */
    double lowest = k->Pa < 0 && k->Pb < 0 ? -sqrt(k->Pa * k->Pa + k->Pb * k->Pb) : k->Pa < k->Pb ? k->Pa : k->Pb;
    if (k->K + lowest + (k->r < k->H ? k->r : k->H) >= best->overlap - bonus) return;
    place low, high, before, after;
    look(k, 1, INSIDE, 0, &low);
    look(k, INSIDE, 1, 0, &high);
    if (!(k->wa * k->wb < 0)) {
        if (k->wa == 0)
            search_beside(k, &low, &high, copysign(1, k->wb), bonus, best);
        else if (k->wb == 0)
            search_beside(k, &high, &low, copysign(1, k->wa), bonus, best);
        else
            search_between(k, &low, &high, 0, bonus, best);
        return;
    }
    double scale = 1 / sqrt(k->wa * k->wa + k->wb * k->wb), c = fabs(k->wb) * scale, s = fabs(k->wa) * scale;
    look(k, c, s, copysign(1, k->wa), &before);
    look(k, c, s, copysign(1, k->wb), &after);
    search_beside(k, &before, &low, copysign(1, k->wa), bonus, best);
    search_beside(k, &after, &high, copysign(1, k->wb), bonus, best);
}

/* An axis, and how far both bodies reach along it together; the normal is the one of +-n that leads from B's middle
 * towards A's. */
static void offer_axis(const pinch_core_pair *pair, double x, double y, double z, double reach, double bonus,
                       pinch_contact_normal *best)
{
    double along = x * pair->p[0] + y * pair->p[1] + z * pair->p[2], overlap = reach - fabs(along);
    if (!(overlap < best->overlap - bonus)) return;
    double sign = along > 0 ? -1 : 1;
    best->overlap = overlap;
    pinch_v3_set(best->normal, sign * x, sign * y, sign * z);
}

static void side_and_corners(const pinch_core_pair *pair, const double *w, double bonus, pinch_contact_normal *best)
{
    const double *h = pair->a->half, *p = pair->p;
    double r = pair->b->radius, along = pinch_v3_dot(w, p);
    const double middle[3] = {p[0] - along * w[0], p[1] - along * w[1], p[2] - along * w[2]};
    for (int k = 0; k < 8; k++) {
        const double v[3] = {k & 1 ? h[0] : -h[0], k & 2 ? h[1] : -h[1], k & 4 ? h[2] : -h[2]};
        double at = pinch_v3_dot(w, v), d[3], length2 = 0;
        bool supports = true; /* is the corner the box' farthest one along d? */
        for (int i = 0; i < 3; i++) {
            d[i] = middle[i] - v[i] + at * w[i];
            supports = supports && d[i] * v[i] >= 0;
            length2 += d[i] * d[i];
        }
        double least = r - best->overlap + bonus;
        if (!supports || !(length2 > 0) || (least > 0 && length2 < least * least)) continue;
        double length = sqrt(length2);
        best->overlap = r - length;
        for (int i = 0; i < 3; i++) best->normal[i] = -d[i] / length;
    }
}

static void rims_and_edges(const pinch_core_pair *pair, const double *w, double bonus, pinch_contact_normal *best)
{
    const double *h = pair->a->half, *p = pair->p;
    bool deep = best->overlap > SHALLOW * fmin(pair->a->bound, pair->b->bound);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, l = (i + 2) % 3;
        for (int corner = 0; corner < 4; corner++) {
            double sj = corner & 1 ? 1 : -1, sl = corner & 2 ? 1 : -1;
            arc k = {.Pa = h[j] + sj * p[j],
                     .Pb = h[l] + sl * p[l],
                     .r = pair->b->radius,
                     .H = pair->b->half[2],
                     .wa = sj * w[j],
                     .wb = sl * w[l],
                     .m = w[i] * w[i],
                     .finely = deep};
            k.a[j] = sj;
            k.b[l] = sl;
            search_arc(&k, bonus, best);
        }
    }
}

static void box_and_cylinder(const pinch_core_pair *pair, double bonus, pinch_contact_normal *best)
{
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]};
    const double *h = pair->a->half, W[3] = {fabs(w[0]), fabs(w[1]), fabs(w[2])};
    double r = pair->b->radius, H = pair->b->half[2], sine[3];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, l = (i + 2) % 3;
        sine[i] = sqrt(w[j] * w[j] + w[l] * w[l]);
        offer_axis(pair, i == 0, i == 1, i == 2, h[i] + r * sine[i] + H * W[i], 0, best);
    }
    offer_axis(pair, w[0], w[1], w[2], h[0] * W[0] + h[1] * W[1] + h[2] * W[2] + H, 0, best);
    for (int i = 0; i < 3; i++) { /* e_i x w */
        int j = (i + 1) % 3, l = (i + 2) % 3;
        if (!(sine[i] > 1e-8)) continue;
        double n[3] = {0, 0, 0}, scale = 1 / sine[i];
        n[j] = -w[l] * scale;
        n[l] = w[j] * scale;
        offer_axis(pair, n[0], n[1], n[2], (h[j] * W[l] + h[l] * W[j]) * scale + r, bonus, best);
    }
    side_and_corners(pair, w, bonus, best);
    rims_and_edges(pair, w, bonus, best);
}

/* The side of the cylinder whose axis is `axis` against the rims of the other (`other`, of axis `w`). */
static void side_and_rims(const pinch_core_pair *pair, const pinch_core *straight, const double *axis,
                          const pinch_core *other, const double *w, double bonus, pinch_contact_normal *best)
{
    double x[3], y[3], along = pinch_v3_dot(axis, w);
    pinch_v3_cross(axis, w, x);
    double sine = pinch_v3_norm(x);
    if (sine > 1e-8)
        pinch_v3_scale(x, 1 / sine);
    else
        pinch_v3_any_perpendicular(axis, x);
    pinch_v3_cross(axis, x, y);
    for (int corner = 0; corner < 4; corner++) {
        double sx = corner & 1 ? 1 : -1, sy = corner & 2 ? 1 : -1;
        arc k = {.K = straight->radius,
                 .Pa = sx * pinch_v3_dot(x, pair->p),
                 .Pb = sy * pinch_v3_dot(y, pair->p),
                 .r = other->radius,
                 .H = other->half[2],
                 .wb = sy * pinch_v3_dot(y, w),
                 .m = along * along};
        for (int i = 0; i < 3; i++) {
            k.a[i] = sx * x[i];
            k.b[i] = sy * y[i];
        }
        search_arc(&k, bonus, best);
    }
}

/* How far `d`, seen from a cylinder's middle, lies beyond what is as far along n (unit) as any of its points: the cap,
 * the line along its side, or a single point of a rim (which nothing lies beyond). In the axes of both vectors. */
static bool beyond_part(const pinch_core *core, const double *axis, const double *n, const double *d, double *e)
{
    static const double FLAT = 1e-9, ON_AXIS = 1e-13; /* sine, 1 less the cosine */
    double up = pinch_v3_dot(axis, n), height = pinch_v3_dot(axis, d);
    if (fabs(up) < FLAT) {
        double over = fabs(height) - core->half[2];
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
 * t) of A's rim. */
typedef struct rims {
    double f, g[3], t[3], M[3];
} rims;

static void look_at_rims(const pinch_core_pair *pair, const double *w, const double *n, rims *at)
{
    const pinch_core *a = pair->a, *b = pair->b;
    double up = pinch_v3_dot(w, n), across[3], u[3], t[3];
    double rho_a = sqrt(n[0] * n[0] + n[1] * n[1]), over_a = rho_a > 0 ? a->radius / rho_a : 0;
    pinch_v3_cross(w, n, t);
    pinch_v3_cross(t, w, u); /* n less its part along w; at right angles to w however short it is */
    double rho_b = pinch_v3_norm(u), over_b = rho_b > 0 ? b->radius / rho_b : 0;
    for (int i = 0; i < 3; i++) at->g[i] = pair->p[i] + over_b * u[i] + copysign(b->half[2], up) * w[i];
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

/* Newton's method, made to go down: the second derivative is lifted where it is not positive, steps that rise are
 * halved. False where it has not settled. */
static bool descend_on_rims(const pinch_core_pair *pair, const double *w, double *n, pinch_contact_normal *best)
{
    enum { STEPS = 20, HALVINGS = 5 };
    static const double LONGEST = 0.3, LEAST_BEND = 0.05, SETTLED = 1e-16;
    rims at, next;
    bool settled = false;
    look_at_rims(pair, w, n, &at);
    for (int k = 0; k < STEPS; k++) {
        double across[3], y[3], m[3], half_trace = 0.5 * (at.M[0] + at.M[2]);
        double skew = 0.5 * (at.M[0] - at.M[2]), spread = sqrt(skew * skew + at.M[1] * at.M[1]);
        double lowest = half_trace - spread, floor = LEAST_BEND * (half_trace + spread);
        double lift = lowest < floor ? floor - lowest : 0;
        if (!(floor > 0)) return true;
        pinch_v3_cross(n, at.t, across);
        double g1 = pinch_v3_dot(at.g, at.t), g2 = pinch_v3_dot(at.g, across);
        double a = at.M[0] + lift, c = at.M[2] + lift, det = a * c - at.M[1] * at.M[1];
        double y1 = (at.M[1] * g2 - c * g1) / det, y2 = (at.M[1] * g1 - a * g2) / det;
        for (int i = 0; i < 3; i++) y[i] = y1 * at.t[i] + y2 * across[i];
        double length = pinch_v3_norm(y), part = length > LONGEST ? LONGEST / length : 1;
        int tries = 0;
        for (; tries < HALVINGS; tries++, part *= 0.5) {
            pinch_v3_copy(m, n);
            pinch_v3_add_scaled(m, part, y);
            pinch_v3_scale(m, 1 / pinch_v3_norm(m));
            look_at_rims(pair, w, m, &next);
            if (next.f <= at.f) break;
        }
        if (tries == HALVINGS) break;
        at = next;
        pinch_v3_copy(n, m);
        settled = part == 1 && length * length < SETTLED;
        if (settled) break;
    }
    if (!(at.f < best->overlap)) return settled;
    best->overlap = at.f;
    pinch_v3_copy(best->normal, n);
    return settled;
}

/* From a face's or side's normal into the region where two rims meet, if that leads down; false where it does, and
 * Newton's method has not settled. */
static bool rims_from(const pinch_core_pair *pair, const pinch_contact_normal *start, pinch_contact_normal *best)
{
    static const double FARTHEST = 0.1; /* rad */
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1};
    double a[3], b[3], d[3], e[3], n[3], up = pinch_v3_dot(w, start->normal), other = up * up;
    double radius = pair->b->radius;
    pinch_pair_support_a(pair, start->normal, a);
    pinch_pair_support_b(pair, start->normal, b);
    if (beyond_part(pair->a, z, start->normal, b, e)) {
        pinch_v3_scale(e, -1);
    } else {
        pinch_v3_sub(a, pair->p, d);
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

static bool two_cylinders(const pinch_core_pair *pair, double size, double bonus, pinch_contact_normal *best)
{
    enum { STARTS = 4 };
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1};
    pinch_contact_normal start[STARTS];
    double n[3];
    for (int k = 0; k < STARTS; k++) start[k].overlap = DBL_MAX;
    const pinch_core *A = pair->a, *B = pair->b;
    double sine = sqrt(w[0] * w[0] + w[1] * w[1]), cosine = fabs(w[2]);
    offer_axis(pair, 0, 0, 1, A->half[2] + B->radius * sine + B->half[2] * cosine, 0, &start[0]);
    offer_axis(pair, w[0], w[1], w[2], B->half[2] + A->radius * sine + A->half[2] * cosine, 0, &start[1]);
    *best = start[1].overlap < start[0].overlap ? start[1] : start[0];
    pinch_v3_set(n, -w[1], w[0], 0); /* z x w; parallel: the line of centres */
    if (!(sine > 1e-8)) pinch_v3_set(n, pair->p[0], pair->p[1], 0);
    double length = pinch_v3_norm(n);
    if (length > 0) offer_axis(pair, n[0] / length, n[1] / length, 0, A->radius + B->radius, bonus, best);
    side_and_rims(pair, A, z, B, w, bonus, best);
    start[2] = *best;
    side_and_rims(pair, B, w, A, z, bonus, best);
    start[3] = *best;
    pinch_contact_normal from = *best;
    double limit = best->overlap + HOPELESS * size;
    from.overlap = DBL_MAX;
    bool sure = rims_from(pair, best, &from); /* it must have come down, if there is a way down */
    sure = sure && (from.overlap == DBL_MAX || from.overlap < best->overlap);
    pinch_v3_copy(n, best->normal);
    if (from.overlap < best->overlap) *best = from;
    for (int k = 0; k < STARTS; k++) { /* next to what is least already there is nothing new */
        if (start[k].overlap < limit && pinch_v3_dot(start[k].normal, best->normal) < NEARBY &&
            pinch_v3_dot(start[k].normal, n) < NEARBY)
            (void)rims_from(pair, &start[k], best);
    }
    return sure;
}

bool pinch_cylinder_normal(const pinch_core_pair *pair, pinch_contact_normal *best)
{
    double size = fmin(pair->a->bound, pair->b->bound), bonus = FACE_BONUS * size;
    best->overlap = DBL_MAX;
    if (pair->a->kind == PINCH_CORE_BOX) {
        box_and_cylinder(pair, bonus, best);
        return true;
    }
    return two_cylinders(pair, size, bonus, best) && best->overlap < SHALLOW * size;
}
