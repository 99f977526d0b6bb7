/* The hull of the grasp wrench space, by Qhull, and the refinement of the nearest facet. */
#include "grasp_quality.h"

#include <float.h>
#include <libqhull_r/qhull_ra.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

grasp_quality_settings grasp_quality_default_settings(void)
{
    return (grasp_quality_settings){.faces = 8, .tolerance = 0.01, .most_points = 200};
}

typedef struct cloud {
    const wrench_space *space;
    int count, room;
    double *points; /* `dimension` numbers each; the first is the origin */
} cloud;

/* A facet of the hull that is near the origin. */
typedef struct near_facet {
    double distance; /* >= 0, of the origin */
    double normal[WRENCH_MOST];
} near_facet;

/* So many facets are refined at a time: enough to make a hull worth its cost. */
enum { MOST_NEAR = 24 };

typedef struct hull_answer {
    double volume;
    int near_count; /* sorted by distance */
    near_facet near[MOST_NEAR];
} hull_answer;

static bool add_point(cloud *c, const double *w)
{
    int d = c->space->dimension;
    if (c->count == c->room) {
        int room = 2 * c->room;
        double *more = realloc(c->points, (size_t)room * (size_t)d * sizeof *more);
        if (!more) return false;
        c->points = more;
        c->room = room;
    }
    memcpy(c->points + (size_t)c->count * (size_t)d, w, (size_t)d * sizeof *w);
    c->count++;
    return true;
}

static bool start_cloud(cloud *c, const wrench_space *s, int faces)
{
    int total = 1;
    for (int i = 0; i < s->count; i++) total += wrench_space_generators(s, i, faces);
    *c = (cloud){s, total, total, calloc((size_t)total * (size_t)s->dimension, sizeof(double))};
    if (!c->points) return false;
    double *at = c->points + s->dimension;
    for (int i = 0; i < s->count; i++) {
        wrench_space_generate(s, i, faces, at);
        at += wrench_space_generators(s, i, faces) * s->dimension;
    }
    return true;
}

static void keep_near(hull_answer *a, const facetT *facet, int dimension)
{
    double distance = fmax(0.0, -facet->offset);
    if (a->near_count == MOST_NEAR && distance >= a->near[MOST_NEAR - 1].distance) return;
    int at = a->near_count < MOST_NEAR ? a->near_count++ : MOST_NEAR - 1;
    for (; at > 0 && a->near[at - 1].distance > distance; at--) a->near[at] = a->near[at - 1];
    a->near[at].distance = distance;
    memcpy(a->near[at].normal, facet->normal, (size_t)dimension * sizeof(double));
}

static void read_hull(qhT *qh, int dimension, hull_answer *a)
{
    facetT *facet;
    a->near_count = 0;
    FORALLfacets
    {
        keep_near(a, facet, dimension);
    }
    qh_getarea(qh, qh->facet_list);
    a->volume = qh->totvol;
}

/* A flat cloud has no volume and one facet, which the origin lies on. */
static void answer_flat(hull_answer *a)
{
    *a = (hull_answer){.near_count = 1};
}

/* Points that span less than the whole space have a Gram matrix with a pivot that is rounding alone. Qhull would spend
 * its tolerances on them, and name several errors. */
static bool is_flat(const cloud *c)
{
    int d = c->space->dimension;
    double gram[WRENCH_MOST][WRENCH_MOST] = {{0}}, largest = 0.0;
    for (int p = 0; p < c->count; p++)
        for (int i = 0; i < d; i++)
            for (int j = 0; j < d; j++) gram[i][j] += c->points[p * d + i] * c->points[p * d + j];
    for (int i = 0; i < d; i++) largest = fmax(largest, gram[i][i]);
    for (int k = 0; k < d; k++) {
        int pivot = k;
        for (int i = k; i < d; i++)
            if (gram[i][i] > gram[pivot][pivot]) pivot = i;
        if (gram[pivot][pivot] <= 1e-13 * largest) return true;
        for (int j = 0; j < d; j++) {
            double swap = gram[k][j];
            gram[k][j] = gram[pivot][j];
            gram[pivot][j] = swap;
        }
        for (int i = 0; i < d; i++) {
            double swap = gram[i][k];
            gram[i][k] = gram[i][pivot];
            gram[i][pivot] = swap;
        }
        for (int i = k + 1; i < d; i++) {
            double factor = gram[i][k] / gram[k][k];
            for (int j = k; j < d; j++) gram[i][j] -= factor * gram[k][j];
        }
    }
    return false;
}

static grasp_quality_status find_hull(const cloud *c, hull_answer *a)
{
    if (is_flat(c)) {
        answer_flat(a);
        return GRASP_QUALITY_FINE;
    }
    size_t size = (size_t)c->count * (size_t)c->space->dimension * sizeof(double);
    double *copy = malloc(size);
    FILE *nowhere = fopen("/dev/null", "w"); /* Qhull prints much */
    if (!copy || !nowhere) {
        free(copy);
        if (nowhere) fclose(nowhere);
        return GRASP_QUALITY_NO_MEMORY;
    }
    memcpy(copy, c->points, size);
    qhT context;
    qh_zero(&context, nowhere);
    char options[] = "qhull Pp Q12";
    int failed = qh_new_qhull(&context, c->space->dimension, c->count, copy, False, options, NULL, nowhere);
    if (!failed) read_hull(&context, c->space->dimension, a);
    context.NOerrexit = True;
    qh_freeqhull(&context, !qh_ALL);
    int current, total;
    qh_memfreeshort(&context, &current, &total);
    fclose(nowhere);
    free(copy);
    if (failed == qh_ERRsingular) answer_flat(a);
    if (!failed || failed == qh_ERRsingular) return GRASP_QUALITY_FINE;
    return failed == qh_ERRmem ? GRASP_QUALITY_NO_MEMORY : GRASP_QUALITY_FAILED;
}

static double exact_support(const wrench_space *s, const double *d)
{
    double w[WRENCH_MOST];
    return fmax(0.0, wrench_space_reach(s, d, w)); /* no force at all is in the set, too */
}

/* The true bodies reach further than a facet of the hull in its direction. Their points there become points of the
 * hull. Returns how many were added; -1 when memory runs out. */
static int refine(cloud *c, const hull_answer *a, double upper, double tolerance)
{
    int before = c->count;
    for (int k = 0; k < a->near_count; k++) {
        const near_facet *f = &a->near[k];
        if (f->distance >= upper * (1.0 - tolerance)) break;
        for (int i = 0; i < c->space->count; i++) {
            double w[WRENCH_MOST];
            double reach = wrench_space_support(c->space, i, f->normal, w);
            if (reach > f->distance + 0.25 * tolerance * upper && !add_point(c, w)) return -1;
        }
    }
    return c->count - before;
}

/* The bounds of epsilon that the hull gives. The lower bound is that of the last hull, the largest so far. */
static void take_bounds(const wrench_space *s, const hull_answer *a, grasp_quality *q)
{
    q->epsilon = a->near[0].distance;
    for (int k = 0; k < a->near_count; k++) {
        double reach = a->volume > 0.0 ? exact_support(s, a->near[k].normal) : 0.0;
        if (reach >= q->epsilon_upper) continue;
        q->epsilon_upper = reach;
        memcpy(q->weakest, a->near[k].normal, sizeof q->weakest);
    }
    q->epsilon_upper = fmax(q->epsilon_upper, q->epsilon);
}

/* Each hull lies within the wrench space, so that its nearest facet bounds epsilon from below. The support of the exact
 * cones along any facet's normal bounds it from above. Where the two differ, the space bulges out beyond the facet, and
 * its points there refine the hull (a cutting-plane method on the polar body). That goes for the first hull, too, where
 * it leaves the origin out: the space may have it. */
static grasp_quality_status find(cloud *c, const grasp_quality_settings *settings, grasp_quality *q)
{
    const double rounding = 64 * DBL_EPSILON;
    double tolerance = fmax(settings->tolerance, rounding);
    hull_answer a = {.near_count = 0};
    grasp_quality_status status = find_hull(c, &a);
    if (status != GRASP_QUALITY_FINE) return status;
    q->volume = a.volume;
    q->points = c->count;
    q->epsilon_upper = INFINITY;
    if (a.volume > 0.0 && !(a.near[0].distance > rounding) && wrench_space_lacks(c->space, rounding, q->weakest)) {
        q->epsilon_upper = 0.0;
        return GRASP_QUALITY_FINE;
    }
    for (;;) {
        take_bounds(c->space, &a, q);
        q->points = c->count;
        if (!(q->epsilon_upper > rounding)) break; /* some wrench has no support at all */
        if (q->epsilon_upper - q->epsilon <= tolerance * q->epsilon_upper || c->count >= settings->most_points) break;
        int added = refine(c, &a, q->epsilon_upper, tolerance);
        if (added < 0) return GRASP_QUALITY_NO_MEMORY;
        /* what Qhull cannot tell from a hull of fewer points ends the search with the bounds that there are */
        if (added == 0 || find_hull(c, &a) != GRASP_QUALITY_FINE || !(a.volume > 0.0)) break;
    }
    if (q->epsilon <= rounding) q->epsilon = 0.0;
    if (q->epsilon_upper <= rounding) q->epsilon_upper = 0.0;
    return GRASP_QUALITY_FINE;
}

grasp_quality_status grasp_quality_find(const pinch_grasp *grasp, const grasp_quality_settings *settings,
                                        grasp_quality *quality)
{
    wrench_space s = wrench_space_of(grasp);
    cloud c;
    *quality = (grasp_quality){.faces = settings->faces};
    if (!start_cloud(&c, &s, settings->faces)) return GRASP_QUALITY_NO_MEMORY;
    grasp_quality_status status = find(&c, settings, quality);
    free(c.points);
    return status;
}
