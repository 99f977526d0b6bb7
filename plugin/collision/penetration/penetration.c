#include "penetration.h"

#include "collision/distance/distance.h"
#include "face_test.h"
#include "methods.h"
#include "refine.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* GJK's squared distance is this good before Newton's method takes over; polytopes end exactly anyway, and a
 * superellipsoid's flat spots leave Newton's method little to go by */
static const double CURVED = 1e-9, FLATTENED = 1e-13, EXACT = 1e-15;

static bool have_cylinder(const pinch_shape_pair *pair)
{
    pinch_shape_kind a = pair->a->kind;
    return pair->b->kind == PINCH_SHAPE_CYLINDER &&
           (a == PINCH_SHAPE_SEGMENT || a == PINCH_SHAPE_BOX || a == PINCH_SHAPE_CYLINDER);
}

/* Of a cylinder with a segment, a box or another cylinder. */
static void cylinder_normal(const pinch_shape_pair *pair, double apart, pinch_contact_normal *found)
{
    if (pair->a->kind == PINCH_SHAPE_SEGMENT)
        pinch_segment_cylinder(pair, found);
    else if (pair->a->kind == PINCH_SHAPE_BOX)
        pinch_box_cylinder(pair, apart, found);
    else
        pinch_cylinder_cylinder(pair, apart, found);
}

/*
 * While the shapes (less the balls that fit into curved ones) are apart, the overlap is a convex problem with one
 * answer: the direction of their distance. Otherwise it is not, and all directions compete.
 */
bool pinch_find_contact_normal(const pinch_shape_pair *pair, pinch_tip_stats *stats, pinch_contact_normal *found,
                               pinch_least_face faces[2])
{
    const pinch_shape *a = pair->a, *b = pair->b;
    double margins = a->margin + b->margin, erosion = a->erosion + b->erosion;
    bool polytopes = pinch_is_polytope(a) && pinch_is_polytope(b);
    bool flattened = a->kind == PINCH_SHAPE_SUPERELLIPSOID || b->kind == PINCH_SHAPE_SUPERELLIPSOID;
    double precision = polytopes ? EXACT : flattened ? FLATTENED : CURVED;
    stats->pairs++;
    faces[0].face = faces[1].face = faces[0].edge = faces[1].edge = -1;
    bool hull = (a->kind == PINCH_SHAPE_HULL || b->kind == PINCH_SHAPE_HULL) && !flattened;
    if (!hull && pinch_closed_form(pair, found) == PINCH_CLOSED_FOUND) return found->overlap + margins > 0;
    bool cylinders = !hull && have_cylinder(pair);
    if (cylinders && margins == 0) {
        cylinder_normal(pair, 0, found);
        return found->overlap > 0;
    }
    pinch_contact_normal of_faces = {.overlap = DBL_MAX};
    if (hull) {
        if (pinch_hull_face_test(pair, faces, found)) return found->overlap + margins > 0;
        of_faces = *found;
    } else if (!polytopes && pinch_face_test(pair, found))
        return found->overlap + margins > 0;
    bool pierced =
        a->kind == PINCH_SHAPE_SEGMENT && b->kind == PINCH_SHAPE_BOX; /* or its closed form would have known */
    bool sharp = margins == 0 && a->kind == PINCH_SHAPE_HULL && b->kind == PINCH_SHAPE_CYLINDER; /* as box_cylinder.c */
    if ((!polytopes && !sharp) || (polytopes && margins > 0 && !pierced)) {
        pinch_gjk_result result;
        const double guess[3] = {-pair->p[0], -pair->p[1], -pair->p[2]};
        pinch_gjk_outcome outcome = pinch_gjk(pair, NULL, erosion > 0, guess, margins + erosion, precision, &result);
        if (outcome == PINCH_GJK_BEYOND) return false;
        if (outcome == PINCH_GJK_APART) {
            stats->iteration_limit += result.limited;
            pinch_v3_copy(found->normal, result.normal);
            found->overlap = polytopes ? -result.distance : pinch_pair_overlap(pair, result.normal);
            if (!polytopes) (void)pinch_refine_normal(pair, &result, found);
            return found->overlap + margins > 0;
        }
    }
    stats->deep++;
    if (cylinders) {
        cylinder_normal(pair, -DBL_MAX, found);
        return found->overlap + margins > 0;
    }
    if (flattened) {
        stats->iteration_limit += !pinch_epa(pair, found);
        return found->overlap + margins > 0;
    }
    *found = of_faces;
    if (pinch_is_polytope(a) && pinch_is_round(b) && pinch_polytope_round(pair, hull ? faces : NULL, found))
        return found->overlap + margins > 0;
    if (!polytopes || !pinch_separating_axes(pair, hull ? faces : NULL, found)) {
        stats->descents++;
        pinch_descent(pair, stats, found);
        if (pinch_is_round(a) && pinch_is_round(b)) pinch_flat_capsules(pair, found);
    }
    return found->overlap + margins > 0;
}

static _Thread_local pinch_tip_stats counters;

pinch_tip_stats *pinch_tip_counters(void)
{
    return &counters;
}

pinch_tip_stats pinch_tip_statistics(void)
{
    return counters;
}

void pinch_tip_reset_statistics(void)
{
    memset(&counters, 0, sizeof counters);
}
