/*
 * The outward normals at a hull's edge or vertex are u = sum of a_f f over the normals f of its faces, with a_f >= 0.
 * For a unit vector u the a_f sum to 1 or more. At the normal n that is u, or -u for A, the other shape's point x makes
 * the overlap at least
 *
 *     sum of a_f (offset_f - f.x)
 *
 * in the hull's axes. If x lies behind all of these faces by the limit or more, and that is positive, the edge or
 * vertex cannot meet the other shape with less. For a ball about x the radius is added, because u is a unit vector.
 */
#include "candidate_edges.h"

#include "support/vec3.h"

#include <string.h>

/* Sets all bits, or none. */
static uint64_t all_if(bool is)
{
    return (uint64_t)0 - is;
}

bool pinch_find_candidates(const pinch_hull *hull, const pinch_least_face *least, double limit,
                           pinch_candidates *candidates)
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
    *candidates = least->face >= 0 ? (pinch_candidates){by_centre[0] & by_far[0], by_centre[1] & by_far[1]}
                                   : (pinch_candidates){by_centre[0], by_centre[1]};
    return true;
}

/*
 * Large hulls have too many edges for bits of their own, but the same holds of them. The normals that are tried at an
 * edge may leave its arc by the tolerance with which they are compared, up to 5e-5, and by what an edge that is not
 * loose may be off its faces. So much of the size is added to the limit. Then what is left out is nothing that the
 * other tests would have let pass.
 */
static const double OFF_ARC = 1e-4;

/* Sets the bits of up to 64 faces behind which x is not as deep as `level`, and of loose ones. */
static uint64_t shallower(const pinch_hull *hull, const double *x, int word, double level)
{
    double depth[64];
    int first = 64 * word, faces = (int)hull->convex.plane_count, count = faces - first < 64 ? faces - first : 64;
    uint64_t bits = hull->loose_faces[word];
    pinch_hull_depths(hull, x, first, count, depth);
    for (int f = 0; f < count; f++) bits |= (uint64_t) !(depth[f] >= level) << f;
    return bits;
}

void pinch_find_shallow_faces(const pinch_shape_pair *pair, int which, const pinch_contact_normal *best,
                              pinch_shallow_faces *shallow)
{
    const pinch_shape *shape = which ? pair->b : pair->a, *other = which ? pair->a : pair->b;
    double far[3], centre[3], x[3], deepest[3];
    shallow->hull = shape->kind == PINCH_SHAPE_HULL ? shape->hull : NULL;
    if (!shallow->hull) return;
    double size = pair->a->bound + pair->b->bound + pinch_v3_norm(pair->p);
    double level = (best->overlap > 0 ? best->overlap : 0) + OFF_ARC * size, radius = pinch_inner_ball(other, x);
    double clear = level > radius ? level - radius : 0;
    /* pinch_pair_support_a and _b are written out: with one more caller the compiler does not put them into GJK's loop
     * any more, and ellipsoids cost 13 % more. */
    if (which) {
        pinch_pair_point_to_b(pair, x, centre);
        const double back[3] = {-best->normal[0], -best->normal[1], -best->normal[2]};
        pinch_support_point(pair->a, back, x);
        pinch_pair_point_to_b(pair, x, far);
    } else {
        pinch_pair_point_to_a(pair, x, centre);
        pinch_pair_rotate_back(pair, best->normal, x);
        pinch_support_point(pair->b, x, deepest);
        pinch_pair_point_to_a(pair, deepest, far);
    }
    for (unsigned word = 0; word < PINCH_SHALLOW_WORDS && 64 * word < shape->hull->convex.plane_count; word++) {
        shallow->far[word] = shallower(shape->hull, far, (int)word, level);
        shallow->ball[word] = shallower(shape->hull, centre, (int)word, clear);
    }
}

static int box_arcs(const pinch_shape *shape, pinch_edge_arc *arcs)
{
    int count = 0;
    for (int i = 0; i < 3; i++)
        for (int corner = 0; corner < 4; corner++) {
            pinch_edge_arc *arc = &arcs[count++];
            int j = (i + 1) % 3, k = (i + 2) % 3;
            double sj = corner & 1 ? 1 : -1, sk = corner & 2 ? 1 : -1;
            memset(arc, 0, sizeof *arc);
            arc->v[i] = -shape->half[i];
            arc->v[j] = sj * shape->half[j];
            arc->v[k] = sk * shape->half[k];
            arc->u[i] = 1;
            arc->n1[j] = sj;
            arc->n2[k] = sk;
        }
    return count;
}

/* The outward normals of a triangle's edge form a half circle from one side to the other, through the direction that
 * leads outward. It is split into two arcs. */
static int triangle_arcs(const pinch_shape *shape, pinch_edge_arc *arcs)
{
    double axes[3][3];
    int count = 0;
    if (!pinch_shape_axes(shape, axes)) return 0;
    for (int k = 0; k < 3; k++) {
        const double *from = shape->corner + 3 * k, *to = shape->corner + 3 * ((k + 1) % 3);
        double u[3], out[3];
        pinch_v3_sub(to, from, u);
        pinch_v3_scale(u, 1 / pinch_v3_norm(u));
        pinch_v3_cross(u, axes[0], out);
        for (int side = 0; side < 2; side++) {
            pinch_edge_arc *arc = &arcs[count++];
            pinch_v3_copy(arc->v, from);
            pinch_v3_copy(arc->u, u);
            pinch_v3_copy(arc->n1, out);
            for (int i = 0; i < 3; i++) arc->n2[i] = side ? -axes[0][i] : axes[0][i];
        }
    }
    return count;
}

/* The outward normals of a segment form the whole circle, in four quarters. */
static int segment_arcs(const pinch_shape *shape, pinch_edge_arc *arcs)
{
    for (int k = 0; k < 4; k++) {
        memset(&arcs[k], 0, sizeof arcs[k]);
        arcs[k].v[2] = -shape->half[2];
        arcs[k].u[2] = 1;
        arcs[k].n1[k % 2] = k < 2 ? 1 : -1;
        arcs[k].n2[(k + 1) % 2] = k == 0 || k == 3 ? 1 : -1;
    }
    return 4;
}

const pinch_edge_arc *pinch_edge_arcs(const pinch_shape *shape, pinch_edge_arc own[PINCH_BOX_EDGES], int *count)
{
    switch (shape->kind) {
    case PINCH_SHAPE_SEGMENT:
        *count = segment_arcs(shape, own);
        return own;
    case PINCH_SHAPE_TRIANGLE:
        *count = triangle_arcs(shape, own);
        return own;
    case PINCH_SHAPE_BOX:
        *count = box_arcs(shape, own);
        return own;
    case PINCH_SHAPE_HULL:
        *count = shape->hull->edge_count;
        return shape->hull->arcs;
    default:
        *count = 0;
        return own;
    }
}

uint64_t pinch_edges_beyond(const pinch_hull *hull, const double n[3], double level, uint64_t edges)
{
    const double *x = hull->convex.points;
    uint64_t kept = 0;
    while (edges) {
        int e = pinch_take_bit(&edges);
        const unsigned *corner = hull->edges[e].corner;
        double one = pinch_v3_dot(n, x + 3 * corner[0]), two = pinch_v3_dot(n, x + 3 * corner[1]);
        kept |= (uint64_t)((one >= level) | (two >= level)) << e;
    }
    return kept;
}
