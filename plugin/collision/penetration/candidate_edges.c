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
#include "candidate_edges.h"

/* All bits, or none. */
static uint64_t all_if(bool is)
{
    return (uint64_t)0 - is;
}

bool pinch_find_left(const pinch_core_hull *hull, const pinch_least_face *least, double limit, pinch_left *left)
{
    const double level = limit > 0 ? limit : 0, clear = level > least->radius ? level - least->radius : 0;
    const uint64_t *edges = hull->edges_of_face, *corners = hull->corners_of_face;
    uint64_t by_centre[2] = {0, 0}, by_far[2] = {0, 0};
    if (!edges) return false;
    for (unsigned f = 0; f < hull->convex.plane_count; f++) {
        uint64_t shallow = all_if(!(least->centre[f] >= clear));
        by_centre[0] |= edges[f] & shallow;
        by_centre[1] |= corners[f] & shallow;
    }
    for (unsigned f = 0; f < hull->convex.plane_count && least->face >= 0; f++) {
        uint64_t shallow = all_if(!(least->far[f] >= level));
        by_far[0] |= edges[f] & shallow;
        by_far[1] |= corners[f] & shallow;
    }
    *left = least->face >= 0 ? (pinch_left){by_centre[0] & by_far[0], by_centre[1] & by_far[1]}
                             : (pinch_left){by_centre[0], by_centre[1]};
    return true;
}
