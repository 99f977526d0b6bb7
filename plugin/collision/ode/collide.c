/* Pairs of bodies: they come in a canonical order, are collided in one body's axes, and get contact points in the
 * world. */
#include "collide.h"

#include "collision/manifold/contact_points.h"
#include "collision/penetration/penetration.h"
#include "support/vec3.h"
#include "write_contacts.h"

#include <math.h>

static int sign_of_difference(const double *a, const double *b, int count)
{
    for (int i = 0; i < count; i++)
        if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
    return 0;
}

/* The order of two shapes depends on the shapes alone, and on their poses only if the shapes are equal. */
static int compare_hulls(const pinch_hull *a, const pinch_hull *b)
{
    const pinch_convex *x = &a->convex, *y = &b->convex;
    if (x->point_count != y->point_count) return x->point_count < y->point_count ? -1 : 1;
    return x->points == y->points ? 0 : sign_of_difference(x->points, y->points, 3 * (int)x->point_count);
}

/* Compares where b is in a's axes with where a is in b's, and likewise the rotations. As long as these differ, moving
 * both bodies together does not change their order. */
static int compare_places(const pinch_posed_body *a, const pinch_posed_body *b, double size)
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

static int compare(const pinch_posed_body *a, const pinch_shape *x, const pinch_posed_body *b, const pinch_shape *y)
{
    if (x->kind != y->kind) return x->kind < y->kind ? -1 : 1;
    int order = sign_of_difference(x->half, y->half, 3);
    if (!order) order = sign_of_difference(&x->radius, &y->radius, 1);
    if (!order) order = sign_of_difference(&x->margin, &y->margin, 1);
    if (!order) order = sign_of_difference(x->power, y->power, 2);
    if (!order && x->kind == PINCH_SHAPE_TRIANGLE) order = sign_of_difference(x->corner, y->corner, 9);
    if (!order && x->hull) order = compare_hulls(x->hull, y->hull);
    if (!order) order = compare_places(a, b, x->bound);
    if (!order) order = sign_of_difference(a->position, b->position, 3);
    return order ? order : sign_of_difference(a->R, b->R, 9);
}

/* Only the front of a triangle counts, so no normal may lead to its back. */
static void flip_to_front(const pinch_shape_pair *pair, bool triangle_first, pinch_contact_normal *found)
{
    double axes[3][3], front[3], rotated[3];
    const pinch_shape *triangle = triangle_first ? pair->a : pair->b;
    if (!pinch_shape_axes(triangle, axes)) return;
    pinch_v3_copy(front, axes[0]); /* into the other body */
    if (triangle_first) {
        pinch_v3_scale(front, -1);
    } else {
        pinch_pair_rotate(pair, front, rotated);
        pinch_v3_copy(front, rotated);
    }
    if (pinch_v3_dot(found->normal, front) > 1e-6) return;
    pinch_v3_copy(found->normal, front);
    found->overlap = pinch_pair_overlap(pair, front);
}

/* The contact of two shapes: the points are in the axes of one of the bodies, the normal is in the world's. */
typedef struct shape_contact {
    const pinch_posed_body *frame;
    double normal[3];
    pinch_contact_point points[PINCH_MAX_CONTACT_POINTS];
    int count;
} shape_contact;

static bool contact_of_shapes(const pinch_posed_body *a, const pinch_shape *shape_a, const pinch_posed_body *b,
                              const pinch_shape *shape_b, shape_contact *found)
{
    double apart[3], extent = shape_a->bound + shape_b->bound;
    pinch_v3_sub(b->position, a->position, apart);
    if (pinch_v3_dot(apart, apart) > extent * extent) return false;

    bool swapped = compare(a, shape_a, b, shape_b) > 0;
    const pinch_posed_body *frame = swapped ? b : a;
    pinch_shape_pair pair;
    pinch_contact_normal normal;
    pinch_least_face faces[2];
    if (swapped)
        pinch_pair_of(b, shape_b, a, shape_a, &pair);
    else
        pinch_pair_of(a, shape_a, b, shape_b, &pair);
    if (!pinch_find_contact_normal(&pair, &normal, faces)) return false;
    if (pair.a->kind == PINCH_SHAPE_TRIANGLE) flip_to_front(&pair, true, &normal);
    if (pair.b->kind == PINCH_SHAPE_TRIANGLE) flip_to_front(&pair, false, &normal);
    found->frame = frame;
    found->count = pinch_contact_points(&pair, &normal, faces, found->points);
    for (int i = 0; i < 3; i++) {
        double along = pinch_v3_dot(frame->R + 3 * i, normal.normal);
        found->normal[i] = swapped ? -along : along;
    }
    return true;
}

static void to_world(const pinch_posed_body *frame, const double *x, double *position)
{
    for (int i = 0; i < 3; i++) position[i] = frame->position[i] + pinch_v3_dot(frame->R + 3 * i, x);
}

void pinch_collide_pieces(const pinch_posed_body *a, int piece_a, const pinch_posed_body *b, int piece_b,
                          pinch_body_contacts *list)
{
    shape_contact found;
    if (!contact_of_shapes(a, &a->shapes[piece_a], b, &b->shapes[piece_b], &found)) return;
    for (int k = 0; k < found.count && list->count < PINCH_MAX_CONTACT_POINTS; k++) {
        pinch_body_contact *to = &list->item[list->count++];
        to_world(found.frame, found.points[k].position, to->position);
        pinch_v3_copy(to->normal, found.normal);
        to->depth = found.points[k].depth;
        to->piece[0] = piece_a;
        to->piece[1] = piece_b;
    }
}

static int collide_single(const pinch_posed_body *a, const pinch_posed_body *b, int room, dContactGeom *contacts,
                          int skip)
{
    shape_contact found;
    int chosen[PINCH_MAX_CONTACT_POINTS];
    if (!contact_of_shapes(a, a->shapes, b, b->shapes, &found)) return 0;
    int count = pinch_choose_contact_points(found.points, found.count, room, chosen);
    for (int k = 0; k < count; k++) {
        const pinch_contact_point *from = &found.points[chosen[k]];
        double position[3];
        to_world(found.frame, from->position, position);
        pinch_write_contact(position, found.normal, from->depth, a->geom, b->geom, pinch_contact_at(contacts, k, skip));
    }
    return count;
}

/* Collides all pieces of two bodies, in an order that does not depend on which is named first. */
static void collide_all_pieces(const pinch_posed_body *a, const pinch_posed_body *b, pinch_body_contacts *list)
{
    list->count = 0;
    for (int i = 0; i < a->shape_count; i++)
        for (int j = 0; j < b->shape_count; j++) pinch_collide_pieces(a, i, b, j, list);
    if (a->shape_count > 1) pinch_drop_internal_edges(a, 0, list);
    if (b->shape_count > 1) pinch_drop_internal_edges(b, 1, list);
}

int pinch_collide_bodies(const pinch_posed_body *a, const pinch_posed_body *b, int room, dContactGeom *contacts,
                         int skip)
{
    pinch_body_contacts list;
    if (a->shape_count == 1 && b->shape_count == 1) return collide_single(a, b, room, contacts, skip);
    int order = a->shape_count - b->shape_count;
    if (order == 0) order = compare(a, a->shapes, b, b->shapes);
    collide_all_pieces(order > 0 ? b : a, order > 0 ? a : b, &list);
    for (int k = 0; k < list.count && order > 0; k++) pinch_v3_scale(list.item[k].normal, -1);
    return pinch_write_contacts(&list, a->geom, b->geom, room, contacts, skip);
}
