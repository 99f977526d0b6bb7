#include "face_clip.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

enum { REFERENCE_SIDES = 16 };

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

/* A round face: of the polygon around it, so that no point of the face is lost, the sides that the points x may reach:
 * those of the ball around them. */
static void window_of_disc(const pinch_flat_face *face, double radius, double x[PINCH_TOUCHES][3], int count, window *w)
{
    static const double COS[5] = {1, 0.92387953251128676, 0.70710678118654752, 0.38268343236508977, 0};
    double t1[3], t2[3], middle[3] = {0, 0, 0}, far2 = 0, d[3];
    for (int k = 0; k < count; k++) pinch_v3_add_scaled(middle, 1.0 / count, x[k]);
    for (int k = 0; k < count; k++) {
        pinch_v3_sub(x[k], middle, d);
        double length2 = pinch_v3_dot(d, d);
        if (length2 > far2) far2 = length2;
    }
    pinch_v3_any_perpendicular(face->n, t1);
    pinch_v3_cross(face->n, t1, t2);
    pinch_v3_sub(middle, face->centre, d);
    double u = pinch_v3_dot(t1, d), v = pinch_v3_dot(t2, d), inside = radius - sqrt(far2) - face->slack;
    w->count = 0;
    for (int k = 0; k < REFERENCE_SIDES; k++) {
        int of = k % 8, fold = k / 8 ? -1 : 1; /* a quarter of the circle, and the others by symmetry */
        double c = fold * (of <= 4 ? COS[of] : -COS[8 - of]), s = fold * (of <= 4 ? COS[4 - of] : COS[of - 4]);
        if (c * u + s * v < inside) continue;
        double *side = w->side[w->count];
        for (int i = 0; i < 3; i++) side[i] = c * t1[i] + s * t2[i];
        w->offset[w->count++] = pinch_v3_dot(side, face->centre) + radius;
    }
}

/* What is kept of x beyond one side: `out` holds how far each point is outside. */
static int cut(const double *out, double x[PINCH_TOUCHES][3], int count, double kept[PINCH_TOUCHES][3])
{
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
    return n;
}

/* Sutherland and Hodgman, for polygons, segments and points. *whole becomes false where something is cut off. */
static int clip(const window *w, double x[PINCH_TOUCHES][3], int count, bool *whole)
{
    double room[PINCH_TOUCHES][3], (*from)[3] = x, (*to)[3] = room;
    for (int s = 0; s < w->count && count > 0; s++) {
        double out[PINCH_TOUCHES];
        int outside = 0;
        for (int k = 0; k < count; k++) {
            out[k] = pinch_v3_dot(w->side[s], from[k]) - w->offset[s];
            outside += out[k] > 0;
        }
        if (outside == 0) continue;
        *whole = false;
        if (outside == count) return 0;
        count = cut(out, from, count, to);
        double(*swap)[3] = from;
        from = to;
        to = swap;
    }
    if (from != x) memcpy(x, from, (size_t)count * sizeof x[0]);
    return count;
}

pinch_flat_face pinch_face_of(const pinch_core_pair *pair, int which, const pinch_core_part *part, const double n[3])
{
    const pinch_core *core = which ? pair->b : pair->a;
    pinch_flat_face face = {.pair = pair, .which = which, .core = core, .part = part, .slack = 1e-9 * core->bound};
    pinch_v3_copy(face.n, n);
    for (int k = 0; k < part->count && pinch_core_is_round(core); k++)
        pinch_v3_add_scaled(face.centre, 1.0 / part->count, part->x[k]);
    return face;
}

/* Are all points over the box' face? */
static bool over_box(const pinch_flat_face *face, double x[PINCH_TOUCHES][3], int count)
{
    const double *h = face->core->half;
    double d[3], normal[3];
    int axis = 0;
    pinch_v3_copy(normal, face->n);
    if (face->which) pinch_pair_turn_back(face->pair, face->n, normal);
    for (int i = 1; i < 3; i++)
        if (fabs(normal[i]) > fabs(normal[axis])) axis = i;
    int j = (axis + 1) % 3, l = (axis + 2) % 3;
    double most_j = h[j] + face->slack, most_l = h[l] + face->slack;
    for (int k = 0; k < count; k++) {
        pinch_v3_copy(d, x[k]);
        if (face->which) {
            double from[3];
            pinch_v3_sub(x[k], face->pair->p, from);
            pinch_pair_turn_back(face->pair, from, d);
        }
        if (fabs(d[j]) > most_j || fabs(d[l]) > most_l) return false;
    }
    return true;
}

int pinch_clip_to_face(const pinch_flat_face *face, double x[PINCH_TOUCHES][3], int count, bool *whole)
{
    window w;
    *whole = true;
    if (pinch_core_is_round(face->core)) {
        double radius = face->core->radius + face->slack, most = 0;
        for (int k = 0; k < count; k++) {
            double d[3];
            pinch_v3_sub(x[k], face->centre, d);
            pinch_v3_make_perpendicular(d, face->n);
            double out2 = pinch_v3_dot(d, d);
            if (out2 > most) most = out2;
        }
        if (most <= radius * radius) return count;
        window_of_disc(face, radius, x, count, &w);
    } else {
        if (face->core->kind == PINCH_CORE_BOX && over_box(face, x, count)) return count;
        window_of_polygon(face->part, face->n, face->slack, &w);
    }
    return clip(&w, x, count, whole);
}
