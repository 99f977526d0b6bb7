/*
 * The outward normals at a hull's edge or corner are u = sum of a_f f over its faces' normals f, a_f >= 0, and for a
 * unit vector u the a_f sum to 1 or more. At n, u turned around for A, the other core's point x makes the overlap at
 * least
 *
 *     sum of a_f (offset_f - f.x),
 *
 * in the hull's axes: where x is behind all of these faces by the limit or more, and that is positive, the edge or
 * corner cannot meet the other core with less. For a ball about x its radius comes on top, u being a unit vector.
 */
#include "left_edges.h"

#include "support/vec3.h"

enum { CENTRE = 1, FARTHEST = 2 };

bool pinch_find_deep_faces(const pinch_core_pair *pair, int which, const pinch_least_face *least, double limit,
                           pinch_deep_faces *deep)
{
    const pinch_core_hull *hull = (which ? pair->b : pair->a)->hull;
    double of_other[3], centre[3], radius = pinch_core_inner_ball(which ? pair->a : pair->b, of_other);
    double level = limit > 0 ? limit : 0, clear = level > radius ? level - radius : 0;
    if (hull->convex.plane_count > PINCH_LEFT_FACES || hull->edge_count > PINCH_LEFT_EDGES) return false;
    deep->hull = hull;
    if (which) {
        pinch_v3_sub(of_other, pair->p, of_other);
        pinch_pair_turn_back(pair, of_other, centre);
    } else {
        pinch_pair_turn(pair, of_other, centre);
        pinch_v3_add_scaled(centre, 1, pair->p);
    }
    for (unsigned f = 0; f < hull->convex.plane_count; f++) {
        const double *d = hull->convex.planes + 4 * f;
        double offset = hull->faces[f].offset;
        bool is_clear = offset - pinch_v3_dot(d, centre) >= clear;
        bool is_deep = least->face >= 0 && offset - pinch_v3_dot(d, least->point) >= level;
        deep->points[f] = (unsigned char)((is_clear ? CENTRE : 0) | (is_deep ? FARTHEST : 0));
    }
    return true;
}

int pinch_edges_left(const pinch_deep_faces *deep, int edges[PINCH_LEFT_EDGES])
{
    int count = 0;
    for (int e = 0; e < deep->hull->edge_count; e++) {
        const unsigned *face = deep->hull->edges[e].face;
        edges[count] = e;
        count += !(deep->points[face[0]] & deep->points[face[1]]);
    }
    return count;
}

bool pinch_corner_left(const pinch_deep_faces *deep, unsigned corner)
{
    const pinch_core_hull *hull = deep->hull;
    unsigned all = CENTRE | FARTHEST;
    for (unsigned k = hull->faces_at[corner]; k < hull->faces_at[corner + 1]; k++)
        all &= deep->points[hull->corner_faces[k]];
    return all == 0;
}
