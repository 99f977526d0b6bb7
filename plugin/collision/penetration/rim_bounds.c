#include "rim_pair.h"

#include "support/vec3.h"

#include <stdlib.h>

static const double PARALLEL = 1e-8; /* sine of the angle between the axes */

bool pinch_rim_frame_of(const pinch_shape_pair *pair, pinch_rim_frame *frame)
{
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]};
    double m[3], sine = sqrt(w[0] * w[0] + w[1] * w[1]);
    if (!(sine > PARALLEL)) return false;
    double x[2] = {w[0] / sine, w[1] / sine};
    frame->pair = pair;
    frame->sine = sine;
    frame->cosine = w[2];
    pinch_v3_set(frame->axis[0], x[0], x[1], 0);
    pinch_v3_set(frame->axis[1], -x[1], x[0], 0);
    pinch_v3_set(frame->axis[2], 0, 0, 1);
    pinch_pair_between_middles(pair, w, m);
    pinch_v3_set(frame->m, x[0] * m[0] + x[1] * m[1], x[0] * m[1] - x[1] * m[0], m[2]);
    return true;
}

void pinch_rim_caps(const pinch_rim_frame *k, const int side[2], pinch_rim_cap caps[2])
{
    const pinch_shape *a = k->pair->a, *b = k->pair->b;
    double ra = a->radius, rb = b->radius, s = k->sine, cosine = k->cosine;
    double cx = k->m[0] + side[1] * b->half[2] * s, cy = k->m[1];
    double cz = k->m[2] + side[0] * a->half[2] + side[1] * b->half[2] * cosine;
    double x = cx - side[0] * rb * cosine, u = cx * cosine - cz * s + side[1] * ra * cosine;
    caps[0].inside = ra - sqrt(x * x + cy * cy);
    caps[0].overlap = side[0] * cz + rb * s;
    caps[1].inside = rb - sqrt(u * u + cy * cy);
    caps[1].overlap = side[1] * (cx * s + cz * cosine) + ra * s;
}

/*
 * Bounds on the overlap where two rims meet. At the angle t from its axis a cylinder's support value is radius sin t +
 * half cos t. Between two angles sin t is at least the chord K - C cos t, which is that of a ball of radius K at -C. So
 * the cylinder extends at least as far as a ball on its axis. Two balls overlap along any normal by at least the sum of
 * their radii less the distance of their centres.
 *
 * The pieces of the quarter turn are all of it, its thirds, and their halves. K and C are in radii, followed by the
 * cosines and sines of the piece's ends.
 */
enum { WHOLE = 0, THIRDS = 1, HALVES = 4, PIECES = 10 };
static const struct {
    double K, C, cosine[2], sine[2];
    int from, to; /* in sixths of the quarter turn */
} PIECE[PIECES] = {
    {1, 1, {1, 0}, {0, 1}, 0, 6},
    {3.7320508075688772, 3.7320508075688772, {1, 0.86602540378443865}, {0, 0.5}, 0, 2},
    {1.3660254037844386, 1, {0.86602540378443865, 0.5}, {0.5, 0.86602540378443865}, 2, 4},
    {1, 0.26794919243112271, {0.5, 0}, {0.86602540378443865, 1}, 4, 6},
    {7.5957541127251502, 7.5957541127251502, {1, 0.96592582628906829}, {0, 0.25881904510252076}, 0, 1},
    {2.5907702751760278,
     2.4142135623730950,
     {0.96592582628906829, 0.86602540378443865},
     {0.25881904510252076, 0.5},
     1,
     2},
    {1.6286262797369311,
     1.3032253728412058,
     {0.86602540378443865, 0.70710678118654752},
     {0.5, 0.70710678118654752},
     2,
     3},
    {1.2496888978977739,
     0.76732698797896034,
     {0.70710678118654752, 0.5},
     {0.70710678118654752, 0.86602540378443865},
     3,
     4},
    {1.0731321849709862,
     0.41421356237309505,
     {0.5, 0.25881904510252076},
     {0.86602540378443865, 0.96592582628906829},
     4,
     5},
    {1, 0.13165249758739585, {0.25881904510252076, 0}, {0.96592582628906829, 1}, 5, 6},
};

/* Tells whether there are normals at angles of both pieces from axes that enclose an angle of this cosine. */
static bool exists(int i, int j, double cosine)
{
    static const double COSINE[13] = {1,
                                      0.96592582628906829,
                                      0.86602540378443865,
                                      0.70710678118654752,
                                      0.5,
                                      0.25881904510252076,
                                      0,
                                      -0.25881904510252076,
                                      -0.5,
                                      -0.70710678118654752,
                                      -0.86602540378443865,
                                      -0.96592582628906829,
                                      -1};
    int over = PIECE[i].from - PIECE[j].to, under = PIECE[j].from - PIECE[i].to, apart = over > under ? over : under;
    return (apart <= 0 || cosine <= COSINE[apart]) && cosine >= COSINE[PIECE[i].to + PIECE[j].to];
}

/* The bound is tighter where the balls' own normal is at an angle outside the piece: the angle at the piece's end then
 * has the least overlap. `axis` is the cylinder's on the cell's side, and c leads from ball to ball. */
static void tighten(const double *axis, int piece, double radii, const double *c, const double *n, pinch_rim_cell *to)
{
    double at = axis[0] * n[0] + axis[2] * n[2], along = axis[0] * c[0] + axis[2] * c[2], across[3];
    int end = at > PIECE[piece].cosine[0] ? 0 : at < PIECE[piece].cosine[1] ? 1 : -1;
    if (end < 0) return;
    pinch_v3_set(across, c[0] - along * axis[0], c[1], c[2] - along * axis[2]);
    double length = pinch_v3_norm(across), cosine = PIECE[piece].cosine[end], sine = PIECE[piece].sine[end];
    double bound = radii + along * cosine - length * sine;
    if (!(bound > to->bound) || !(length > 0)) return;
    to->bound = bound;
    for (int i = 0; i < 3; i++) to->n[i] = cosine * axis[i] - sine / length * across[i];
}

static bool may_beat(const pinch_rim_frame *k, double limit, pinch_rim_cell *cell)
{
    const pinch_shape *a = k->pair->a, *b = k->pair->b;
    int i = cell->piece[0], j = cell->piece[1];
    double height_a = a->half[2] - PIECE[i].C * a->radius, height_b = b->half[2] - PIECE[j].C * b->radius;
    double radii = PIECE[i].K * a->radius + PIECE[j].K * b->radius, room = radii - limit, n[3];
    const double z[3] = {0, 0, cell->side[0]}, w[3] = {cell->side[1] * k->sine, 0, cell->side[1] * k->cosine};
    const double c[3] = {k->m[0] + height_b * w[0], k->m[1], k->m[2] + height_a * z[2] + height_b * w[2]};
    double length2 = pinch_v3_dot(c, c);
    if ((room > 0 && length2 <= room * room) || !(length2 > 0)) return false;
    double length = sqrt(length2), scale = -1 / length;
    cell->bound = radii - length;
    for (int d = 0; d < 3; d++) cell->n[d] = n[d] = scale * c[d];
    tighten(z, i, radii, c, n, cell);
    if (!(cell->bound < limit)) return false;
    tighten(w, j, radii, c, n, cell);
    return cell->bound < limit;
}

/* Splits a cell into halves both ways. */
static int split(const pinch_rim_frame *k, double limit, const pinch_rim_cell *cell, pinch_rim_cell *parts)
{
    double cosine = cell->side[0] * cell->side[1] * k->cosine;
    int count = 0;
    for (int which = 0; which < 4; which++) {
        pinch_rim_cell *part = &parts[count];
        int i = HALVES + 2 * (cell->piece[0] - THIRDS) + (which & 1);
        int j = HALVES + 2 * (cell->piece[1] - THIRDS) + (which >> 1);
        if (!exists(i, j, cosine)) continue;
        part->side[0] = cell->side[0];
        part->side[1] = cell->side[1];
        part->piece[0] = i;
        part->piece[1] = j;
        count += may_beat(k, limit, part);
    }
    return count;
}

/* Finds the first of the pieces at whose end it is not certain that the cap is less (pinch_rim_caps). */
static int first_piece(const pinch_rim_cap *cap, double limit)
{
    int i = THIRDS;
    while (i < HALVES && pinch_rim_cap_is_less(cap, PIECE[i].cosine[1], PIECE[i].sine[1], limit)) i++;
    return i;
}

/*
 * Finds how far all of the other rim lies inside the cylinder's end. At right angles to the axis nothing has less than
 * `limit`. At the angle t from there the overlap is at least limit cos t + inside sin t, because the other body's point
 * is at least that far from the end.
 */
static void ends_inside(const pinch_rim_frame *k, const int side[2], double inside[2])
{
    const pinch_shape *a = k->pair->a, *b = k->pair->b;
    double along_a = side[0] * k->m[2], along_b = side[1] * (k->m[0] * k->sine + k->m[2] * k->cosine);
    double cosine = side[0] * side[1] * k->cosine;
    inside[0] = a->half[2] + along_a + b->half[2] * cosine - b->radius * k->sine;
    inside[1] = b->half[2] + along_b + a->half[2] * cosine - a->radius * k->sine;
}

/* Returns the piece behind the last one. */
static int last_piece(double inside, double limit)
{
    int i = HALVES;
    while (i > THIRDS && inside > 0 && limit * PIECE[i - 1].sine[0] + inside * PIECE[i - 1].cosine[0] >= limit) i--;
    return i;
}

/* Finds the cells of the rims on these sides. */
static int cells_of(const pinch_rim_frame *k, double limit, const int side[2], pinch_rim_cell *cells, int room)
{
    pinch_rim_cell whole = {.side = {side[0], side[1]}}, part = whole, parts[4];
    pinch_rim_cap caps[2];
    int count = 0;
    double inside[2];
    ends_inside(k, side, inside);
    int last_a = last_piece(inside[0], limit), last_b = last_piece(inside[1], limit);
    if (last_a == THIRDS || last_b == THIRDS || !may_beat(k, limit, &whole)) return 0;
    pinch_rim_caps(k, side, caps);
    int first_a = first_piece(&caps[0], limit), first_b = first_piece(&caps[1], limit);
    for (part.piece[0] = first_a; part.piece[0] < last_a; part.piece[0]++)
        for (part.piece[1] = first_b; part.piece[1] < last_b; part.piece[1]++) {
            if (!exists(part.piece[0], part.piece[1], side[0] * side[1] * k->cosine) || !may_beat(k, limit, &part))
                continue;
            int found = split(k, limit, &part, parts);
            for (int p = 0; p < found && count < room; p++) cells[count++] = parts[p];
        }
    return count;
}

int pinch_rim_cells(const pinch_rim_frame *k, double limit, pinch_rim_cell cells[PINCH_RIM_CELLS])
{
    int count = 0;
    for (int which = 0; which < 4; which++) {
        const int side[2] = {which & 1 ? 1 : -1, which & 2 ? 1 : -1};
        if (!pinch_has_rim(k->pair->a, -side[0]) || !pinch_has_rim(k->pair->b, side[1])) continue;
        count += cells_of(k, limit, side, cells + count, PINCH_RIM_CELLS - count);
    }
    return count;
}

bool pinch_rim_cell_at_cap(const pinch_rim_cell *cell, int which)
{
    return PIECE[cell->piece[which]].from == 0;
}

bool pinch_rim_may_beat(const pinch_rim_line *across, const pinch_shape *body, int rim, double limit)
{
    double X = rim * across->X, Y2 = across->Y * across->Y;
    for (int i = THIRDS; i < HALVES; i++) {
        double room = PIECE[i].K * body->radius - limit, height = body->half[2] - PIECE[i].C * body->radius;
        double x = X + height * across->sine;
        if (room <= 0 || x * x + Y2 > room * room) return true;
    }
    return false;
}

/*
 * Rim certificates. At the minimum n the point of the difference farthest along n is p n. At a normal m at the angle T
 * from n, a rim of radius r with the tangent t extends by at least r (m.t)^2/2 beyond its own point, and a side by at
 * least e (m.axis)^2 beyond a point e inside its ends. With m = n cos T + e sin T,
 *
 *     p(m) - p >= 2 sin(T/2)^2 (cos(T/2)^2 e.Be - p),  B = sum of r t t' + 2 e axis axis'.
 *
 * So nothing is less where cos(T/2)^2 >= p/b, with b the lower eigenvalue of B. At larger angles from n a ball in both
 * bodies bounds the overlap (pinch_is_deeper_beyond).
 */

/* At a minimum the overlap changes by no more than this part of the size per radian. */
static const double LEVEL = 1e-8;

static bool is_least(const pinch_shape_pair *pair, const double B[3], const pinch_contact_normal *at)
{
    double half = 0.5 * (B[0] + B[2]), skew = 0.5 * (B[0] - B[2]), lowest = half - sqrt(skew * skew + B[1] * B[1]);
    double p = at->overlap;
    if (!(lowest > 0)) return false;
    if (p <= 0) return true;
    double part = p / lowest;
    return part < 1 && pinch_is_deeper_beyond(pair, at->normal, p, 2 * part - 1, 2 * sqrt(part * (1 - part)));
}

/* Finds a rim's unit tangent. Returns false at its cap. */
static bool tangent(const double *axis, const double *n, double *t)
{
    pinch_v3_cross(axis, n, t);
    double length = pinch_v3_norm(t);
    if (!(length > 0)) return false;
    pinch_v3_scale(t, 1 / length);
    return true;
}

bool pinch_rim_pair_is_level(const pinch_shape_pair *pair, const pinch_contact_normal *at)
{
    double a[3], gradient[3], size = pair->a->bound < pair->b->bound ? pair->a->bound : pair->b->bound;
    pinch_pair_support_a(pair, at->normal, a);
    pinch_pair_support_b(pair, at->normal, gradient);
    pinch_v3_add_scaled(gradient, -1, a);
    pinch_v3_make_perpendicular(gradient, at->normal);
    return pinch_v3_norm(gradient) < LEVEL * size;
}

bool pinch_rim_pair_certificate(const pinch_shape_pair *pair, const pinch_contact_normal *at)
{
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1};
    double ra = pair->a->radius, rb = pair->b->radius, s[3], t[3], across[3];
    if (!pinch_rim_pair_is_level(pair, at) || !tangent(z, at->normal, s) || !tangent(w, at->normal, t)) return false;
    pinch_v3_cross(at->normal, s, across);
    double c = pinch_v3_dot(t, s), d = pinch_v3_dot(t, across);
    const double B[3] = {ra + rb * c * c, rb * c * d, rb * d * d};
    return is_least(pair, B, at);
}

bool pinch_side_and_rim_certificate(const pinch_shape_pair *pair, int which, const pinch_contact_normal *at)
{
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1};
    const double *axis = which ? w : z, *other = which ? z : w;
    const pinch_shape *straight = which ? pair->b : pair->a, *rim = which ? pair->a : pair->b;
    double x[3], s[3], t[3];
    if (which) {
        pinch_pair_support_a(pair, at->normal, x);
        pinch_v3_add_scaled(x, -1, pair->p);
    } else {
        pinch_pair_support_b(pair, at->normal, x);
    }
    double height = pinch_v3_dot(axis, x), inside = straight->half[2] - fabs(height), beside[3];
    pinch_v3_copy(beside, x); /* where the overlap is level, the rim's point lies on the side's line: nothing is left of
                                 the way between them */
    pinch_v3_add_scaled(beside, -height, axis);
    pinch_v3_make_perpendicular(beside, at->normal);
    if (!(pinch_v3_norm(beside) < LEVEL * (pair->a->bound < pair->b->bound ? pair->a->bound : pair->b->bound)))
        return false;
    if (!(inside > 0) || !tangent(other, at->normal, t)) return false;
    pinch_v3_cross(axis, at->normal, s);
    double c = pinch_v3_dot(t, s), d = pinch_v3_dot(t, axis), r = rim->radius;
    const double B[3] = {straight->radius + r * c * c, r * c * d, 2 * inside + r * d * d};
    return is_least(pair, B, at);
}
