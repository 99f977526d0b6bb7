/*
 * What of a tilted body is pressed into a flat face is a tip with its lowest point deepest. Where all edges that leave
 * that point also leave the plane, and do so over the face, clipping polygons would come to nothing but the point.
 */
#include "lone_point.h"

#include "contact_parts.h"
#include "face_first.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>

/* What gives the normal, a box' face (cosine); of a body's size: lower by less, another corner is as deep. */
static const double SQUARE = 1 - 1e-12, TIE = 1e-8;

static const double NOWHERE = DBL_MAX;

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* How far from the lowest point an edge of that length leaves the plane, falling by `fall` until its end. */
static double leaves_at(double length2, double fall, double depth, double tie)
{
    if (!(fall >= depth && fall > tie)) return NOWHERE;
    double part = depth / fall;
    return part * sqrt(larger(0, length2 - fall * fall));
}

static double spread_of_box(const pinch_core *core, const double *d, double depth)
{
    double most = 0, tie = TIE * core->bound;
    for (int i = 0; i < 3; i++) {
        double length = 2 * core->half[i], at = leaves_at(length * length, length * fabs(d[i]), depth, tie);
        if (at == NOWHERE) return at;
        most = larger(most, at);
    }
    return most;
}

static double spread_of_hull(const pinch_core *core, unsigned corner, const double *d, double depth)
{
    const pinch_core_hull *hull = core->hull;
    const double *x = hull->convex.points + 3 * corner;
    double most = 0, edge[3], tie = TIE * core->bound;
    for (unsigned k = hull->neighbours_at[corner]; k < hull->neighbours_at[corner + 1]; k++) {
        pinch_v3_sub(x, hull->convex.points + 3 * hull->neighbours[k], edge);
        double at = leaves_at(pinch_v3_dot(edge, edge), pinch_v3_dot(edge, d), depth, tie);
        if (at == NOWHERE) return at;
        most = larger(most, at);
    }
    return most;
}

/* The line along the side, or the corners of the rim next to its lowest point (pinch_core_rim): half an eighth of a
 * turn to one and a half. */
static double spread_of_round(const pinch_core *core, const double *d, double depth)
{
    static const double S = 0.70710678118654752;
    double length = 2 * core->half[2], tie = TIE * core->bound;
    double along = leaves_at(length * length, length * fabs(d[2]), depth, tie);
    if (along == NOWHERE || fabs(d[2]) <= 0.7) return along;
    double rho = sqrt(d[0] * d[0] + d[1] * d[1]), x = fabs(d[0]), y = fabs(d[1]);
    double to_axis = larger(x, y), to_diagonal = S * (x + y), most = along;
    /* from the corner that the lowest point stands in for to the next ones: along the axes or the diagonals */
    double cosine[2] = {to_axis > to_diagonal ? to_diagonal : to_axis,
                        to_axis > to_diagonal ? S * fabs(x - y) : (x < y ? x : y)};
    for (int k = 0; k < 2; k++) {
        double fall = core->radius * (rho - cosine[k]),
               chord2 = 2 * core->radius * core->radius * (1 - cosine[k] / rho);
        double at = leaves_at(chord2, fall, depth, tie);
        if (at == NOWHERE) return at;
        most = larger(most, at);
    }
    return most;
}

/* How far from its point that lies farthest along d a core is still pressed in. */
static double spread(const pinch_core *core, unsigned corner, const double *d, double depth)
{
    switch (core->kind) {
    case PINCH_CORE_BOX:
        return spread_of_box(core, d, depth);
    case PINCH_CORE_HULL:
        return spread_of_hull(core, corner, d, depth);
    case PINCH_CORE_CYLINDER:
        return spread_of_round(core, d, depth);
    default:
        return NOWHERE;
    }
}

/* Has the core a face with the normal d? Of a hull that is known. */
static bool has_face(const pinch_core *core, const double *d)
{
    double centre[3];
    if (core->kind == PINCH_CORE_BOX) return larger(fabs(d[0]), larger(fabs(d[1]), fabs(d[2]))) >= SQUARE;
    return core->kind == PINCH_CORE_HULL || pinch_core_cap_at(core, d, centre);
}

/* How far x, all in the core's axes, is inside that face's border. */
static double room(const pinch_core *core, const pinch_least_face *least, const double *d, const double *x)
{
    if (pinch_core_is_round(core)) return core->radius - sqrt(x[0] * x[0] + x[1] * x[1]);
    if (core->kind == PINCH_CORE_BOX) return pinch_inside_face(core, d, x);
    return pinch_hull_face_room(core->hull, least->face, x);
}

/* The point of the core opposite that is farthest in, in A's axes and in those of core `which`. */
static void farthest_in(const pinch_core_pair *pair, int which, const pinch_least_face *least, const double *n,
                        double *point, double *local)
{
    double from[3];
    if (least->face >= 0) {
        pinch_v3_copy(local, least->point);
        if (which) {
            pinch_pair_turn(pair, local, point);
            pinch_v3_add_scaled(point, 1, pair->p);
        } else {
            pinch_v3_copy(point, local);
        }
    } else if (which) {
        pinch_pair_support_a(pair, n, point);
        pinch_v3_sub(point, pair->p, from);
        pinch_pair_turn_back(pair, from, local);
    } else {
        pinch_pair_support_b(pair, n, point);
        pinch_v3_copy(local, point);
    }
}

/* Has core `which` a face there that the other one's point is in, and no more? */
static bool is_lone(const pinch_core_pair *pair, int which, const double *n, const pinch_least_face *least,
                    double depth, double *point)
{
    const pinch_core *core = which ? pair->b : pair->a, *other = which ? pair->a : pair->b;
    double local[3], d[3], out[3];
    if (core->kind < PINCH_CORE_BOX || other->kind < PINCH_CORE_BOX || other->kind > PINCH_CORE_CYLINDER) return false;
    bool hull = core->kind == PINCH_CORE_HULL || other->kind == PINCH_CORE_HULL;
    if (hull && !pinch_gives_normal(least, n)) return false; /* which corner it is, is not known */
    pinch_outward(pair, which, n, d);
    if (!has_face(core, d)) return false;
    pinch_outward(pair, !which, n, out);
    double needed = spread(other, least->corner, out, depth);
    if (needed == NOWHERE) return false;
    farthest_in(pair, which, least, n, point, local);
    return room(core, least, d, local) >= needed;
}

int pinch_lone_point(const pinch_core_pair *pair, const pinch_contact_normal *normal, const pinch_least_face faces[2],
                     double depth, double point[3])
{
    for (int which = 0; which < 2; which++)
        if (is_lone(pair, which, normal->normal, &faces[which], depth, point)) return !which;
    return -1;
}
