#include "manifold_points.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

enum { REFERENCE_SIDES = 16 };

/* Straight edges this nearly parallel (sine) touch along a line, if the gap that opens between them is less than this
 * part of the overlap. */
static const double PARALLEL = 0.05, OPENING = 0.01;

/* A face to clip against: points x inside have side[k].x <= offset[k]. The sides are of any length. */
typedef struct window {
    int count;
    double side[32][3], offset[32];
} window;

static void window_of_polygon(const pinch_core_part *face, const double *normal, double slack, window *w)
{
    double middle[3] = {0, 0, 0};
    for (int k = 0; k < face->count; k++) pinch_v3_add_scaled(middle, 1.0 / face->count, face->x[k]);
    w->count = 0;
    for (int k = 0; k < face->count; k++) {
        const double *from = face->x[k], *to = face->x[(k + 1) % face->count];
        double edge[3], *side = w->side[w->count];
        pinch_v3_sub(to, from, edge);
        pinch_v3_cross(edge, normal, side);
        double offset = pinch_v3_dot(side, from);
        if (pinch_v3_dot(side, middle) > offset) {
            pinch_v3_scale(side, -1);
            offset = -offset;
        }
        double reach = fabs(side[0]) + fabs(side[1]) + fabs(side[2]);
        w->offset[w->count++] = offset + slack * reach; /* at least the slack to the outside */
    }
}

/* A round face: the polygon around it, so that no point of the face is lost. */
static void window_of_disc(const double *centre, double radius, const double *normal, window *w)
{
    static const double COS[5] = {1, 0.92387953251128676, 0.70710678118654752, 0.38268343236508977, 0};
    double t1[3], t2[3];
    pinch_v3_any_perpendicular(normal, t1);
    pinch_v3_cross(normal, t1, t2);
    w->count = REFERENCE_SIDES;
    for (int k = 0; k < REFERENCE_SIDES; k++) {
        int of = k % 8, fold = k / 8 ? -1 : 1; /* a quarter of the circle, and the others by symmetry */
        double c = fold * (of <= 4 ? COS[of] : -COS[8 - of]), s = fold * (of <= 4 ? COS[4 - of] : COS[of - 4]);
        for (int i = 0; i < 3; i++) w->side[k][i] = c * t1[i] + s * t2[i];
        w->offset[k] = pinch_v3_dot(w->side[k], centre) + radius;
    }
}

/* What is kept of x beyond one side: `out` holds how far each point is outside. */
static int cut(const double *out, double x[PINCH_TOUCHES][3], int count)
{
    double kept[PINCH_TOUCHES][3];
    int n = 0, edges = count > 2 ? count : count - 1;
    for (int k = 0; k < count; k++) {
        int next = k + 1 < count ? k + 1 : 0;
        double dp = out[k], dq = out[next];
        if (dp <= 0 && n < PINCH_TOUCHES) pinch_v3_copy(kept[n++], x[k]);
        if ((dp <= 0) == (dq <= 0) || k >= edges || n == PINCH_TOUCHES) continue;
        double t = dp / (dp - dq);
        for (int i = 0; i < 3; i++) kept[n][i] = x[k][i] + t * (x[next][i] - x[k][i]);
        n++;
    }
    memcpy(x, kept, (size_t)n * sizeof kept[0]);
    return n;
}

/* Sutherland and Hodgman, for polygons, segments and points. *whole becomes false where something is cut off. */
static int clip(const window *w, double x[PINCH_TOUCHES][3], int count, bool *whole)
{
    for (int s = 0; s < w->count && count > 0; s++) {
        double out[PINCH_TOUCHES];
        int outside = 0;
        for (int k = 0; k < count; k++) {
            out[k] = pinch_v3_dot(w->side[s], x[k]) - w->offset[s];
            outside += out[k] > 0;
        }
        if (outside == 0) continue;
        *whole = false;
        if (outside == count) return 0;
        count = cut(out, x, count);
    }
    return count;
}

static void to_a(const pinch_core_pair *pair, pinch_core_part *part)
{
    for (int k = 0; k < part->count; k++) {
        double x[3];
        pinch_pair_turn(pair, part->x[k], x);
        for (int i = 0; i < 3; i++) part->x[k][i] = x[i] + pair->p[i];
    }
}

/* `which` 0: A's part at -n, 1: B's at n; in A's axes. */
static void part_at(const pinch_core_pair *pair, int which, const double *n, bool exact, pinch_core_part *part)
{
    double d[3] = {-n[0], -n[1], -n[2]};
    if (which) pinch_pair_turn_back(pair, n, d);
    pinch_core_part_at(which ? pair->b : pair->a, d, exact, part);
    if (which) to_a(pair, part);
}

/* One point of core `which`, `depth` deep along n (skins included). */
static void touch_at(const pinch_core_pair *pair, int which, const double *x, const double *n, double depth,
                     pinch_touch *touch)
{
    double skin = which ? pair->b->skin : -pair->a->skin, half = which ? -0.5 * depth : 0.5 * depth;
    for (int i = 0; i < 3; i++) touch->position[i] = x[i] + (skin + half) * n[i];
    touch->depth = depth;
}

static bool is_round(const pinch_core *core)
{
    return core->kind == PINCH_CORE_CYLINDER || core->kind == PINCH_CORE_FLAT_CAPSULE;
}

/* A flat face to clip against: what is outside of it, seen along n, does not meet it. */
typedef struct flat_face {
    const pinch_core *core;
    const pinch_core_part *part;
    const double *n;
    double centre[3]; /* of a round one */
    double slack;     /* m: a corner just outside by rounding is kept */
} flat_face;

static flat_face face_of(const pinch_core *core, const pinch_core_part *part, const double *n)
{
    flat_face face = {.core = core, .part = part, .n = n, .slack = 1e-9 * core->bound};
    for (int k = 0; k < part->count && is_round(core); k++)
        pinch_v3_add_scaled(face.centre, 1.0 / part->count, part->x[k]);
    return face;
}

/* Leaves of the polygon x what lies over the face; *whole: all of it. */
static int clip_to_face(const flat_face *face, double x[PINCH_TOUCHES][3], int count, bool *whole)
{
    window w;
    *whole = true;
    if (is_round(face->core)) {
        double radius = face->core->radius + face->slack, most = 0;
        for (int k = 0; k < count; k++) {
            double d[3];
            pinch_v3_sub(x[k], face->centre, d);
            pinch_v3_make_perpendicular(d, face->n);
            most = fmax(most, pinch_v3_dot(d, d));
        }
        if (most <= radius * radius) return count;
        window_of_disc(face->centre, radius, face->n, &w);
    } else {
        window_of_polygon(face->part, face->n, face->slack, &w);
    }
    return clip(&w, x, count, whole);
}

/* How deep each of the points is in the face's plane; how many are, and the last of them. */
typedef struct levels {
    double depth[PINCH_TOUCHES];
    int deep, last;
} levels;

static void find_levels(double x[PINCH_TOUCHES][3], int count, const double *n, double sign, double offset, levels *l)
{
    l->deep = l->last = 0;
    for (int k = 0; k < count; k++) {
        l->depth[k] = sign * pinch_v3_dot(n, x[k]) + offset;
        if (!(l->depth[k] > 0)) continue;
        l->deep++;
        l->last = k;
    }
}

/* Tilted, one corner of a polygon is deep: is all that is deep around it over the face? Then it stands for it. */
static bool corner_alone(const flat_face *face, double x[PINCH_TOUCHES][3], int count, const levels *l)
{
    double tip[PINCH_TOUCHES][3];
    int k = l->last, beside[2] = {(k + 1) % count, (k + count - 1) % count};
    bool whole;
    if (l->deep != 1 || !is_round(face->core)) return false; /* few sides are as soon clipped against */
    pinch_v3_copy(tip[0], x[k]);
    for (int i = 0; i < 2; i++) { /* to where the edge leaves the plane */
        double part = l->depth[k] / (l->depth[k] - l->depth[beside[i]]);
        for (int j = 0; j < 3; j++) tip[1 + i][j] = x[k][j] + part * (x[beside[i]][j] - x[k][j]);
    }
    (void)clip_to_face(face, tip, 3, &whole);
    return whole;
}

/* A flat face of core `which` meets whatever the other one has there. */
static int on_face(const pinch_core_pair *pair, int which, const pinch_core_part *part,
                   const pinch_contact_normal *normal, pinch_touch *touches)
{
    const double *n = normal->normal;
    const flat_face face = face_of(which ? pair->b : pair->a, part, n);
    pinch_core_part other;
    double skins = pair->a->skin + pair->b->skin, whole = normal->overlap + skins;
    part_at(pair, !which, n, false, &other);
    if (other.count == 1) { /* the point itself decided on the normal: it is over the face */
        touch_at(pair, !which, other.x[0], n, whole, &touches[0]);
        return 1;
    }
    double x[PINCH_TOUCHES][3], sign = which ? -1 : 1, offset = skins - sign * pinch_v3_dot(n, part->x[0]), deepest = 0;
    int count = other.count, kept = 0;
    bool all;
    memcpy(x, other.x, (size_t)count * sizeof x[0]);
    levels l;
    find_levels(x, count, n, sign, offset, &l);
    if (l.deep > 0 && !corner_alone(&face, x, count, &l)) {
        count = clip_to_face(&face, x, count, &all);
        if (!all) find_levels(x, count, n, sign, offset, &l);
    }
    for (int k = 0; k < count; k++) {
        deepest = fmax(deepest, l.depth[k]);
        if (l.depth[k] > 0) touch_at(pair, !which, x[k], n, l.depth[k], &touches[kept++]);
    }
    if (deepest > whole - face.slack || kept == PINCH_TOUCHES) return kept;
    part_at(pair, !which, n, true, &other); /* a face's corner to rounding outside the other face */
    touch_at(pair, !which, other.x[0], n, whole, &touches[kept]);
    return kept + 1;
}

/* How far to the side a straight edge of this core still has other material around it. */
static double thickness(const pinch_core *core)
{
    return core->skin + (is_round(core) ? core->radius : 0);
}

/* Two straight edges, both at right angles to n: along a line where they are as good as parallel. */
static int edges(const pinch_core_pair *pair, const pinch_core_part *a, const pinch_core_part *b,
                 const pinch_contact_normal *normal, double depth, pinch_touch *touches)
{
    const double *n = normal->normal;
    double u[3], v[3], across[3], from[3], gap[3];
    pinch_v3_sub(a->x[1], a->x[0], u);
    pinch_v3_sub(b->x[1], b->x[0], v);
    double lu = pinch_v3_norm(u), lv = pinch_v3_norm(v);
    if (!(lu > 0) || !(lv > 0)) return 0;
    pinch_v3_scale(u, 1 / lu);
    pinch_v3_scale(v, 1 / lv);
    pinch_v3_cross(u, v, across);
    double sine = pinch_v3_dot(across, n), cosine = pinch_v3_dot(u, v);
    pinch_v3_sub(b->x[0], a->x[0], from);
    if (fabs(sine) < PARALLEL) {
        double s0 = pinch_v3_dot(from, u), s1 = s0 + lv * cosine;
        double low = fmax(0, fmin(s0, s1)), high = fmin(lu, fmax(s0, s1)), most = 0;
        double ends[2] = {low, high}, thick = thickness(pair->a) + thickness(pair->b);
        for (int k = 0; k < 2; k++) { /* sideways from A's line to B's */
            double side[3], t = (ends[k] - s0) / cosine;
            pinch_v3_copy(gap, from);
            pinch_v3_add_scaled(gap, t, v);
            pinch_v3_cross(n, u, side);
            most = fmax(most, fabs(pinch_v3_dot(gap, side)));
        }
        if (high - low > 1e-3 * fmin(lu, lv) && most * most <= 2 * thick * OPENING * depth) {
            for (int k = 0; k < 2; k++) {
                double x[3];
                pinch_v3_copy(x, a->x[0]);
                pinch_v3_add_scaled(x, ends[k], u);
                touch_at(pair, 0, x, n, depth, &touches[k]);
            }
            return 2;
        }
    }
    if (!(fabs(sine) > 1e-12)) return 0;
    /* where the lines cross, seen along n: from + t v - s u has no part across n */
    pinch_v3_cross(from, v, gap);
    double s = pinch_v3_dot(gap, n) / sine, x[3];
    s = fmax(0, fmin(lu, s));
    pinch_v3_copy(x, a->x[0]);
    pinch_v3_add_scaled(x, s, u);
    touch_at(pair, 0, x, n, depth, &touches[0]);
    return 1;
}

/* A single point: of the core that has just one there. */
static int single(const pinch_core_pair *pair, const pinch_core_part part[2], const double *n, double depth,
                  pinch_touch *touches)
{
    int which = part[0].count == 1 || part[1].count != 1 ? 0 : 1;
    double x[3] = {0, 0, 0};
    for (int k = 0; k < part[which].count; k++) pinch_v3_add_scaled(x, 1.0 / part[which].count, part[which].x[k]);
    touch_at(pair, which, x, n, depth, touches);
    return 1;
}

int pinch_touch_points(const pinch_core_pair *pair, const pinch_contact_normal *normal, pinch_touch *touches)
{
    pinch_core_part part[2];
    double depth = normal->overlap + pair->a->skin + pair->b->skin;
    int count = 0;
    for (int which = 0; which < 2; which++) part_at(pair, which, normal->normal, true, &part[which]);
    if (part[0].count == 1 && part[1].count == 1) return single(pair, part, normal->normal, depth, touches);
    for (int which = 0; which < 2 && count == 0; which++)
        if (part[which].face) count = on_face(pair, which, &part[which], normal, touches);
    if (count == 0 && part[0].count == 2 && part[1].count == 2)
        count = edges(pair, &part[0], &part[1], normal, depth, touches);
    return count > 0 ? count : single(pair, part, normal->normal, depth, touches);
}

int pinch_touch_plane(const pinch_core *core, const double n[3], double offset, pinch_touch *touches)
{
    pinch_core_part part;
    const double d[3] = {-n[0], -n[1], -n[2]};
    int kept = 0;
    pinch_core_part_at(core, d, false, &part);
    for (int k = 0; k < part.count; k++) {
        double depth = offset + core->skin - pinch_v3_dot(n, part.x[k]);
        if (!(depth > 0)) continue;
        for (int i = 0; i < 3; i++) touches[kept].position[i] = part.x[k][i] + (0.5 * depth - core->skin) * n[i];
        touches[kept++].depth = depth;
    }
    return kept;
}
