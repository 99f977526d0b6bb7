/* Descents from many directions find the least overlap where one shape is curved or has very many edges. The overlap
 * p(n) then has several local minima, and all are looked for. One start is the answer of libccd's EPA, which allocates
 * memory. */
#include "methods.h"

#include "collision/distance/distance.h"
#include "refine.h"
#include "support/vec3.h"

#include <ccd/ccd.h>
#include <float.h>
#include <math.h>
#include <string.h>

static void support_a(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *point)
{
    const pinch_shape_pair *pair = object;
    const double d[3] = {-direction->v[0], -direction->v[1], -direction->v[2]};
    double x[3];
    pinch_pair_support_a(pair, d, x);
    ccdVec3Set(point, x[0], x[1], x[2]);
}

static void support_b(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *point)
{
    const pinch_shape_pair *pair = object;
    double x[3];
    pinch_pair_support_b(pair, direction->v, x);
    ccdVec3Set(point, x[0], x[1], x[2]);
}

static void first_direction(const void *a, const void *b, ccd_vec3_t *direction)
{
    const pinch_shape_pair *pair = a;
    (void)b;
    ccdVec3Set(direction, pair->p[0], pair->p[1], pair->p[2]);
    if (!(ccdVec3Len2(direction) > 0)) ccdVec3Set(direction, 1, 0, 0);
}

static bool ask_libccd(const pinch_shape_pair *pair, pinch_tip_stats *stats, double normal[3])
{
    ccd_t ccd;
    ccd_real_t depth = 0;
    ccd_vec3_t direction = {{0, 0, 0}}, position;
    double size = fmin(pair->a->bound, pair->b->bound);
    CCD_INIT(&ccd);
    ccd.support1 = support_a;
    ccd.support2 = support_b;
    ccd.first_dir = first_direction;
    ccd.max_iterations = 60;
    ccd.epa_tolerance =
        1e-3 * size * size; /* of squared distances; what follows only needs to start near the right minimum */
    stats->libccd_calls++;
    int result = ccdGJKPenetration(pair, pair, &ccd, &depth, &direction, &position);
    for (int i = 0; i < 3; i++) normal[i] = -direction.v[i]; /* libccd's direction moves B */
    double length = pinch_v3_norm(normal);
    bool fine = result == 0 && isfinite(length) && length > 0.5 && isfinite(depth);
    if (fine) {
        pinch_v3_scale(normal, 1 / length);
        /* the nearest facet of an inner polytope cannot be farther out than the body */
        fine = depth <= pinch_pair_overlap(pair, normal) + 1e-6 * size;
    }
    stats->libccd_failed += !fine;
    return fine;
}

/*
 * One descent moves A along n until the bodies are clearly apart, by T = t n with t > p(n). It then takes the direction
 * of their distance, which is where T.m - p(m) is largest over the unit vectors m. So p(m) <= p(n) - t (1 - n.m): the
 * overlap never rises, and at a local minimum m = n. This is the convex-concave procedure. On polytopes GJK's faces end
 * it exactly, on curved bodies Newton's method does.
 */

enum { MAX_DIRECTIONS = 96, MAX_DESCENT = 12 };

/* An overlap of less than SHALLOW of the smaller size needs fewer starts, and those that are worse by HOPELESS of the
 * size lead nowhere better. */
static const double SHALLOW = 0.03, HOPELESS = 0.15;

typedef struct starts {
    int count;
    double n[MAX_DIRECTIONS][3], overlap[MAX_DIRECTIONS];
} starts;

static void add_start(const pinch_shape_pair *pair, const double *direction, starts *s)
{
    double length = pinch_v3_norm(direction);
    if (!(length > 1e-9) || s->count == MAX_DIRECTIONS) return;
    double *n = s->n[s->count];
    for (int i = 0; i < 3; i++) n[i] = direction[i] / length;
    s->overlap[s->count++] = pinch_pair_overlap(pair, n);
}

static void add_both(const pinch_shape_pair *pair, const double *direction, starts *s)
{
    const double back[3] = {-direction[0], -direction[1], -direction[2]};
    add_start(pair, direction, s);
    add_start(pair, back, s);
}

/* Of very many directions only the few best are kept. */
enum { BEST = 8 };
typedef struct best_directions {
    int count;
    pinch_contact_normal item[BEST];
} best_directions;

static void consider(const pinch_shape_pair *pair, const double *direction, best_directions *list)
{
    pinch_contact_normal c;
    double length = pinch_v3_norm(direction);
    if (!(length > 1e-9)) return;
    for (int i = 0; i < 3; i++) c.normal[i] = direction[i] / length;
    c.overlap = pinch_pair_overlap(pair, c.normal);
    int at = list->count < BEST ? list->count++ : BEST;
    while (at > 0 && list->item[at - 1].overlap > c.overlap) {
        if (at < BEST) list->item[at] = list->item[at - 1];
        at--;
    }
    if (at < BEST) list->item[at] = c;
}

/* Starts from a hull's faces, from the middles between faces that meet at an edge, and from the perpendiculars of its
 * edges and the other's axes. */
static void add_hull(const pinch_shape_pair *pair, bool of_b, const double axes[3][3], int axis_count, starts *s)
{
    const pinch_shape *shape = of_b ? pair->b : pair->a;
    best_directions list = {.count = 0};
    double sign = of_b ? 1 : -1, f[3], n[3];
    if (shape->kind != PINCH_SHAPE_HULL) return;
    for (int k = 0; k < pinch_face_count(shape); k++) {
        pinch_face_normal(shape, k, f);
        if (of_b)
            pinch_pair_rotate(pair, f, n);
        else
            for (int i = 0; i < 3; i++) n[i] = -f[i];
        consider(pair, n, &list);
    }
    for (int e = 0; e < shape->hull->edge_count; e++) {
        const pinch_hull_edge *edge = &shape->hull->edges[e];
        const double *x = shape->hull->convex.points + 3 * edge->corner[0];
        const double *y = shape->hull->convex.points + 3 * edge->corner[1];
        const double *f1 = shape->hull->convex.planes + 4 * edge->face[0];
        const double *f2 = shape->hull->convex.planes + 4 * edge->face[1];
        double u[3], middle[3];
        for (int i = 0; i < 3; i++) {
            u[i] = y[i] - x[i];
            middle[i] = sign * (f1[i] + f2[i]);
        }
        if (of_b) {
            pinch_pair_rotate(pair, u, f);
            pinch_v3_copy(u, f);
            pinch_pair_rotate(pair, middle, f);
            pinch_v3_copy(middle, f);
        }
        consider(pair, middle, &list);
        for (int k = 0; k < axis_count; k++) {
            pinch_v3_cross(u, axes[k], n);
            if (pinch_v3_dot(n, middle) < 0) pinch_v3_scale(n, -1);
            consider(pair, n, &list);
        }
    }
    for (int k = 0; k < list.count; k++) add_start(pair, list.item[k].normal, s);
}

/* Starts from both shapes' axes, their cross products, the line of centres, and its components across the axes. */
static void structured_starts(const pinch_shape_pair *pair, starts *s)
{
    double a[3][3], b[3][3], n[3], centre[3] = {-pair->p[0], -pair->p[1], -pair->p[2]};
    int a_count = pinch_shape_axes(pair->a, a), b_count = pinch_shape_axes(pair->b, b);
    for (int k = 0; k < b_count; k++) {
        pinch_pair_rotate(pair, b[k], n);
        pinch_v3_copy(b[k], n);
    }
    add_start(pair, centre, s);
    for (int side = 0; side < 2; side++)
        for (int k = 0; k < (side ? b_count : a_count); k++) {
            const double *axis = side ? b[k] : a[k];
            add_both(pair, axis, s);
            pinch_v3_copy(n, centre);
            pinch_v3_make_perpendicular(n, axis);
            if (pinch_v3_norm(n) > 1e-6 * pair->a->bound) add_start(pair, n, s);
        }
    for (int i = 0; i < a_count; i++)
        for (int j = 0; j < b_count; j++) {
            pinch_v3_cross(a[i], b[j], n);
            add_both(pair, n, s);
        }
    add_hull(pair, false, b, b_count, s);
    add_hull(pair, true, a, a_count, s);
}

/* Starts from the corners of a cube, where nothing structured leads. */
static void spread_starts(const pinch_shape_pair *pair, starts *s)
{
    for (int k = 0; k < 8; k++) {
        const double n[3] = {k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1};
        add_start(pair, n, s);
    }
}

/* The minima that descents have ended in. */
typedef struct minima {
    int count;
    double n[MAX_DIRECTIONS][3];
} minima;

/* Does up to `most` rounds of the descent, until the normal rotates by less than `enough` (squared, rad). Returns true
 * if `result` belongs to the last round. */
static bool descend(const pinch_shape_pair *pair, double size, double precision, int most, double enough,
                    pinch_contact_normal *at, pinch_gjk_result *result)
{
    bool have_simplex = false;
    for (int k = 0; k < most; k++) {
        double shift[3], rotated[3], t = at->overlap + 0.05 * size;
        for (int i = 0; i < 3; i++) shift[i] = t * at->normal[i];
        if (pinch_gjk(pair, shift, false, at->normal, DBL_MAX, precision, result) != PINCH_GJK_APART) break;
        double overlap = pinch_pair_overlap(pair, result->normal);
        if (!(overlap < at->overlap)) return have_simplex || k == 0;
        pinch_v3_sub(result->normal, at->normal, rotated);
        at->overlap = overlap;
        pinch_v3_copy(at->normal, result->normal);
        have_simplex = true;
        if (pinch_v3_dot(rotated, rotated) < enough) break;
    }
    return have_simplex;
}

/* On curved bodies most starts lead where others have led, or nowhere, so a rough descent comes first. */
static bool leads_to_new_minimum(const pinch_shape_pair *pair, double size, const minima *known, double least,
                                 pinch_contact_normal *at)
{
    enum { ROUNDS = 4 };
    static const double ROUGH = 1e-3, SETTLED = 1e-3, SAME = 1 - 1e-5, WORSE = 0.05;
    pinch_gjk_result result;
    (void)descend(pair, size, ROUGH, ROUNDS, SETTLED, at, &result);
    if (at->overlap > least + WORSE * size) return false;
    for (int k = 0; k < known->count; k++)
        if (pinch_v3_dot(known->n[k], at->normal) > SAME) return false;
    return true;
}

static void descend_from(const pinch_shape_pair *pair, const double *start, double size, minima *known,
                         pinch_contact_normal *best)
{
    pinch_contact_normal at;
    pinch_gjk_result result;
    bool polytopes = pinch_is_polytope(pair->a) && pinch_is_polytope(pair->b);
    double precision = polytopes ? 1e-14 : 1e-7, enough = polytopes ? 1e-24 : 1e-5;
    pinch_v3_copy(at.normal, start);
    at.overlap = pinch_pair_overlap(pair, start);
    if (!polytopes && !leads_to_new_minimum(pair, size, known, best->overlap, &at)) return;
    bool have_simplex = descend(pair, size, precision, MAX_DESCENT, enough, &at, &result);
    if (!polytopes) (void)pinch_refine_normal(pair, have_simplex ? &result : NULL, &at);
    if (known->count < MAX_DIRECTIONS) pinch_v3_copy(known->n[known->count++], at.normal);
    if (at.overlap < best->overlap) *best = at;
}

/* Returns the remaining start of least overlap, or -1 if none is below the limit. */
static int take_best(starts *s, double limit)
{
    int best = -1;
    for (int k = 0; k < s->count; k++)
        if (s->overlap[k] < limit && (best < 0 || s->overlap[k] < s->overlap[best])) best = k;
    return best;
}

/* Drops the starts next to a direction that has been used or reached. */
static void drop_starts_near(starts *s, const double *n, double cosine)
{
    for (int k = 0; k < s->count; k++)
        if (pinch_v3_dot(s->n[k], n) > cosine) s->overlap[k] = DBL_MAX;
}

/*
 * Newton's method stays on a face's normal that is as good as its neighbours to rounding. Where the other body's point
 * lies a little beyond the face's border, there is a narrow way down, against the gradient. The support points give it;
 * that of a cap's normal is the cap's middle.
 */
static void descend_from_kink(const pinch_shape_pair *pair, double size, pinch_contact_normal *best)
{
    enum { ROUNDS = 3 };
    static const double TILT = 1e-4, LESS = 1e-11;
    for (int round = 0; round < ROUNDS; round++) {
        pinch_contact_normal beside = *best;
        double a[3], w[3], n[3];
        pinch_pair_support_a(pair, best->normal, a);
        pinch_pair_support_b(pair, best->normal, w);
        pinch_v3_add_scaled(w, -1, a);
        pinch_v3_make_perpendicular(w, best->normal);
        double length = pinch_v3_norm(w);
        if (!(length > LESS * size)) return;
        pinch_v3_copy(n, best->normal);
        pinch_v3_add_scaled(n, -TILT / length, w);
        pinch_v3_scale(n, 1 / pinch_v3_norm(n));
        pinch_offer_normal(pair, n, &beside);
        if (!(beside.overlap < best->overlap - LESS * size)) return;
        *best = beside;
        (void)pinch_refine_normal(pair, NULL, best);
    }
}

void pinch_descent(const pinch_shape_pair *pair, pinch_tip_stats *stats, pinch_contact_normal *best)
{
    starts s;
    minima known = {.count = 0};
    double size = fmin(pair->a->bound, pair->b->bound), n[3];
    s.count = 0;
    structured_starts(pair, &s);
    if (s.count == 0) add_start(pair, (const double[3]){1, 0, 0}, &s);
    double least = s.overlap[0];
    for (int k = 1; k < s.count; k++) least = fmin(least, s.overlap[k]);
    bool shallow = least < SHALLOW * size;
    if (!shallow) {
        spread_starts(pair, &s);
        if (ask_libccd(pair, stats, n)) descend_from(pair, n, size, &known, best);
    }
    for (int tries = shallow ? 2 : 10; tries > 0; tries--) {
        int k = take_best(&s, shallow ? least + HOPELESS * size : DBL_MAX);
        if (k < 0) break;
        pinch_v3_copy(n, s.n[k]);
        descend_from(pair, n, size, &known, best);
        drop_starts_near(&s, n, 0.985);
        drop_starts_near(&s, best->normal, 0.985);
    }
    if (shallow) {
        descend_from_kink(pair, size, best);
        return;
    }
    /* a face's normal holds the descents around it, and there may be another minimum next to it */
    double around[3], t1[3], t2[3];
    pinch_v3_copy(around, best->normal);
    pinch_v3_any_perpendicular(around, t1);
    pinch_v3_cross(around, t1, t2);
    for (int k = 0; k < 12; k++) {
        static const double STEP = 1.0471975511965976;
        double tilt = k < 6 ? 0.15 : 0.4;
        for (int i = 0; i < 3; i++) n[i] = around[i] + tilt * (cos(k * STEP) * t1[i] + sin(k * STEP) * t2[i]);
        pinch_v3_scale(n, 1 / pinch_v3_norm(n));
        descend_from(pair, n, size, &known, best);
    }
    descend_from_kink(pair, size, best);
}
