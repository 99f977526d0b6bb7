/* Pairs of bodies: canonical order, one frame, contact points in the world. */
#include "collide.h"

#include "collision/manifold/contact_points.h"
#include "collision/penetration/penetration.h"
#include "support/vec3.h"

#include <math.h>

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

/* Where b is in a's axes, beside where a is in b's; how b is turned, beside how a is: as long as one of these tells
 * them apart, moving both does not change their order. */
static int compare_places(const pinch_tip_body *a, const pinch_tip_body *b, double size)
{
    static const double TIE = 1e-9;
    double to_b[3], p[6], q[6];
    pinch_v3_sub(b->position, a->position, to_b);
    for (int i = 0; i < 3; i++) {
        int j = i < 2 ? 0 : 1, k = i < 1 ? 1 : 2;
        p[i] = (a->R[i] * to_b[0] + a->R[3 + i] * to_b[1] + a->R[6 + i] * to_b[2]) / size;
        q[i] = -(b->R[i] * to_b[0] + b->R[3 + i] * to_b[1] + b->R[6 + i] * to_b[2]) / size;
        p[3 + i] = a->R[j] * b->R[k] + a->R[3 + j] * b->R[3 + k] + a->R[6 + j] * b->R[6 + k];
        q[3 + i] = a->R[k] * b->R[j] + a->R[3 + k] * b->R[3 + j] + a->R[6 + k] * b->R[6 + j];
    }
    for (int i = 0; i < 6; i++)
        if (fabs(p[i] - q[i]) > TIE) return p[i] < q[i] ? -1 : 1;
    return 0;
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
    if (!order) order = compare_places(a, b, x->bound);
    if (!order) order = sign_of_difference(a->position, b->position, 3);
    return order ? order : sign_of_difference(a->R, b->R, 9);
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

/* What two cores have between them: the points in the axes of one of the bodies, the normal in the world. */
typedef struct between {
    const pinch_tip_body *frame;
    double normal[3];
    pinch_touch points[PINCH_TOUCHES];
    int count;
} between;

static bool look_between(const pinch_tip_body *a, const pinch_core *core_a, const pinch_tip_body *b,
                         const pinch_core *core_b, between *found)
{
    double apart[3], reach = core_a->bound + core_b->bound;
    pinch_v3_sub(b->position, a->position, apart);
    if (pinch_v3_dot(apart, apart) > reach * reach) return false;

    bool swapped = compare(a, core_a, b, core_b) > 0;
    const pinch_tip_body *frame = swapped ? b : a;
    pinch_core_pair pair;
    pinch_contact_normal normal;
    pinch_least_face faces[2];
    if (swapped)
        pinch_pair_of(b, core_b, a, core_a, &pair);
    else
        pinch_pair_of(a, core_a, b, core_b, &pair);
    if (!pinch_find_normal(&pair, pinch_tip_counters(), &normal, faces)) return false;
    if (pair.a->kind == PINCH_CORE_TRIANGLE) face_the_front(&pair, true, &normal);
    if (pair.b->kind == PINCH_CORE_TRIANGLE) face_the_front(&pair, false, &normal);
    found->frame = frame;
    found->count = pinch_touch_points(&pair, &normal, faces, found->points);
    for (int i = 0; i < 3; i++) {
        double along = pinch_v3_dot(frame->R + 3 * i, normal.normal);
        found->normal[i] = swapped ? -along : along;
    }
    return true;
}

static void to_world(const pinch_tip_body *frame, const double *x, double *position)
{
    for (int i = 0; i < 3; i++) position[i] = frame->position[i] + pinch_v3_dot(frame->R + 3 * i, x);
}

void pinch_collide_cores(const pinch_tip_body *a, int piece_a, const pinch_tip_body *b, int piece_b,
                         pinch_tip_touches *touches)
{
    between found;
    if (!look_between(a, &a->cores[piece_a], b, &b->cores[piece_b], &found)) return;
    for (int k = 0; k < found.count && touches->count < PINCH_TOUCHES; k++) {
        pinch_tip_touch *to = &touches->item[touches->count++];
        to_world(found.frame, found.points[k].position, to->position);
        pinch_v3_copy(to->normal, found.normal);
        to->depth = found.points[k].depth;
        to->piece[0] = piece_a;
        to->piece[1] = piece_b;
    }
}

static int collide_single(const pinch_tip_body *a, const pinch_tip_body *b, int room, dContactGeom *contacts, int skip)
{
    between found;
    int chosen[PINCH_TOUCHES];
    if (!look_between(a, a->cores, b, b->cores, &found)) return 0;
    int count = pinch_choose_touches(found.points, found.count, room, chosen);
    for (int k = 0; k < count; k++) {
        const pinch_touch *from = &found.points[chosen[k]];
        double position[3];
        to_world(found.frame, from->position, position);
        pinch_write_contact(position, found.normal, from->depth, a->geom, b->geom, pinch_contact_at(contacts, k, skip));
    }
    return count;
}

/* All pieces of two bodies, in an order that does not depend on which is named first. */
static void collide_pieces(const pinch_tip_body *a, const pinch_tip_body *b, pinch_tip_touches *touches)
{
    touches->count = 0;
    for (int i = 0; i < a->core_count; i++)
        for (int j = 0; j < b->core_count; j++) pinch_collide_cores(a, i, b, j, touches);
    if (a->core_count > 1) pinch_drop_seams(a, 0, touches);
    if (b->core_count > 1) pinch_drop_seams(b, 1, touches);
}

int pinch_collide_bodies(const pinch_tip_body *a, const pinch_tip_body *b, int room, dContactGeom *contacts, int skip)
{
    pinch_tip_touches touches;
    if (a->core_count == 1 && b->core_count == 1) return collide_single(a, b, room, contacts, skip);
    int order = a->core_count - b->core_count;
    if (order == 0) order = compare(a, a->cores, b, b->cores);
    collide_pieces(order > 0 ? b : a, order > 0 ? a : b, &touches);
    for (int k = 0; k < touches.count && order > 0; k++) pinch_v3_scale(touches.item[k].normal, -1);
    return pinch_write_contacts(&touches, a->geom, b->geom, room, contacts, skip);
}
