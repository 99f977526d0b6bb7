/*
 * Most of what is pressed into a flat face lies well inside its border, and nothing has to be clipped. A tilted body is
 * pressed in with a tip whose lowest point is deepest. If all edges that leave that vertex also leave the face's plane,
 * and do so over the face, clipping would leave that single vertex. Otherwise the deep corners of the face or line that
 * faces the plane most are taken, and only those are brought to the other shape's axes.
 */
#include "pair_features.h"

#include "collision/penetration/face_test.h"
#include "support/extremes.h"
#include "support/vec3.h"

#include <math.h>

/* A vertex that is lower by less than this part of the body's size is equally deep. */
static const double TIE = 1e-8;

static const double NOWHERE = DBL_MAX;

/* Returns how far from the lowest point an edge of that length leaves the plane. It falls by `fall` until its end. */
static double leaves_at(double length2, double fall, double depth, double tie)
{
    if (!(fall >= depth && fall > tie)) return NOWHERE;
    double part = depth / fall;
    return part * sqrt(pinch_larger(0, length2 - fall * fall));
}

static double spread_of_box(const pinch_shape *shape, const double *d, double depth)
{
    double most = 0, tie = TIE * shape->bound;
    for (int i = 0; i < 3; i++) {
        double length = 2 * shape->half[i], at = leaves_at(length * length, length * fabs(d[i]), depth, tie);
        if (at == NOWHERE) return at;
        most = pinch_larger(most, at);
    }
    return most;
}

static double spread_of_hull(const pinch_shape *shape, unsigned corner, const double *d, double depth)
{
    const pinch_hull *hull = shape->hull;
    const double *x = hull->convex.points + 3 * corner;
    double most = 0, edge[3], tie = TIE * shape->bound;
    for (unsigned k = hull->neighbours_at[corner]; k < hull->neighbours_at[corner + 1]; k++) {
        pinch_v3_sub(x, hull->convex.points + 3 * hull->neighbours[k], edge);
        double at = leaves_at(pinch_v3_dot(edge, edge), pinch_v3_dot(edge, d), depth, tie);
        if (at == NOWHERE) return at;
        most = pinch_larger(most, at);
    }
    return most;
}

/* Follows the line along the side, or the rim from its lowest point to the next corners of its polygon
 * (pinch_rim_polygon), which are half an eighth of a turn to one and a half away. */
static double spread_of_round(const pinch_shape *shape, const double *d, double depth)
{
    static const double S = 0.70710678118654752;
    double length = 2 * shape->half[2], tie = TIE * shape->bound;
    double along = leaves_at(length * length, length * fabs(d[2]), depth, tie);
    if (along == NOWHERE || fabs(d[2]) <= 0.7) return along;
    double rho = sqrt(d[0] * d[0] + d[1] * d[1]), x = fabs(d[0]), y = fabs(d[1]);
    double to_axis = pinch_larger(x, y), to_diagonal = S * (x + y), most = along;
    /* from the corner that the lowest point replaces to the next ones: along the axes or the diagonals */
    double cosine[2] = {to_axis > to_diagonal ? to_diagonal : to_axis,
                        to_axis > to_diagonal ? S * fabs(x - y) : (x < y ? x : y)};
    for (int k = 0; k < 2; k++) {
        double fall = shape->radius * (rho - cosine[k]),
               chord2 = 2 * shape->radius * shape->radius * (1 - cosine[k] / rho);
        double at = leaves_at(chord2, fall, depth, tie);
        if (at == NOWHERE) return at;
        most = pinch_larger(most, at);
    }
    return most;
}

static double single_vertex_spread(const pinch_shape *shape, unsigned corner, const double d[3], double depth)
{
    switch (shape->kind) {
    case PINCH_SHAPE_BOX:
        return spread_of_box(shape, d, depth);
    case PINCH_SHAPE_HULL:
        return spread_of_hull(shape, corner, d, depth);
    case PINCH_SHAPE_CYLINDER:
        return spread_of_round(shape, d, depth);
    default:
        return NOWHERE;
    }
}

/* A face of a box gives the normal if their cosine is at least SQUARE. A point beyond the border by less than SLACK of
 * the size is there by rounding. */
static const double SQUARE = 1 - 1e-12, SLACK = 1e-9;

/* A face and what lies opposite, with the directions out of each shape in its own axes. */
typedef struct opposites {
    const pinch_shape_pair *pair;
    int which; /* the shape that has the face */
    const pinch_shape *shape, *other;
    const pinch_least_face *least;
    double d[3], out[3];
} opposites;

/* Tells whether the shape has a face with the normal d. Of a hull that is known already. */
static bool has_face(const pinch_shape *shape, const double *d)
{
    double centre[3];
    if (shape->kind == PINCH_SHAPE_BOX) return fabs(d[0]) >= SQUARE || fabs(d[1]) >= SQUARE || fabs(d[2]) >= SQUARE;
    return shape->kind == PINCH_SHAPE_HULL || pinch_exact_cap(shape, d, centre);
}

/* Returns how far x, in the axes of the shape that has the face, lies inside the face's border. */
static double room(const opposites *o, const double *x)
{
    if (pinch_is_round(o->shape)) return o->shape->radius - sqrt(x[0] * x[0] + x[1] * x[1]);
    if (o->shape->kind == PINCH_SHAPE_BOX) return pinch_border_distance(o->shape, o->d, x);
    return pinch_hull_border_distance(o->shape->hull, o->least->face, x);
}

/* Finds the point of the other shape that is farthest in, in A's axes and in those of the shape that has the face. */
static void farthest_in(const opposites *o, const double *n, double *point, double *local)
{
    bool known = o->least->face >= 0;
    if (known) pinch_v3_copy(local, o->least->point);
    if (o->which) {
        if (known)
            pinch_pair_point_to_a(o->pair, local, point);
        else
            pinch_pair_support_a(o->pair, n, point);
        if (!known) pinch_pair_point_to_b(o->pair, point, local);
    } else {
        if (!known) pinch_pair_support_b(o->pair, n, local);
        pinch_v3_copy(point, local);
    }
}

/* A hull's face need not be looked for where the ball inside the hull lies partly beyond the border. */
static bool is_promising(const opposites *o)
{
    double local[3];
    (o->which ? pinch_pair_point_to_b : pinch_pair_point_to_a)(o->pair, o->other->hull->centre, local);
    return room(o, local) >= o->other->hull->inner;
}

/* Finds a ball around the other shape's face or line that is nearest, in its own axes, and which face it is of a hull.
 * Returns false if it is not over the face, if it is a polygon on a cap, or if it has too many corners. */
static bool find_nearest(const opposites *o, pinch_feature *part)
{
    const pinch_shape *other = o->other;
    if (other->bound > o->shape->bound) return false; /* it will not fit */
    bool polygon_on_cap = pinch_is_round(o->shape) && !pinch_is_round(other);
    if (other->kind == PINCH_SHAPE_HULL) {
        if (!is_promising(o)) return false;
        pinch_exact_feature_at_vertex(other, o->out, o->least->corner, part);
        if (part->face && polygon_on_cap) return false;
        if (!part->face) part->index = pinch_nearest_hull_face(other, o->out, part);
        const pinch_hull_face *face = &other->hull->faces[part->index];
        pinch_v3_copy(part->centre, face->centre);
        part->radius = face->radius;
        return face->polygon[0] <= sizeof part->x / sizeof part->x[0];
    }
    if (polygon_on_cap && has_face(other, o->out)) return false;
    pinch_nearest_feature_ball(other, o->out, part->centre, &part->radius);
    return true;
}

/* Takes the deep corners of the nearest face or line, if all of it is over the face. */
static int nearest_feature_points(const opposites *o, const double *n, double depth, pinch_contact_point *contacts)
{
    pinch_feature part;
    double centre[3], along[sizeof part.x / sizeof part.x[0]], most = -DBL_MAX;
    int kept = 0;
    if (!find_nearest(o, &part)) return 0;
    (o->which ? pinch_pair_point_to_b : pinch_pair_point_to_a)(o->pair, part.centre, centre);
    if (!(room(o, centre) >= part.radius - SLACK * o->shape->bound)) return 0;
    pinch_face_corners(o->other, o->out, &part, &part);
    for (int k = 0; k < part.count; k++) {
        along[k] = pinch_v3_dot(o->out, part.x[k]);
        most = along[k] > most ? along[k] : most;
    }
    for (int k = 0; k < part.count; k++) {
        double deep = depth - (most - along[k]), x[3];
        if (!(deep > 0)) continue;
        pinch_v3_copy(x, part.x[k]);
        if (!o->which) pinch_pair_point_to_a(o->pair, part.x[k], x);
        pinch_contact_point_at(o->pair, !o->which, x, n, deep, &contacts[kept++]);
    }
    return kept;
}

/* Tells whether the pair may be looked at. Of a hull, the face and the vertex must be known. */
static bool is_known(const pinch_shape *shape, const pinch_shape *other, const pinch_least_face *least, const double *n)
{
    bool flat = shape->kind >= PINCH_SHAPE_BOX && other->kind >= PINCH_SHAPE_BOX && other->kind <= PINCH_SHAPE_CYLINDER;
    bool hull = shape->kind == PINCH_SHAPE_HULL || other->kind == PINCH_SHAPE_HULL;
    return flat && (!hull || pinch_face_gives_normal(least, n));
}

static int face_points(const pinch_shape_pair *pair, int which, const double *n, const pinch_least_face *least,
                       double depth, pinch_contact_point *contacts)
{
    double point[3], local[3];
    opposites o = {.pair = pair, .which = which, .least = least};
    o.shape = which ? pair->b : pair->a;
    o.other = which ? pair->a : pair->b;
    pinch_outward_direction(pair, which, n, o.d);
    if (!has_face(o.shape, o.d)) return 0;
    pinch_outward_direction(pair, !which, n, o.out);
    double needed = single_vertex_spread(o.other, least->corner, o.out, depth);
    if (needed == NOWHERE) return nearest_feature_points(&o, n, depth, contacts);
    farthest_in(&o, n, point, local);
    if (!(room(&o, local) >= needed)) return nearest_feature_points(&o, n, depth, contacts);
    pinch_contact_point_at(pair, !which, point, n, depth, contacts);
    return 1;
}

int pinch_interior_face_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                               const pinch_least_face faces[2], double depth, pinch_contact_point *contacts)
{
    const pinch_shape *a = pair->a, *b = pair->b;
    const double *n = normal->normal;
    int count = is_known(a, b, &faces[0], n) ? face_points(pair, 0, n, &faces[0], depth, contacts) : 0;
    if (count > 0 || !is_known(b, a, &faces[1], n)) return count;
    return face_points(pair, 1, n, &faces[1], depth, contacts);
}
