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

static bool have_cylinder(const pinch_core_pair *pair)
{
    pinch_core_kind a = pair->a->kind;
    return pair->b->kind == PINCH_CORE_CYLINDER &&
           (a == PINCH_CORE_SEGMENT || a == PINCH_CORE_BOX || a == PINCH_CORE_CYLINDER);
}

/* Of a cylinder with a segment, a box or another cylinder. */
static void cylinder_normal(const pinch_core_pair *pair, double apart, pinch_contact_normal *found)
{
    if (pair->a->kind == PINCH_CORE_SEGMENT)
        pinch_segment_cylinder(pair, found);
    else if (pair->a->kind == PINCH_CORE_BOX)
        pinch_box_cylinder(pair, apart, found);
    else
        pinch_two_cylinders(pair, apart, found);
}

/*
 * While the cores (less the balls that fit into curved ones) are apart, the overlap is a convex problem with one
 * answer: the direction of their distance. Otherwise it is not, and all directions compete.
 */
bool pinch_find_normal(const pinch_core_pair *pair, pinch_tip_stats *stats, pinch_contact_normal *found,
                       pinch_least_face faces[2])
{
    const pinch_core *a = pair->a, *b = pair->b;
    double skins = a->skin + b->skin, erosion = a->erosion + b->erosion;
    bool polytopes = pinch_core_is_polytope(a) && pinch_core_is_polytope(b);
    bool flattened = a->kind == PINCH_CORE_SUPERELLIPSOID || b->kind == PINCH_CORE_SUPERELLIPSOID;
    double precision = polytopes ? EXACT : flattened ? FLATTENED : CURVED;
    stats->pairs++;
    faces[0].face = faces[1].face = faces[0].edge = faces[1].edge = -1;
    bool hull = (a->kind == PINCH_CORE_HULL || b->kind == PINCH_CORE_HULL) && !flattened;
    if (!hull && pinch_closed_normal(pair, found) == PINCH_CLOSED_FOUND) return found->overlap + skins > 0;
    bool cylinders = !hull && have_cylinder(pair);
    if (cylinders && skins == 0) {
        cylinder_normal(pair, 0, found);
        return found->overlap > 0;
    }
    pinch_contact_normal of_faces = {.overlap = DBL_MAX};
    if (hull) {
        if (pinch_hull_first(pair, faces, found)) return found->overlap + skins > 0;
        of_faces = *found;
    } else if (!polytopes && pinch_face_first(pair, found))
        return found->overlap + skins > 0;
    bool pierced = a->kind == PINCH_CORE_SEGMENT && b->kind == PINCH_CORE_BOX; /* or its closed form would have known */
    bool sharp = skins == 0 && a->kind == PINCH_CORE_HULL && b->kind == PINCH_CORE_CYLINDER; /* as box_cylinder.c */
    if ((!polytopes && !sharp) || (polytopes && skins > 0 && !pierced)) {
        pinch_gjk_result result;
        const double guess[3] = {-pair->p[0], -pair->p[1], -pair->p[2]};
        pinch_gjk_outcome outcome = pinch_gjk(pair, NULL, erosion > 0, guess, skins + erosion, precision, &result);
        if (outcome == PINCH_GJK_BEYOND) return false;
        if (outcome == PINCH_GJK_APART) {
            stats->iteration_limit += result.limited;
            pinch_v3_copy(found->normal, result.normal);
            found->overlap = polytopes ? -result.distance : pinch_pair_overlap(pair, result.normal);
            if (!polytopes) (void)pinch_refine_normal(pair, &result, found);
            return found->overlap + skins > 0;
        }
    }
    stats->deep++;
    if (cylinders) {
        cylinder_normal(pair, -DBL_MAX, found);
        return found->overlap + skins > 0;
    }
    if (flattened) {
        stats->iteration_limit += !pinch_expand(pair, found);
        return found->overlap + skins > 0;
    }
    *found = of_faces;
    if (pinch_core_is_polytope(a) && pinch_core_is_round(b) && pinch_round_polytope(pair, hull ? faces : NULL, found))
        return found->overlap + skins > 0;
    if (!polytopes || !pinch_separating_axes(pair, hull ? faces : NULL, found)) {
        stats->descents++;
        pinch_descend(pair, stats, found);
        if (pinch_core_is_round(a) && pinch_core_is_round(b)) pinch_offer_flat_capsules(pair, found);
    }
    return found->overlap + skins > 0;
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
