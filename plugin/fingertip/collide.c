/* Pairs of bodies: canonical order, one frame, contact points in the world. */
#include "collide.h"

#include "choose.h"
#include "manifold_points.h"
#include "normal.h"
#include "seams.h"
#include "statistics.h"
#include "support/vec3.h"

static int sign_of_difference(const double *a, const double *b, int count)
{
    for (int i = 0; i < count; i++)
        if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
    return 0;
}

/* An order of cores that depends on their shapes alone, then of their poses. */
static int compare_hulls(const pinch_core_hull *a, const pinch_core_hull *b)
{
    const pinch_convex *x = &a->convex, *y = &b->convex;
    if (x->point_count != y->point_count) return x->point_count < y->point_count ? -1 : 1;
    return x->points == y->points ? 0 : sign_of_difference(x->points, y->points, 3 * (int)x->point_count);
}

static int compare(const pinch_tip_body *a, const pinch_core *x, const pinch_tip_body *b, const pinch_core *y)
{
    if (x->kind != y->kind) return x->kind < y->kind ? -1 : 1;
    int order = sign_of_difference(x->half, y->half, 3);
    if (!order) order = sign_of_difference(&x->radius, &y->radius, 1);
    if (!order) order = sign_of_difference(&x->skin, &y->skin, 1);
    if (!order) order = sign_of_difference(x->power, y->power, 2);
    if (!order && x->kind == PINCH_CORE_TRIANGLE) order = sign_of_difference(x->corner, y->corner, 9);
    if (!order && x->hull) order = compare_hulls(x->hull, y->hull);
    if (!order) order = sign_of_difference(a->position, b->position, 3);
    return order ? order : sign_of_difference(a->R, b->R, 9);
}

/* Points and normal in the world. */
static void emit(const pinch_tip_body *frame, const pinch_contact_normal *found, bool swapped,
                 const pinch_touch *points, int count, int room, const int piece[2], pinch_tip_touches *touches)
{
    double normal[3];
    int chosen[PINCH_TOUCHES];
    count = pinch_choose_touches(points, count, room, chosen);
    for (int i = 0; i < 3; i++) normal[i] = pinch_v3_dot(frame->R + 3 * i, found->normal);
    if (swapped) pinch_v3_scale(normal, -1);
    for (int k = 0; k < count && touches->count < PINCH_TOUCHES; k++) {
        const pinch_touch *from = &points[chosen[k]];
        pinch_tip_touch *to = &touches->item[touches->count++];
        for (int i = 0; i < 3; i++)
            to->position[i] = frame->position[i] + pinch_v3_dot(frame->R + 3 * i, from->position);
        pinch_v3_copy(to->normal, normal);
        to->depth = from->depth;
        to->piece[0] = piece[0];
        to->piece[1] = piece[1];
    }
}

/* A triangle's side counts: no normal leads to its back. */
static void face_the_front(const pinch_core_pair *pair, bool triangle_first, pinch_contact_normal *found)
{
    double axes[3][3], front[3], turned[3];
    const pinch_core *triangle = triangle_first ? pair->a : pair->b;
    if (!pinch_core_axes(triangle, axes)) return;
    pinch_v3_copy(front, axes[0]); /* into the other body */
    if (triangle_first) {
        pinch_v3_scale(front, -1);
    } else {
        pinch_pair_turn(pair, front, turned);
        pinch_v3_copy(front, turned);
    }
    if (pinch_v3_dot(found->normal, front) > 1e-6) return;
    pinch_v3_copy(found->normal, front);
    found->overlap = pinch_pair_overlap(pair, front);
}

void pinch_collide_cores(const pinch_tip_body *a, int piece_a, const pinch_tip_body *b, int piece_b, int room,
                         pinch_tip_touches *touches)
{
    const pinch_core *core_a = &a->cores[piece_a], *core_b = &b->cores[piece_b];
    double between[3], reach = core_a->bound + core_b->bound;
    pinch_v3_sub(b->position, a->position, between);
    if (pinch_v3_dot(between, between) > reach * reach) return;

    bool swapped = compare(a, core_a, b, core_b) > 0;
    const pinch_tip_body *frame = swapped ? b : a;
    pinch_core_pair pair;
    pinch_contact_normal found;
    pinch_least_face faces[2];
    pinch_touch points[PINCH_TOUCHES];
    if (swapped)
        pinch_pair_of(b, core_b, a, core_a, &pair);
    else
        pinch_pair_of(a, core_a, b, core_b, &pair);
    if (!pinch_find_normal(&pair, pinch_tip_counters(), &found, faces)) return;
    if (pair.a->kind == PINCH_CORE_TRIANGLE) face_the_front(&pair, true, &found);
    if (pair.b->kind == PINCH_CORE_TRIANGLE) face_the_front(&pair, false, &found);
    int count = pinch_touch_points(&pair, &found, faces, points);
    emit(frame, &found, swapped, points, count, room, (const int[2]){piece_a, piece_b}, touches);
}

void pinch_collide_bodies(const pinch_tip_body *a, const pinch_tip_body *b, int room, pinch_tip_touches *touches)
{
    int each = a->core_count == 1 && b->core_count == 1 ? room : PINCH_TOUCHES;
    for (int i = 0; i < a->core_count; i++)
        for (int j = 0; j < b->core_count; j++) pinch_collide_cores(a, i, b, j, each, touches);
    if (a->core_count > 1) pinch_drop_seams(a, 0, touches);
    if (b->core_count > 1) pinch_drop_seams(b, 1, touches);
}
