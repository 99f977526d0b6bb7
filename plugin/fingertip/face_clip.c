#include "face_clip.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

enum { REFERENCE_SIDES = 16, SIDES = 32 };

/* Cosines of sixteenths of a turn. */
#define C1 0.92387953251128676
#define C2 0.70710678118654752
#define C3 0.38268343236508977

/* A face to clip against: points x inside have side[k].x <= offset[k]. The sides are of any length. */
typedef struct window {
    int count;
    double side[SIDES][3], offset[SIDES];
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

/* From A's axes to those of the core that has the face. */
static void turn_to_owner(const pinch_flat_face *face, const double *v, double *local)
{
    if (face->which)
        pinch_pair_turn_back(face->pair, v, local);
    else
        pinch_v3_copy(local, v);
}

/* A ball around the points, its centre in the axes of the core that has the face. Returns its radius. */
static double ball_around(const pinch_flat_face *face, double x[PINCH_TOUCHES][3], int count, double *centre)
{
    double middle[3] = {0, 0, 0}, far2 = 0, part = 1.0 / count, d[3];
    for (int k = 0; k < count; k++) pinch_v3_add_scaled(middle, part, x[k]);
    for (int k = 0; k < count; k++) {
        pinch_v3_sub(x[k], middle, d);
        double length2 = pinch_v3_dot(d, d);
        if (length2 > far2) far2 = length2;
    }
    if (face->which) pinch_v3_sub(middle, face->pair->p, middle);
    turn_to_owner(face, middle, centre);
    return sqrt(far2);
}

/* A side in the core's axes. */
static void add_side(const pinch_flat_face *face, const double *side, double offset, window *w)
{
    double *to = w->side[w->count];
    if (face->which) {
        pinch_pair_turn(face->pair, side, to);
        offset += pinch_v3_dot(to, face->pair->p);
    } else {
        pinch_v3_copy(to, side);
    }
    w->offset[w->count++] = offset + face->slack;
}

/* The sides of a hull's face that points of the ball may be beyond. */
static void window_of_hull(const pinch_flat_face *face, const double *centre, double radius, window *w)
{
    const pinch_core_face *of = &face->core->hull->faces[face->part->index];
    const double *side = of->sides;
    w->count = 0;
    for (unsigned k = 0; k < of->polygon[0]; k++, side += 4)
        if (pinch_v3_dot(side, centre) + radius > side[3]) add_side(face, side, side[3], w);
}

static void window_of_box(const pinch_flat_face *face, int axis, const double *centre, double radius, window *w)
{
    const double *half = face->core->half;
    w->count = 0;
    for (int i = 0; i < 3; i++) {
        if (i == axis || fabs(centre[i]) + radius <= half[i]) continue;
        for (int sign = -1; sign <= 1; sign += 2) {
            double side[3] = {0, 0, 0};
            if (sign * centre[i] + radius <= half[i]) continue;
            side[i] = sign;
            add_side(face, side, half[i], w);
        }
    }
}

/* A round face: of the polygon around it, so that no point of the face is lost, the sides that some point is beyond,
 * seen along d, the normal in the core's axes. */
static void window_of_disc(const pinch_flat_face *face, const double *d, double x[PINCH_TOUCHES][3], int count,
                           window *w)
{
    static const double SIDE[REFERENCE_SIDES][2] = {{1, 0},    {C1, C3},   {C2, C2},   {C3, C1},
                                                    {0, 1},    {-C3, C1},  {-C2, C2},  {-C1, C3},
                                                    {-1, 0},   {-C1, -C3}, {-C2, -C2}, {-C3, -C1},
                                                    {0, -1},   {C3, -C1},  {C2, -C2},  {C1, -C3}};
    const pinch_core *core = face->core;
    double out[PINCH_TOUCHES][2], radius = core->radius + face->slack, tilt[2] = {d[0] / d[2], d[1] / d[2]};
    double height = core->middle + copysign(core->half[2], face->which ? d[2] : -d[2]);
    int outside = 0;
    w->count = 0;
    for (int k = 0; k < count; k++) {
        double from[3], local[3];
        pinch_v3_copy(from, x[k]);
        if (face->which) pinch_v3_sub(x[k], face->pair->p, from);
        turn_to_owner(face, from, local);
        double u = local[0] - tilt[0] * (local[2] - height), v = local[1] - tilt[1] * (local[2] - height);
        if (u * u + v * v <= radius * radius) continue;
        out[outside][0] = u;
        out[outside++][1] = v;
    }
    for (int k = 0; k < REFERENCE_SIDES && outside > 0; k++) {
        double c = SIDE[k][0], s = SIDE[k][1], up = -c * tilt[0] - s * tilt[1];
        int i = 0;
        while (i < outside && c * out[i][0] + s * out[i][1] <= radius) i++;
        if (i < outside) add_side(face, (const double[3]){c, s, up}, core->radius + up * height, w);
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
    return face;
}

/* Of a box' or hull's face that lies square to d, the normal in the core's axes. */
static bool window_of_square(const pinch_flat_face *face, const double *d, double x[PINCH_TOUCHES][3], int count,
                             window *w)
{
    static const double SQUARE = 1 - 1e-12; /* cosine */
    const pinch_core *core = face->core;
    double centre[3];
    if (core->kind == PINCH_CORE_BOX) {
        int axis = fabs(d[0]) > fabs(d[1]) ? 0 : 1;
        if (fabs(d[2]) > fabs(d[axis])) axis = 2;
        if (fabs(d[axis]) < SQUARE) return false;
        double radius = ball_around(face, x, count, centre);
        window_of_box(face, axis, centre, radius, w);
        return true;
    }
    if (core->kind != PINCH_CORE_HULL || core->hull->faces[face->part->index].polygon[0] > SIDES) return false;
    if (fabs(pinch_v3_dot(core->hull->convex.planes + 4 * face->part->index, d)) < SQUARE) return false;
    double radius = ball_around(face, x, count, centre);
    window_of_hull(face, centre, radius, w);
    return true;
}

int pinch_clip_to_face(const pinch_flat_face *face, double x[PINCH_TOUCHES][3], int count, bool *whole)
{
    window w;
    double d[3];
    *whole = true;
    turn_to_owner(face, face->n, d);
    if (pinch_core_is_round(face->core))
        window_of_disc(face, d, x, count, &w);
    else if (!window_of_square(face, d, x, count, &w))
        window_of_polygon(face->part, face->n, face->slack, &w);
    return clip(&w, x, count, whole);
}
