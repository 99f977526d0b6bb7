#include "distance.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MAX_ITERATIONS = 100 };

/* The simplex consists of points of A - B, each with the points of A and B that it comes from. */
typedef struct simplex {
    int count;
    double w[4][3], a[4][3], b[4][3];
} simplex;

/* The candidate for the point nearest to the origin, and which vertices span it. */
typedef struct nearest {
    double v[3], vv;
    int count, index[4];
} nearest;

static void offer(nearest *best, const double *v, int count, int i, int j, int k)
{
    double vv = pinch_v3_dot(v, v);
    if (!(vv < best->vv)) return;
    pinch_v3_copy(best->v, v);
    best->vv = vv;
    best->count = count;
    best->index[0] = i;
    best->index[1] = j;
    best->index[2] = k;
}

static void offer_segment(const simplex *s, int i, int j, nearest *best)
{
    double e[3], v[3];
    pinch_v3_sub(s->w[i], s->w[j], e);
    double ee = pinch_v3_dot(e, e), t = pinch_v3_dot(s->w[i], e);
    if (!(t > 0 && t < ee)) return;
    t /= ee;
    for (int k = 0; k < 3; k++) v[k] = s->w[i][k] - t * e[k];
    offer(best, v, 2, i, j, -1);
}

/* The origin's foot is inside the triangle if it sees all edges to the same side. */
static void offer_triangle(const simplex *s, int i, int j, int k, nearest *best)
{
    double e[3], f[3], n[3], c[3];
    const double *w[3] = {s->w[i], s->w[j], s->w[k]};
    pinch_v3_sub(w[1], w[0], e);
    pinch_v3_sub(w[2], w[0], f);
    pinch_v3_cross(e, f, n);
    double nn = pinch_v3_dot(n, n);
    if (!(nn > 1e-24 * pinch_v3_dot(e, e) * pinch_v3_dot(f, f))) return;
    for (int m = 0; m < 3; m++) {
        pinch_v3_cross(w[(m + 1) % 3], w[(m + 2) % 3], c);
        if (pinch_v3_dot(c, n) < 0) return;
    }
    double scale = pinch_v3_dot(w[0], n) / nn;
    for (int m = 0; m < 3; m++) c[m] = scale * n[m];
    offer(best, c, 3, i, j, k);
}

/* The tetrahedron holds the origin if every face has it on the side of the fourth vertex. */
static bool holds_origin(const simplex *s)
{
    for (int m = 0; m < 4; m++) {
        const double *p = s->w[m], *q = s->w[(m + 1) % 4], *r = s->w[(m + 2) % 4], *opposite = s->w[(m + 3) % 4];
        double e[3], f[3], n[3], to[3];
        pinch_v3_sub(q, p, e);
        pinch_v3_sub(r, p, f);
        pinch_v3_sub(opposite, p, to);
        pinch_v3_cross(e, f, n);
        double inside = pinch_v3_dot(n, to), origin = -pinch_v3_dot(n, p);
        if (inside * origin < 0 || !(fabs(inside) > 1e-14 * pinch_v3_norm(n) * pinch_v3_norm(to))) return false;
    }
    return true;
}

/* Finds the nearest point of the simplex over all its faces that contain the newest vertex. */
static nearest nearest_of(const simplex *s)
{
    nearest best = {.vv = DBL_MAX};
    int last = s->count - 1;
    offer(&best, s->w[last], 1, last, -1, -1);
    for (int i = 0; i < last; i++) offer_segment(s, last, i, &best);
    for (int i = 0; i < last; i++)
        for (int j = i + 1; j < last; j++) offer_triangle(s, last, i, j, &best);
    return best;
}

static void keep(simplex *s, const nearest *best)
{
    simplex kept;
    kept.count = best->count;
    for (int i = 0; i < best->count; i++) {
        memcpy(kept.w[i], s->w[best->index[i]], sizeof kept.w[i]);
        memcpy(kept.a[i], s->a[best->index[i]], sizeof kept.a[i]);
        memcpy(kept.b[i], s->b[best->index[i]], sizeof kept.b[i]);
    }
    s->count = kept.count;
    memcpy(s->w, kept.w, (size_t)kept.count * sizeof kept.w[0]);
    memcpy(s->a, kept.a, (size_t)kept.count * sizeof kept.a[0]);
    memcpy(s->b, kept.b, (size_t)kept.count * sizeof kept.b[0]);
}

static void add_support(const pinch_shape_pair *pair, const double *shift, double erosion, const double *v, simplex *s)
{
    double *w = s->w[s->count], *a = s->a[s->count], *b = s->b[s->count];
    pinch_pair_support_a(pair, v, a);
    pinch_pair_support_b(pair, v, b);
    pinch_v3_sub(a, b, w);
    if (shift) pinch_v3_add_scaled(w, 1, shift);
    if (erosion > 0) pinch_v3_add_scaled(w, erosion / pinch_v3_norm(v), v);
    s->count++;
}

static bool has_newest_already(const simplex *s)
{
    const double *w = s->w[s->count - 1];
    for (int i = 0; i + 1 < s->count; i++)
        if (s->w[i][0] == w[0] && s->w[i][1] == w[1] && s->w[i][2] == w[2]) return true;
    return false;
}

static void finish(const simplex *s, const double *v, double vv, pinch_gjk_result *result)
{
    result->distance = sqrt(vv);
    for (int i = 0; i < 3; i++) result->normal[i] = v[i] / result->distance;
    result->count = s->count;
    memcpy(result->a, s->a, sizeof s->a);
    memcpy(result->b, s->b, sizeof s->b);
}

pinch_gjk_outcome pinch_gjk(const pinch_shape_pair *pair, const double *shift, bool eroded, const double guess[3],
                            double cutoff, double precision, pinch_gjk_result *result)
{
    simplex s;
    double erosion = eroded ? pair->a->erosion + pair->b->erosion : 0;
    double size = fmin(pair->a->bound, pair->b->bound), touching_distance = 1e-10 * size, v[3], vv = DBL_MAX;
    s.count = 0;
    pinch_v3_copy(v, guess);
    if (!(pinch_v3_dot(v, v) > 0)) v[0] = 1;
    result->limited = false;
    for (int k = 0; k < MAX_ITERATIONS; k++) {
        add_support(pair, shift, erosion, v, &s);
        const double *w = s.w[s.count - 1];
        double along = pinch_v3_dot(v, w), length2 = pinch_v3_dot(v, v);
        if (along > 0 && along * along > cutoff * cutoff * length2) return PINCH_GJK_BEYOND;
        if (k > 0 && (vv - along <= precision * vv || has_newest_already(&s))) {
            s.count--;
            finish(&s, v, vv, result);
            return PINCH_GJK_APART;
        }
        if (s.count == 4 && holds_origin(&s)) return PINCH_GJK_TOUCHING;
        nearest best = nearest_of(&s);
        if (k > 0 && !(best.vv < vv)) { /* only rounding is left */
            s.count--;
            finish(&s, v, vv, result);
            return PINCH_GJK_APART;
        }
        keep(&s, &best);
        pinch_v3_copy(v, best.v);
        vv = best.vv;
        if (vv <= touching_distance * touching_distance) return PINCH_GJK_TOUCHING;
    }
    finish(&s, v, vv, result);
    result->limited = true;
    return PINCH_GJK_APART;
}
