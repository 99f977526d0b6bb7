/*
 * The overlap p(n) of two cores is the support function of C = B - A, which holds the origin where they penetrate each
 * other, and its least value is the origin's distance to C's surface. A polytope of points of C is inside C: the
 * distance of its nearest facet is at most p's least value, and p along the facet's normal at least. The nearest facet
 * is pushed out to C's surface until the two agree (the expanding polytope algorithm). Unlike descents it misses
 * no valley, whatever the surface: a superellipsoid's is flat at some places and sharp at others.
 */
#include "epa.h"

#include "growing_hull.h"
#include "refine.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>

/* Of the smaller size: no other direction has less overlap by more. Of both sizes: as good as rounding lets it be. */
static const double ENOUGH = 3e-10, EXACT = 1e-14;

enum { MAX_STARTS = 16 };

typedef struct first_points {
    int count;
    pinch_hull_point point[MAX_STARTS];
} first_points;

/* C's point farthest along n, of length 1; n is offered as the answer. */
static void look_along(const pinch_core_pair *pair, const double *n, pinch_hull_point *point,
                       pinch_contact_normal *best)
{
    pinch_pair_support_a(pair, n, point->source);
    pinch_pair_support_b(pair, n, point->x);
    pinch_v3_add_scaled(point->x, -1, point->source);
    double overlap = pinch_v3_dot(point->x, n);
    if (!(overlap < best->overlap)) return;
    best->overlap = overlap;
    pinch_v3_copy(best->normal, n);
}

static void begin_along(const pinch_core_pair *pair, const double *n, first_points *first, pinch_contact_normal *best)
{
    if (first->count < MAX_STARTS) look_along(pair, n, &first->point[first->count++], best);
}

/* Both cores' axes, where flat spots and edges are, both ways, and the line of centres. */
static void begin(const pinch_core_pair *pair, first_points *first, pinch_contact_normal *best)
{
    double axes[3][3], n[3];
    first->count = 0;
    for (int side = 0; side < 2; side++) {
        int count = pinch_core_axes(side ? pair->b : pair->a, axes);
        for (int k = 0; k < count; k++)
            for (int back = 0; back < 2; back++) {
                pinch_v3_copy(n, axes[k]);
                if (side) pinch_pair_turn(pair, axes[k], n);
                if (back) pinch_v3_scale(n, -1);
                begin_along(pair, n, first, best);
            }
    }
    double distance = pinch_v3_norm(pair->p);
    if (!(distance > 0)) return;
    for (int i = 0; i < 3; i++) n[i] = -pair->p[i] / distance;
    begin_along(pair, n, first, best);
}

/* Until no other direction can have less overlap by more than `enough`; `simplex` is where that was, as GJK has it. */
static bool grow(const pinch_core_pair *pair, double enough, pinch_growing_hull *hull, pinch_gjk_result *simplex,
                 pinch_contact_normal *best)
{
    simplex->count = 0;
    for (;;) {
        int nearest = pinch_hull_nearest(hull);
        if (nearest < 0) return false;
        pinch_hull_facet f = hull->facet[nearest];
        pinch_hull_point point;
        if (f.offset < best->overlap - enough) look_along(pair, f.normal, &point, best);
        if (f.offset >= best->overlap - enough) {
            simplex->count = 3;
            for (int k = 0; k < 3; k++) pinch_v3_copy(simplex->a[k], hull->point[f.corner[k]].source);
            return true;
        }
        if (!pinch_hull_add(hull, nearest, &point)) return false;
    }
}

bool pinch_expand(const pinch_core_pair *pair, pinch_contact_normal *best)
{
    pinch_growing_hull hull;
    pinch_gjk_result simplex;
    first_points first;
    double size = fmin(pair->a->bound, pair->b->bound), extent = pair->a->bound + pair->b->bound;
    best->overlap = DBL_MAX;
    begin(pair, &first, best);
    if (!pinch_hull_begin(&hull, extent, first.point, first.count)) return false;
    bool proven = grow(pair, ENOUGH * size, &hull, &simplex, best);
    if (pinch_refine_normal(pair, proven ? &simplex : NULL, best)) return proven;
    /* where a superellipsoid is flat or sharp Newton's method has little to go by, and the polytope goes on */
    bool exact = grow(pair, EXACT * extent, &hull, &simplex, best);
    (void)pinch_refine_normal(pair, exact ? &simplex : NULL, best);
    return proven;
}
