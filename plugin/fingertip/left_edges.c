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

bool pinch_find_deep_faces(const pinch_core_hull *hull, const pinch_least_face *least, double limit,
                           pinch_deep_faces *deep)
{
    int count = (int)hull->convex.plane_count;
    double level = limit > 0 ? limit : 0, clear = level > least->radius ? level - least->radius : 0;
    if (!hull->edge_faces || hull->edge_count > PINCH_LEFT_EDGES) return false;
    uint64_t centre = 0, far = 0;
    for (int f = 0; f < count; f++) centre |= (uint64_t)(least->centre[f] >= clear) << f;
    for (int f = 0; f < count && least->face >= 0; f++) far |= (uint64_t)(least->far[f] >= level) << f;
    *deep = (pinch_deep_faces){hull, {~centre, ~far}};
    return true;
}

int pinch_edges_left(const pinch_deep_faces *deep, int edges[PINCH_LEFT_EDGES])
{
    const uint64_t *faces = deep->hull->edge_faces;
    int count = 0;
    for (int e = 0; e < deep->hull->edge_count; e++) {
        edges[count] = e;
        count += (faces[e] & deep->not_behind[0]) && (faces[e] & deep->not_behind[1]);
    }
    return count;
}

bool pinch_corner_left(const pinch_deep_faces *deep, unsigned corner)
{
    uint64_t faces = deep->hull->faces_of_corner[corner];
    return (faces & deep->not_behind[0]) && (faces & deep->not_behind[1]);
}
