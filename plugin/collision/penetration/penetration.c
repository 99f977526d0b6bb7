/*
 * The contact normal of two convex shapes: the unit vector along which they overlap least.
 *
 * While the shapes are apart (less the balls that fit into curved ones), the overlap is a convex problem with one
 * answer, the direction of their distance. Once they overlap it is not convex any more, and all directions compete.
 * Which method settles that depends on what the two kinds have: finitely many axes (polytopes), axes with one unknown
 * (a rim against an edge), or curved surfaces. METHODS says it for every pair of kinds; README.md says why.
 */
#include "penetration.h"

#include "collision/distance/distance.h"
#include "methods.h"
#include "refine.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Who answers once the shapes overlap. H stands for a pair with a hull, whose faces are tested first and kept. */
typedef enum method {
    NONE = 0, /* pairs come with the kinds in ascending order; only point queries name the point second */
    CLOSED,   /* closed_form.c answers however the shapes lie */
    PIERCED,  /* closed_form.c while the segment is outside the box, separating_axes.c once it pierces it */
    SEG_CYL,  /* the same with a cylinder, and cylinder_cylinder.c */
    BOX_CYL,  /* box_cylinder.c */
    CYL_CYL,  /* cylinder_cylinder.c */
    AXES,     /* separating_axes.c */
    ROUND,    /* polytope_round.c */
    EPA,      /* epa.c */
    FLAT,     /* epa.c, and flat_capsules.c offers what an unproven end of it may miss */
    H_AXES,
    H_CYL, /* polytope_round.c */
    H_FLAT,
    H_EPA,
    SUPER /* epa.c, and GJK is finer: a superellipsoid may be nearly flat */
} method;

/* clang-format off */
static const unsigned char METHODS[PINCH_SHAPE_KINDS][PINCH_SHAPE_KINDS] = {
    /*                point    segment  triangle box      hull    cylinder  flat caps. ellipsoid superellipsoid */
    /* point */      {CLOSED,  CLOSED,  AXES,    CLOSED,  H_AXES, CLOSED,   ROUND,     EPA,      SUPER},
    /* segment */    {CLOSED,  CLOSED,  AXES,    PIERCED, H_AXES, SEG_CYL,  ROUND,     EPA,      SUPER},
    /* triangle */   {AXES,    NONE,    AXES,    AXES,    H_AXES, ROUND,    ROUND,     EPA,      SUPER},
    /* box */        {AXES,    NONE,    NONE,    AXES,    H_AXES, BOX_CYL,  ROUND,     EPA,      SUPER},
    /* hull */       {H_AXES,  NONE,    NONE,    NONE,    H_AXES, H_CYL,    H_FLAT,    H_EPA,    SUPER},
    /* cylinder */   {EPA,     NONE,    NONE,    NONE,    NONE,   CYL_CYL,  FLAT,      EPA,      SUPER},
    /* flat caps. */ {EPA,     NONE,    NONE,    NONE,    NONE,   NONE,     FLAT,      EPA,      SUPER},
    /* ellipsoid */  {EPA,     NONE,    NONE,    NONE,    NONE,   NONE,     NONE,      EPA,      SUPER},
    /* superell. */  {SUPER,    NONE,    NONE,    NONE,    NONE,   NONE,     NONE,      NONE,     SUPER},
};
/* clang-format on */

/* GJK stops when its squared distance is relatively this good. Polytopes end exactly anyway. Curved shapes go on with
 * Newton's method, which has little to go by where a superellipsoid is flat. */
static const double OF_POLYTOPES = 1e-15, OF_CURVED = 1e-9, OF_FLATTENED = 1e-13;

static _Thread_local pinch_tip_stats counters;

static bool has_hull_faces(method m)
{
    return m >= H_AXES && m <= H_EPA;
}

static bool are_polytopes(method m)
{
    return m == AXES || m == H_AXES;
}

static bool is_exact_cylinder(method m)
{
    return m == SEG_CYL || m == BOX_CYL || m == CYL_CYL;
}

/* These methods stop at the first normal along which the shapes overlap by no more than `apart` (m). */
static void exact_cylinder(method m, const pinch_shape_pair *pair, double apart, pinch_contact_normal *found)
{
    if (m == SEG_CYL)
        pinch_segment_cylinder(pair, found);
    else if (m == BOX_CYL)
        pinch_box_cylinder(pair, apart, found);
    else
        pinch_cylinder_cylinder(pair, apart, found);
}

/* Is the normal of a face already certain to be the answer, or the shapes certain to be apart? */
static bool faces_settle(method m, const pinch_shape_pair *pair, pinch_least_face faces[2], pinch_contact_normal *found)
{
    if (has_hull_faces(m)) return pinch_hull_face_test(pair, faces, found);
    return !are_polytopes(m) && m != PIERCED && pinch_face_test(pair, found);
}

/* Sharp polytopes, and a sharp hull and cylinder, are as cheap to settle without their distance. A pierced box would
 * have had a closed form if there were a distance. */
static bool distance_helps(method m, double margins)
{
    return m != PIERCED && (margins > 0 || !(are_polytopes(m) || m == H_CYL));
}

/* The direction of the distance of shapes that are apart. */
static pinch_gjk_outcome distance_normal(method m, const pinch_shape_pair *pair, double margins,
                                         pinch_contact_normal *found)
{
    pinch_gjk_result result;
    const double guess[3] = {-pair->p[0], -pair->p[1], -pair->p[2]};
    double erosion = pair->a->erosion + pair->b->erosion;
    double precision = are_polytopes(m) ? OF_POLYTOPES : m == SUPER ? OF_FLATTENED : OF_CURVED;
    pinch_gjk_outcome outcome = pinch_gjk(pair, NULL, erosion > 0, guess, margins + erosion, precision, &result);
    if (outcome != PINCH_GJK_APART) return outcome;
    counters.iteration_limit += result.limited;
    pinch_v3_copy(found->normal, result.normal);
    found->overlap = are_polytopes(m) ? -result.distance : pinch_pair_overlap(pair, result.normal);
    if (!are_polytopes(m)) (void)pinch_refine_normal(pair, &result, found);
    return outcome;
}

/* The normal of least overlap of shapes that overlap. A hull's face test has left the best face in `found`. */
static void deep_normal(method m, const pinch_shape_pair *pair, pinch_least_face *faces, pinch_contact_normal *found)
{
    if (!has_hull_faces(m)) {
        *found = (pinch_contact_normal){.overlap = DBL_MAX};
        faces = NULL;
    }
    switch (m) {
    case SEG_CYL:
    case BOX_CYL:
    case CYL_CYL:
        exact_cylinder(m, pair, -DBL_MAX, found);
        return;
    case PIERCED:
    case AXES:
    case H_AXES:
        pinch_separating_axes(pair, faces, found);
        return;
    case ROUND:
    case H_CYL:
    case H_FLAT:
        pinch_polytope_round(pair, faces, found);
        return;
    default:
        counters.iteration_limit += !pinch_epa(pair, found);
        if (m == FLAT) pinch_flat_capsules(pair, found);
    }
}

bool pinch_find_contact_normal(const pinch_shape_pair *pair, pinch_contact_normal *found, pinch_least_face faces[2])
{
    const method m = METHODS[pair->a->kind][pair->b->kind];
    double margins = pair->a->margin + pair->b->margin;
    counters.pairs++;
    faces[0].face = faces[1].face = faces[0].edge = faces[1].edge = -1;

    if (m <= SEG_CYL && pinch_closed_form(pair, found)) return found->overlap + margins > 0;
    if (is_exact_cylinder(m) && margins == 0) {
        exact_cylinder(m, pair, 0, found);
        return found->overlap > 0;
    }
    if (faces_settle(m, pair, faces, found)) return found->overlap + margins > 0;
    if (distance_helps(m, margins)) {
        pinch_gjk_outcome outcome = distance_normal(m, pair, margins, found);
        if (outcome == PINCH_GJK_BEYOND) return false;
        if (outcome == PINCH_GJK_APART) return found->overlap + margins > 0;
    }
    counters.deep++;
    deep_normal(m, pair, faces, found);
    return found->overlap + margins > 0;
}

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
