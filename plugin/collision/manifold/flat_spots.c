#include "flat_spots.h"

#include "clip.h"
#include "pressed.h"

#include "support/vec3.h"

#include <math.h>

/* A face or side that is steeper than this (cosine) is not what presses. */
static const double STEEP = 0.7;

/* The superellipsoid is core `which` of the pair; what presses is the other one's. */
typedef struct pad {
    const pinch_core_pair *pair;
    int which;
    const pinch_core_part *part;
    pinch_flat_face face;
} pad;

/* From the axes of core `which` to A's, and back. */
static void turn_to_a(const pad *p, const double *v, double *out)
{
    if (p->which)
        pinch_pair_turn(p->pair, v, out);
    else
        pinch_v3_copy(out, v);
}

static void turn_from_a(const pad *p, const double *v, double *out)
{
    if (p->which)
        pinch_pair_turn_back(p->pair, v, out);
    else
        pinch_v3_copy(out, v);
}

static void point_to_a(const pad *p, const double *x, double *out)
{
    turn_to_a(p, x, out);
    if (p->which) pinch_v3_add_scaled(out, 1, p->pair->p);
}

static void point_from_a(const pad *p, const double *x, double *out)
{
    double from[3];
    pinch_v3_copy(from, x);
    if (p->which) pinch_v3_sub(x, p->pair->p, from);
    turn_from_a(p, from, out);
}

static void bound_by_face(const void *data, const double *r, const double *t, double *low, double *high)
{
    const pad *p = data;
    double far = 2 * (p->pair->a->bound + p->pair->b->bound), x[PINCH_TOUCHES][3], from[3], along[3];
    bool whole;
    point_to_a(p, r, from);
    turn_to_a(p, t, along);
    for (int end = 0; end < 2; end++) {
        pinch_v3_copy(x[end], from);
        pinch_v3_add_scaled(x[end], end ? far : -far, along);
    }
    *low = *high = 0;
    if (pinch_clip_to_face(&p->face, x, 2, NULL, &whole) != 2) return;
    *low = pinch_v3_dot(along, x[0]) - pinch_v3_dot(along, from);
    *high = pinch_v3_dot(along, x[1]) - pinch_v3_dot(along, from);
}

/* What presses, in A's axes: the other core's face or line that comes nearest to facing `out`. */
static void find_part(const pad *p, const double *out, pinch_core_part *part)
{
    double d[3], x[3];
    pinch_v3_copy(d, out);
    if (!p->which) pinch_pair_turn_back(p->pair, out, d);
    pinch_core_part_at(p->which ? p->pair->a : p->pair->b, d, false, part);
    for (int k = 0; k < part->count && !p->which; k++) {
        pinch_pair_turn(p->pair, part->x[k], x);
        for (int i = 0; i < 3; i++) part->x[k][i] = x[i] + p->pair->p[i];
    }
}

/* The face's normal, on the side of `out`. */
static void normal_of(const pinch_core_part *part, const double *out, double *f)
{
    double c[3];
    pinch_v3_set(f, 0, 0, 0);
    for (int k = 1; k + 1 < part->count; k++) {
        double u[3], v[3];
        pinch_v3_sub(part->x[k], part->x[0], u);
        pinch_v3_sub(part->x[k + 1], part->x[0], v);
        pinch_v3_cross(u, v, c);
        pinch_v3_add_scaled(f, 1, c);
    }
    double length = pinch_v3_norm(f);
    if (length > 0) pinch_v3_scale(f, (pinch_v3_dot(f, out) < 0 ? -1 : 1) / length);
}

/* Of the part's corners the one that reaches farthest along `out`. */
static const double *highest_of(const pinch_core_part *part, const double *out)
{
    int best = 0;
    for (int k = 1; k < part->count; k++)
        if (pinch_v3_dot(part->x[k], out) > pinch_v3_dot(part->x[best], out)) best = k;
    return part->x[best];
}

/* `out` leads out of the face, at right angles to the plane. */
static int by_face(pad *p, const double *n, const double *out, pinch_pressed *pressed, double x[PINCH_TOUCHES][3])
{
    double f[3], points[4][3];
    bool whole;
    normal_of(p->part, out, f);
    double cosine = pinch_v3_dot(f, out);
    if (!(cosine > STEEP)) return 0;
    pinch_v3_make_perpendicular(f, out);
    pinch_v3_scale(f, 1 / cosine);
    turn_from_a(p, f, pressed->slope);
    point_from_a(p, highest_of(p->part, out), pressed->highest);
    p->face = pinch_face_of(p->pair, !p->which, p->part, n);
    pinch_pressed_points(pressed, bound_by_face, p, points);
    for (int k = 0; k < 4; k++) point_to_a(p, points[k], x[k]);
    return pinch_clip_to_face(&p->face, x, 4, NULL, &whole);
}

static int by_line(const pad *p, const double *out, pinch_pressed *pressed, double x[PINCH_TOUCHES][3])
{
    double u[3], end[3], from[3], r[3], points[2][3];
    pinch_v3_sub(p->part->x[1], p->part->x[0], u);
    double length = pinch_v3_norm(u), rise = pinch_v3_dot(u, out);
    pinch_v3_make_perpendicular(u, out);
    double flat = pinch_v3_norm(u);
    if (!(flat > STEEP * length)) return 0;
    pinch_v3_scale(u, 1 / flat);
    turn_from_a(p, u, pressed->t[0]);
    pinch_v3_copy(pressed->slope, pressed->t[0]);
    pinch_v3_scale(pressed->slope, -rise / flat);
    point_from_a(p, highest_of(p->part, out), pressed->highest);
    point_from_a(p, p->part->x[0], end);
    pinch_v3_sub(pressed->x, end, from);
    double along = pinch_v3_dot(from, pressed->t[0]);
    pinch_v3_copy(r, end); /* over the line, and in the plane */
    pinch_v3_add_scaled(r, along, pressed->t[0]);
    pinch_v3_add_scaled(r, pinch_v3_dot(pressed->x, pressed->d) - pinch_v3_dot(r, pressed->d), pressed->d);
    pinch_pressed_line(pressed, r, -along, flat - along, points);
    for (int k = 0; k < 2; k++) point_to_a(p, points[k], x[k]);
    return 2;
}

int pinch_touch_flat_spot(const pinch_core_pair *pair, const pinch_contact_normal *normal, pinch_touch *touches)
{
    if (pair->a->kind != PINCH_CORE_SUPERELLIPSOID && pair->b->kind != PINCH_CORE_SUPERELLIPSOID) return 0;
    const double *n = normal->normal, out_of_a[3] = {-n[0], -n[1], -n[2]};
    double depth = normal->overlap + pair->a->skin + pair->b->skin, d[3], x[PINCH_TOUCHES][3];
    pinch_pressed pressed;
    pinch_core_part part;
    for (int which = 0; which < 2; which++) {
        pad p = {.pair = pair, .which = which, .part = &part};
        turn_from_a(&p, which ? n : out_of_a, d);
        if (!pinch_press(which ? pair->b : pair->a, d, depth, &pressed)) continue;
        const double *out = which ? out_of_a : n; /* of the one that presses */
        find_part(&p, out, &part);
        int count = part.face ? by_face(&p, n, out, &pressed, x) : part.count == 2 ? by_line(&p, out, &pressed, x) : 0;
        for (int k = 0; k < count; k++) { /* half way through the overlap: back out of the pad */
            pinch_v3_copy(touches[k].position, x[k]);
            pinch_v3_add_scaled(touches[k].position, 0.5 * depth, out);
            touches[k].depth = depth;
        }
        return count;
    }
    return 0;
}
