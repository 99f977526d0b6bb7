/* Pairs of bodies: canonical order, one frame, contact points in the world. */
#include "body.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

void pinch_pair_of(const pinch_tip_body *a, const pinch_core *core_a, const pinch_tip_body *b, const pinch_core *core_b,
                   pinch_core_pair *pair)
{
    double from[3];
    pair->a = core_a;
    pair->b = core_b;
    pinch_v3_sub(b->position, a->position, from);
    for (int i = 0; i < 3; i++) {
        pair->p[i] = a->R[i] * from[0] + a->R[3 + i] * from[1] + a->R[6 + i] * from[2];
        for (int j = 0; j < 3; j++)
            pair->R[3 * i + j] = a->R[i] * b->R[j] + a->R[3 + i] * b->R[3 + j] + a->R[6 + i] * b->R[6 + j];
    }
}

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

static void emit(const pinch_tip_body *frame, const pinch_contact_normal *found, bool swapped, const pinch_touch *from,
                 int piece_a, int piece_b, pinch_tip_touches *touches)
{
    if (touches->count == PINCH_TOUCHES) return;
    pinch_tip_touch *to = &touches->item[touches->count++];
    for (int i = 0; i < 3; i++) {
        to->position[i] = frame->position[i] + pinch_v3_dot(frame->R + 3 * i, from->position);
        to->normal[i] = pinch_v3_dot(frame->R + 3 * i, found->normal);
        if (swapped) to->normal[i] = -to->normal[i];
    }
    to->depth = from->depth;
    to->piece[0] = piece_a;
    to->piece[1] = piece_b;
}

/* A triangle's side counts: no normal leads to its back. */
static void face_the_front(const pinch_core_pair *pair, bool triangle_first, pinch_contact_normal *found)
{
    double axes[3][3], front[3], turned[3];
    const pinch_core *triangle = triangle_first ? pair->a : pair->b;
    if (triangle->kind != PINCH_CORE_TRIANGLE || !pinch_core_axes(triangle, axes)) return;
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

void pinch_collide_cores(const pinch_tip_body *a, int piece_a, const pinch_tip_body *b, int piece_b,
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
    pinch_touch points[PINCH_TOUCHES];
    if (swapped)
        pinch_pair_of(b, core_b, a, core_a, &pair);
    else
        pinch_pair_of(a, core_a, b, core_b, &pair);
    if (!pinch_find_normal(&pair, pinch_tip_counters(), &found)) return;
    face_the_front(&pair, true, &found);
    face_the_front(&pair, false, &found);
    int count = pinch_touch_points(&pair, &found, points);
    for (int k = 0; k < count; k++) emit(frame, &found, swapped, &points[k], piece_a, piece_b, touches);
}

/* The same point twice, from two pieces that share an edge. */
static void drop_doubles(double size, pinch_tip_touches *touches)
{
    int kept = 0;
    for (int k = 0; k < touches->count; k++) {
        const pinch_tip_touch *t = &touches->item[k];
        bool twice = false;
        for (int i = 0; i < kept && !twice; i++) {
            double d[3];
            const pinch_tip_touch *other = &touches->item[i];
            pinch_v3_sub(t->position, other->position, d);
            twice = pinch_v3_norm(d) < 1e-6 * size && pinch_v3_dot(t->normal, other->normal) > 1 - 1e-6;
        }
        if (!twice) touches->item[kept++] = *t;
    }
    touches->count = kept;
}

/*
 * Where convex pieces of one body meet, each piece has faces and edges that the body has not. A contact is the body's
 * own only if its point on the piece is not part of another piece that the other body is pressed into deeper.
 */
void pinch_drop_seams(const pinch_tip_body *body, int which, pinch_tip_touches *touches)
{
    bool ghost[PINCH_TOUCHES];
    double size = 0;
    for (int k = 0; k < touches->count; k++) size = fmax(size, body->cores[touches->item[k].piece[which]].bound);
    for (int k = 0; k < touches->count; k++) {
        const pinch_tip_touch *t = &touches->item[k];
        double witness[3], normal[3];
        pinch_v3_copy(witness, t->position);
        pinch_v3_add_scaled(witness, which ? 0.5 * t->depth : -0.5 * t->depth, t->normal);
        ghost[k] = false;
        for (int i = 0; i < touches->count && !ghost[k]; i++) {
            const pinch_tip_touch *other = &touches->item[i];
            if (other->piece[which] == t->piece[which] || pinch_v3_dot(other->normal, t->normal) > 1 - 1e-9) continue;
            if (other->depth < t->depth * (1 - 1e-9)) continue;
            ghost[k] = pinch_body_distance(body, other->piece[which], witness, normal) < 1e-7 * size;
        }
    }
    int kept = 0;
    for (int k = 0; k < touches->count; k++)
        if (!ghost[k]) touches->item[kept++] = touches->item[k];
    touches->count = kept;
    drop_doubles(size, touches);
}

void pinch_collide_bodies(const pinch_tip_body *a, const pinch_tip_body *b, pinch_tip_touches *touches)
{
    for (int i = 0; i < a->core_count; i++)
        for (int j = 0; j < b->core_count; j++) pinch_collide_cores(a, i, b, j, touches);
    if (a->core_count > 1) pinch_drop_seams(a, 0, touches);
    if (b->core_count > 1) pinch_drop_seams(b, 1, touches);
}

/* More than there is room for: the deepest, then always the one farthest from those already chosen. */
static void choose(const pinch_tip_touches *touches, int room, int *chosen)
{
    double far[PINCH_TOUCHES];
    int next = 0;
    for (int k = 0; k < touches->count; k++) {
        far[k] = INFINITY;
        if (touches->item[k].depth > touches->item[next].depth) next = k;
    }
    for (int n = 0; n < room; n++) {
        chosen[n] = next;
        far[next] = -1;
        int best = -1;
        for (int k = 0; k < touches->count; k++) {
            double d[3];
            if (far[k] < 0) continue;
            pinch_v3_sub(touches->item[k].position, touches->item[chosen[n]].position, d);
            far[k] = fmin(far[k], pinch_v3_dot(d, d));
            if (best < 0 || far[k] > far[best]) best = k;
        }
        next = best < 0 ? next : best;
    }
}

int pinch_write_contacts(const pinch_tip_touches *touches, dGeomID g1, dGeomID g2, int room, dContactGeom *contacts,
                         int skip)
{
    int chosen[PINCH_TOUCHES], count = touches->count;
    for (int k = 0; k < count; k++) chosen[k] = k;
    if (count > room) {
        choose(touches, room, chosen);
        count = room;
    }
    for (int k = 0; k < count; k++) {
        const pinch_tip_touch *t = &touches->item[chosen[k]];
        dContactGeom *c = (dContactGeom *)(void *)((char *)contacts + (size_t)k * (size_t)skip);
        pinch_v3_copy(c->pos, t->position);
        pinch_v3_copy(c->normal, t->normal);
        c->pos[3] = c->normal[3] = 0;
        c->depth = t->depth;
        c->g1 = g1;
        c->g2 = g2;
        c->side1 = c->side2 = -1;
    }
    return count;
}
