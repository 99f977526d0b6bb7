#include "clip.h"

#include "support/vec3.h"

#include <math.h>

enum { SIDES = 32 };

/* A window is a face to clip against. Points x inside have side[k].x <= offset[k]. The sides have any length. */
typedef struct window {
    int count;
    double side[SIDES][3], offset[SIDES];
} window;

static void window_of_polygon(const pinch_feature *face, const double *normal, double slack, window *w)
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
        double extent = fabs(side[0]) + fabs(side[1]) + fabs(side[2]);
        w->offset[w->count++] = offset + slack * extent; /* at least the slack to the outside */
    }
}

/* Rotates from A's axes to those of the shape that has the face. */
static void rotate_to_owner(const pinch_flat_face *face, const double *v, double *local)
{
    if (face->which)
        pinch_pair_rotate_back(face->pair, v, local);
    else
        pinch_v3_copy(local, v);
}

/* Finds a ball around the points, or around the face to which they belong. Its centre is in the axes of the shape that
 * has the face to clip against. Returns its radius. */
static double ball_around(const pinch_flat_face *face, double x[PINCH_MAX_CONTACT_POINTS][3], int count,
                          const pinch_feature *whole, double *centre)
{
    double middle[3] = {0, 0, 0}, far2 = 0, part = 1.0 / count, d[3];
    bool known = whole && whole->face && whole->radius >= 0;
    if (known) pinch_v3_copy(middle, whole->centre);
    for (int k = 0; k < count && !known; k++) pinch_v3_add_scaled(middle, part, x[k]);
    for (int k = 0; k < count && !known; k++) {
        pinch_v3_sub(x[k], middle, d);
        double length2 = pinch_v3_dot(d, d);
        if (length2 > far2) far2 = length2;
    }
    if (face->which) pinch_v3_sub(middle, face->pair->p, middle);
    rotate_to_owner(face, middle, centre);
    return known ? whole->radius : sqrt(far2);
}

/* Adds a side that is given in the shape's axes. */
static void add_side(const pinch_flat_face *face, const double *side, double offset, window *w)
{
    double *to = w->side[w->count];
    if (face->which) {
        pinch_pair_rotate(face->pair, side, to);
        offset += pinch_v3_dot(to, face->pair->p);
    } else {
        pinch_v3_copy(to, side);
    }
    w->offset[w->count++] = offset + face->slack;
}

/* Takes only those sides of a hull's face beyond which points of the ball may lie. */
static void window_of_hull(const pinch_flat_face *face, const double *centre, double radius, window *w)
{
    const pinch_hull_face *of = &face->shape->hull->faces[face->part->index];
    const double *side = of->sides;
    w->count = 0;
    for (unsigned k = 0; k < of->polygon[0]; k++, side += 4)
        if (pinch_v3_dot(side, centre) + radius > side[3]) add_side(face, side, side[3], w);
}

static void window_of_box(const pinch_flat_face *face, int axis, const double *centre, double radius, window *w)
{
    const double *half = face->shape->half;
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

enum { ROOM = PINCH_MAX_CONTACT_POINTS + 2 };

typedef struct corner {
    double x[3];
} corner;

/* The outline of a polygon, segment or point. */
typedef struct outline {
    int count;
    corner *corners, *spare; /* each has room for ROOM */
} outline;

static void cross(const corner *p, const corner *q, double out_p, double out_q, corner *at)
{
    double t = out_p / (out_p - out_q);
    t = t > 0 ? t : 0; /* corners that are hardly outside count as inside */
    t = t < 1 ? t : 1;
    for (int i = 0; i < 3; i++) at->x[i] = p->x[i] + t * (q->x[i] - p->x[i]);
}

static void cut_segment(outline *o, const double *out)
{
    int outer = out[0] > 0 ? 0 : 1;
    corner *c = o->corners;
    if (o->count == 2 && !(out[!outer] > 0))
        cross(&c[!outer], &c[outer], out[!outer], out[outer], &c[outer]);
    else
        o->count = 0;
}

/* Sutherland and Hodgman's clipping. out[k] is how far corner k is outside. What is left of a convex polygon is one run
 * of corners with a crossing at either end. */
static void cut(outline *o, const double *out)
{
    const int count = o->count;
    if (count < 3) {
        cut_segment(o, out);
        return;
    }
    int first = -1, end = -1; /* the first corner inside behind one outside; the first corner outside */
    for (int k = 0, before = out[count - 1] > 0; k < count; k++) {
        int outside = out[k] > 0;
        first = before > outside ? k : first;
        end = outside > before ? k : end;
        before = outside;
    }
    if (first < 0) {
        o->count = 0;
        return;
    }
    const corner *from = o->corners;
    corner *to = o->spare;
    int n = 1, last = end > 0 ? end - 1 : count - 1, outer = first > 0 ? first - 1 : count - 1;
    cross(&from[outer], &from[first], out[outer], out[first], &to[0]);
    for (int k = first; k != end && n < PINCH_MAX_CONTACT_POINTS - 1; k = k + 1 < count ? k + 1 : 0) to[n++] = from[k];
    cross(&from[last], &from[end], out[last], out[end], &to[n++]);
    o->count = n;
    o->spare = o->corners;
    o->corners = to;
}

/* `whole` becomes false where something is cut off. */
static void clip(const window *w, outline *o, bool *whole)
{
    for (int s = 0; s < w->count; s++) {
        double out[ROOM], most = 0, offset = w->offset[s], side[3];
        pinch_v3_copy(side, w->side[s]);
        for (int k = 0; k < o->count; k++) {
            out[k] = pinch_v3_dot(side, o->corners[k].x) - offset;
            most = out[k] > most ? out[k] : most;
        }
        if (!(most > 0)) continue;
        *whole = false;
        cut(o, out);
    }
}

/* Tells whether that face of a box or hull is square to d and has few enough sides. */
static bool is_square(const pinch_shape *shape, int index, const double *d)
{
    static const double SQUARE = 1 - 1e-12; /* cosine */
    if (shape->kind == PINCH_SHAPE_BOX) return fabs(d[0]) >= SQUARE || fabs(d[1]) >= SQUARE || fabs(d[2]) >= SQUARE;
    return shape->kind == PINCH_SHAPE_HULL && shape->hull->faces[index].polygon[0] <= SIDES &&
           fabs(pinch_v3_dot(shape->hull->convex.planes + 4 * index, d)) >= SQUARE;
}

pinch_flat_face pinch_flat_face_of(const pinch_shape_pair *pair, int which, const pinch_feature *part,
                                   const double n[3])
{
    const pinch_shape *shape = which ? pair->b : pair->a;
    pinch_flat_face face = {.pair = pair, .which = which, .shape = shape, .part = part, .slack = 1e-9 * shape->bound};
    pinch_v3_copy(face.n, n);
    rotate_to_owner(&face, n, face.d);
    face.simple = pinch_is_round(shape) || is_square(shape, part->index, face.d);
    return face;
}

static void window_of_square(const pinch_flat_face *face, const double *centre, double radius, window *w)
{
    if (face->shape->kind == PINCH_SHAPE_BOX)
        window_of_box(face, pinch_v3_main_axis(face->d), centre, radius, w);
    else
        window_of_hull(face, centre, radius, w);
}

int pinch_clip_to_face(const pinch_flat_face *face, double x[PINCH_MAX_CONTACT_POINTS][3], int count,
                       const pinch_feature *around, bool *whole)
{
    corner room[2][ROOM];
    outline o = {count, room[0], room[1]};
    window w;
    double centre[3];
    if (pinch_is_round(face->shape)) return pinch_clip_to_disc(face, x, count, around, whole);
    *whole = true;
    if (face->simple) {
        double radius = ball_around(face, x, count, around, centre);
        window_of_square(face, centre, radius, &w);
    } else {
        window_of_polygon(face->part, face->n, face->slack, &w);
    }
    if (w.count == 0) return count;
    for (int k = 0; k < count; k++) room[0][k] = (corner){{x[k][0], x[k][1], x[k][2]}};
    clip(&w, &o, whole);
    for (int k = 0; k < o.count && !*whole; k++) pinch_v3_copy(x[k], o.corners[k].x);
    return o.count;
}
