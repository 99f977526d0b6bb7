/*
 * The overlap p(n) of two shapes is the support function of their Minkowski difference C = B - A, which holds the
 * origin where they overlap. The least value of p is the origin's distance to C's surface. A polytope of points of C
 * lies inside C: the distance of its nearest facet is at most that value, and p along the facet's normal is at least
 * that value. The expanding polytope algorithm (EPA; van den Bergen 2001) pushes the nearest facet out to C's surface
 * until the two agree. It misses no minimum, whatever the surface: a superellipsoid's is flat at some
 * places and sharp at others.
 */
#include "methods.h"

#include "refine.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>

enum { MAX_POINTS = 320, MAX_FACETS = 2 * MAX_POINTS };

typedef struct epa_point {
    double x[3];
    double a[3], b[3]; /* the points of A and B it comes from: x = b - a */
} epa_point;

/* A facet is a triangle with its corners counter-clockwise from outside. beside[k] is the facet across the edge from
 * corner k to the next. */
typedef struct epa_facet {
    int corner[3], beside[3];
    double normal[3]; /* unit, outward */
    double offset;    /* of its plane along the normal; DBL_MAX: not part of the hull */
} epa_facet;

typedef struct epa_polytope {
    double size; /* of all points that may come, m */
    int points, facets, unused_count;
    int unused[MAX_FACETS]; /* places of facets that are gone */
    epa_point point[MAX_POINTS];
    epa_facet facet[MAX_FACETS];
} epa_polytope;

/* A point this little outside a facet's plane, in parts of the size, counts as in the plane. */
static const double ROUNDING = 1e-14;

/* Of the first points only those count that are farther out than this part of the size. */
static const double FIRST = 1e-9;

/* The facets that a point sees form one connected patch with a border. */
typedef struct visible_facets {
    int count, seen[MAX_FACETS];
    int edges, from[MAX_FACETS], to[MAX_FACETS], outside[MAX_FACETS];
    bool is_seen[MAX_FACETS];
} visible_facets;

static void set_facet(epa_polytope *hull, int k, int i, int j, int m)
{
    epa_facet *f = &hull->facet[k];
    double u[3], v[3];
    f->corner[0] = i;
    f->corner[1] = j;
    f->corner[2] = m;
    pinch_v3_sub(hull->point[j].x, hull->point[i].x, u);
    pinch_v3_sub(hull->point[m].x, hull->point[i].x, v);
    pinch_v3_cross(u, v, f->normal);
    double length = pinch_v3_norm(f->normal);
    pinch_v3_scale(f->normal, 1 / length);
    f->offset = pinch_v3_dot(f->normal, hull->point[i].x);
    /* three points in a line name no plane, and nothing is to be found there that the neighbours do not have */
    if (!(length > 1e-26 * hull->size * hull->size) || !isfinite(f->offset)) f->offset = 0.5 * DBL_MAX;
}

static double height(const epa_polytope *hull, int facet, const double *x)
{
    const epa_facet *f = &hull->facet[facet];
    return pinch_v3_dot(f->normal, x) - f->offset;
}

static void see_facet(visible_facets *p, int facet)
{
    p->is_seen[facet] = true;
    p->seen[p->count++] = facet;
}

/* Spreads from the facet over all facets that see the point. */
static void find_visible(const epa_polytope *hull, int facet, const double *x, visible_facets *p)
{
    p->count = p->edges = 0;
    for (int k = 0; k < hull->facets; k++) p->is_seen[k] = false;
    see_facet(p, facet);
    for (int k = 0; k < p->count; k++)
        for (int e = 0; e < 3; e++) {
            int next = hull->facet[p->seen[k]].beside[e];
            if (!p->is_seen[next] && height(hull, next, x) > ROUNDING * hull->size) see_facet(p, next);
        }
    for (int k = 0; k < p->count; k++) {
        const epa_facet *f = &hull->facet[p->seen[k]];
        for (int e = 0; e < 3; e++) {
            if (p->is_seen[f->beside[e]]) continue;
            p->from[p->edges] = f->corner[e];
            p->to[p->edges] = f->corner[(e + 1) % 3];
            p->outside[p->edges++] = f->beside[e];
        }
    }
}

/* Puts the border's edges in the order of one loop. Returns false where they are not one loop. */
static bool order_border(visible_facets *p)
{
    for (int k = 0; k + 1 < p->edges; k++) {
        int next = k + 1;
        while (next < p->edges && p->from[next] != p->to[k]) next++;
        if (next == p->edges) return false;
        int swap[3] = {p->from[next], p->to[next], p->outside[next]};
        p->from[next] = p->from[k + 1];
        p->to[next] = p->to[k + 1];
        p->outside[next] = p->outside[k + 1];
        p->from[k + 1] = swap[0];
        p->to[k + 1] = swap[1];
        p->outside[k + 1] = swap[2];
    }
    return p->edges > 2 && p->to[p->edges - 1] == p->from[0];
}

/* Lets the edge of `facet` that starts at that corner lead to `other`. */
static void join(epa_polytope *hull, int facet, int corner, int other)
{
    for (int e = 0; e < 3; e++)
        if (hull->facet[facet].corner[e] == corner) hull->facet[facet].beside[e] = other;
}

static int place_for_facet(epa_polytope *hull)
{
    return hull->unused_count > 0 ? hull->unused[--hull->unused_count] : hull->facets++;
}

static bool polytope_add(epa_polytope *hull, int facet, const epa_point *point)
{
    visible_facets p;
    int made[MAX_FACETS];
    if (hull->points == MAX_POINTS) return false;
    find_visible(hull, facet, point->x, &p);
    if (!order_border(&p) || hull->facets - hull->unused_count + p.edges - p.count > MAX_FACETS) return false;
    int at = hull->points++;
    hull->point[at] = *point;
    for (int k = 0; k < p.count; k++) {
        hull->facet[p.seen[k]].offset = DBL_MAX;
        hull->unused[hull->unused_count++] = p.seen[k];
    }
    for (int k = 0; k < p.edges; k++) made[k] = place_for_facet(hull);
    for (int k = 0; k < p.edges; k++) {
        set_facet(hull, made[k], p.from[k], p.to[k], at);
        hull->facet[made[k]].beside[0] = p.outside[k];
        hull->facet[made[k]].beside[1] = made[(k + 1) % p.edges];
        hull->facet[made[k]].beside[2] = made[(k + p.edges - 1) % p.edges];
        join(hull, p.outside[k], p.to[k], made[k]);
    }
    return true;
}

/* Chooses four points that are far from each other in turn. Returns false where all points lie in one plane to
 * rounding. */
static bool choose_four(const epa_point *points, int count, double size, int four[4])
{
    double most = 0, u[3], v[3], n[3];
    four[0] = 0;
    four[1] = four[2] = four[3] = -1;
    for (int k = 1; k < count; k++) {
        pinch_v3_sub(points[k].x, points[0].x, v);
        if (!(pinch_v3_dot(v, v) > most)) continue;
        most = pinch_v3_dot(v, v);
        four[1] = k;
        pinch_v3_copy(u, v);
    }
    if (four[1] < 0) return false;
    most = 0;
    for (int k = 1; k < count; k++) {
        double c[3];
        pinch_v3_sub(points[k].x, points[0].x, v);
        pinch_v3_cross(u, v, c);
        if (!(pinch_v3_dot(c, c) > most)) continue;
        most = pinch_v3_dot(c, c);
        four[2] = k;
        pinch_v3_copy(n, c);
    }
    if (four[2] < 0) return false;
    pinch_v3_scale(n, 1 / pinch_v3_norm(n));
    most = FIRST * size;
    for (int k = 1; k < count; k++) {
        pinch_v3_sub(points[k].x, points[0].x, v);
        if (!(fabs(pinch_v3_dot(v, n)) > most)) continue;
        most = fabs(pinch_v3_dot(v, n));
        four[3] = k;
    }
    if (four[3] < 0) return false;
    pinch_v3_sub(points[four[3]].x, points[0].x, v);
    if (pinch_v3_dot(v, n) > 0) { /* the fourth belongs behind the first three */
        int swap = four[1];
        four[1] = four[2];
        four[2] = swap;
    }
    return true;
}

static bool polytope_begin(epa_polytope *hull, double size, const epa_point *points, int count)
{
    static const int CORNER[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    static const int BESIDE[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
    int four[4];
    hull->size = size;
    hull->points = hull->facets = 4;
    hull->unused_count = 0;
    if (!choose_four(points, count, size, four)) return false;
    for (int k = 0; k < 4; k++) hull->point[k] = points[four[k]];
    for (int k = 0; k < 4; k++) {
        set_facet(hull, k, CORNER[k][0], CORNER[k][1], CORNER[k][2]);
        for (int e = 0; e < 3; e++) hull->facet[k].beside[e] = BESIDE[k][e];
    }
    for (int k = 0; k < count; k++) {
        int best = -1;
        double most = FIRST * size;
        for (int f = 0; f < hull->facets; f++) {
            double over = hull->facet[f].offset < DBL_MAX ? height(hull, f, points[k].x) : 0;
            if (!(over > most)) continue;
            most = over;
            best = f;
        }
        if (best >= 0 && !polytope_add(hull, best, &points[k])) return false;
    }
    return true;
}

static int nearest_facet(const epa_polytope *hull)
{
    int best = -1;
    double least = 0.25 * DBL_MAX;
    for (int k = 0; k < hull->facets; k++) {
        if (!(hull->facet[k].offset < least)) continue;
        least = hull->facet[k].offset;
        best = k;
    }
    return best;
}

/* The search ends when no other direction can have less overlap by more than ENOUGH of the smaller size. EXACT, of both
 * sizes, is as good as rounding lets it be. */
static const double ENOUGH = 3e-10, EXACT = 1e-14;

enum { MAX_STARTS = 24 };

typedef struct first_points {
    int count;
    epa_point point[MAX_STARTS];
} first_points;

/* Finds C's point farthest along the unit vector n, and offers n as the answer. */
static void support_along(const pinch_shape_pair *pair, const double *n, epa_point *point, pinch_contact_normal *best)
{
    pinch_pair_support_a(pair, n, point->a);
    pinch_pair_support_b(pair, n, point->b);
    pinch_v3_copy(point->x, point->b);
    pinch_v3_add_scaled(point->x, -1, point->a);
    double overlap = pinch_v3_dot(point->x, n);
    if (!(overlap < best->overlap)) return;
    best->overlap = overlap;
    pinch_v3_copy(best->normal, n);
}

static void support_from(const pinch_shape_pair *pair, const double *n, first_points *first, pinch_contact_normal *best)
{
    if (first->count < MAX_STARTS) support_along(pair, n, &first->point[first->count++], best);
}

/* The first points lie along the line of centres and along both shapes' axes, where flat spots and edges are. */
static void begin(const pinch_shape_pair *pair, first_points *first, pinch_contact_normal *best)
{
    double axes[3][3], n[3];
    first->count = 0;
    for (int side = 0; side < 2; side++) {
        int count = pinch_shape_axes(side ? pair->b : pair->a, axes);
        for (int k = 0; k < count; k++)
            for (int back = 0; back < 2; back++) {
                pinch_v3_copy(n, axes[k]);
                if (side) pinch_pair_rotate(pair, axes[k], n);
                if (back) pinch_v3_scale(n, -1);
                support_from(pair, n, first, best);
            }
    }
    double distance = pinch_v3_norm(pair->p);
    if (!(distance > 0)) return;
    for (int i = 0; i < 3; i++) n[i] = -pair->p[i] / distance;
    support_from(pair, n, first, best);
}

/* The points so far lie in one plane if the shapes are in line or have no axes. The corners of a box stand askew. */
static void begin_all_round(const pinch_shape_pair *pair, first_points *first, pinch_contact_normal *best)
{
    for (int k = 0; k < 8; k++) {
        double n[3] = {k & 1 ? 1 : -1, k & 2 ? 0.9 : -0.9, k & 4 ? 1.2 : -1.2};
        pinch_v3_scale(n, 1 / pinch_v3_norm(n));
        support_from(pair, n, first, best);
    }
}

/* Expands the polytope until no other direction can have less overlap by more than `enough`. `simplex` is the facet
 * where that was, in the form that GJK has it. */
static bool grow(const pinch_shape_pair *pair, double enough, epa_polytope *hull, pinch_gjk_result *simplex,
                 pinch_contact_normal *best)
{
    simplex->count = 0;
    for (;;) {
        int nearest = nearest_facet(hull);
        if (nearest < 0) return false;
        epa_facet f = hull->facet[nearest];
        epa_point point;
        if (f.offset < best->overlap - enough) support_along(pair, f.normal, &point, best);
        if (f.offset >= best->overlap - enough) {
            simplex->count = 3;
            for (int k = 0; k < 3; k++) {
                pinch_v3_copy(simplex->a[k], hull->point[f.corner[k]].a);
                pinch_v3_copy(simplex->b[k], hull->point[f.corner[k]].b);
            }
            return true;
        }
        if (!polytope_add(hull, nearest, &point)) return false;
    }
}

bool pinch_epa(const pinch_shape_pair *pair, pinch_contact_normal *best)
{
    epa_polytope hull;
    pinch_gjk_result simplex;
    first_points first;
    double size = fmin(pair->a->bound, pair->b->bound), extent = pair->a->bound + pair->b->bound;
    begin(pair, &first, best);
    if (!polytope_begin(&hull, extent, first.point, first.count)) {
        begin_all_round(pair, &first, best);
        if (!polytope_begin(&hull, extent, first.point, first.count)) return false;
    }
    bool proven = grow(pair, ENOUGH * size, &hull, &simplex, best);
    if (pinch_refine_normal(pair, proven ? &simplex : NULL, best)) return proven;
    /* where a superellipsoid is flat or sharp, Newton's method has little to go by and the polytope goes on */
    bool exact = grow(pair, EXACT * extent, &hull, &simplex, best);
    (void)pinch_refine_normal(pair, exact ? &simplex : NULL, best);
    return proven;
}
