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

enum { CENTRE = 1, FARTHEST = 2 };

bool pinch_find_deep_faces(const pinch_core_hull *hull, const pinch_least_face *least, double limit,
                           pinch_deep_faces *deep)
{
    int count = (int)hull->convex.plane_count;
    double level = limit > 0 ? limit : 0, clear = level > least->radius ? level - least->radius : 0;
    if (count > PINCH_LEFT_FACES || hull->edge_count > PINCH_LEFT_EDGES) return false;
    deep->hull = hull;
    for (int f = 0; f < count; f++) deep->points[f] = least->centre[f] >= clear ? CENTRE : 0;
    for (int f = 0; f < count && least->face >= 0; f++) deep->points[f] |= least->far[f] >= level ? FARTHEST : 0;
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
