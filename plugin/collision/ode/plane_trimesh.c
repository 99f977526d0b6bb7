/* Bodies against planes and triangle meshes. */
#include "collide.h"

#include "collision/manifold/contact_points.h"
#include "collision/shape/convex_shape.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

static void to_world(const pinch_posed_body *body, const double *v, double *world)
{
    for (int i = 0; i < 3; i++) world[i] = pinch_v3_dot(body->R + 3 * i, v);
}

static void to_body(const pinch_posed_body *body, const double *v, double *local)
{
    for (int i = 0; i < 3; i++) local[i] = body->R[i] * v[0] + body->R[3 + i] * v[1] + body->R[6 + i] * v[2];
}

void pinch_collide_plane(const pinch_posed_body *body, dGeomID plane, pinch_body_contacts *list)
{
    dVector4 p;
    double n[3];
    pinch_contact_point points[PINCH_MAX_CONTACT_POINTS];
    dGeomPlaneGetParams(plane, p);
    to_body(body, p, n);
    double offset = p[3] - pinch_v3_dot(p, body->position);
    for (int k = 0; k < body->shape_count; k++) {
        int count = pinch_plane_contact_points(&body->shapes[k], n, offset, points);
        for (int i = 0; i < count && list->count < PINCH_MAX_CONTACT_POINTS; i++) {
            pinch_body_contact *t = &list->item[list->count++];
            to_world(body, points[i].position, t->position);
            pinch_v3_add_scaled(t->position, 1, body->position);
            pinch_v3_copy(t->normal, p);
            t->depth = points[i].depth;
            t->piece[0] = k;
            t->piece[1] = 0;
        }
    }
}

/* Tells whether all corners of the triangle are beyond one side of the box. */
static bool outside(const dReal box[6], const double corners[9])
{
    for (int i = 0; i < 3; i++) {
        double low = fmin(corners[i], fmin(corners[3 + i], corners[6 + i]));
        double high = fmax(corners[i], fmax(corners[3 + i], corners[6 + i]));
        if (low > box[2 * i + 1] || high < box[2 * i]) return true;
    }
    return false;
}

static void body_box(const pinch_posed_body *body, dReal box[6])
{
    for (int i = 0; i < 3; i++) {
        box[2 * i] = DBL_MAX;
        box[2 * i + 1] = -DBL_MAX;
        for (int k = 0; k < body->shape_count; k++) {
            const pinch_shape *shape = &body->shapes[k];
            const double *row = body->R + 3 * i, back[3] = {-row[0], -row[1], -row[2]};
            double high = body->position[i] + pinch_support_value(shape, row) + shape->margin;
            double low = body->position[i] - pinch_support_value(shape, back) - shape->margin;
            box[2 * i] = fmin(box[2 * i], low);
            box[2 * i + 1] = fmax(box[2 * i + 1], high);
        }
    }
}

/*
 * Every triangle is a shape of its own, about its first corner. It does not count from behind, where the body's middle
 * is behind its plane. At most TRIANGLES of one mesh touch at once, and the deepest are not preferred: a mesh that fine
 * is no ground for a fingertip. The cost grows with the number of triangles in the mesh, because all are looked at.
 */
void pinch_collide_trimesh(const pinch_posed_body *body, dGeomID mesh, pinch_body_contacts *list)
{
    enum { TRIANGLES = 32 };
    pinch_shape shapes[TRIANGLES];
    pinch_posed_body triangles = {.geom = mesh, .shapes = shapes, .R = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    const double *origin = dGeomGetPosition(mesh);
    dReal box[6];
    body_box(body, box);
    pinch_v3_copy(triangles.position, origin);
    for (int t = 0, n = dGeomTriMeshGetTriangleCount(mesh); t < n && triangles.shape_count < TRIANGLES; t++) {
        dVector3 v[3];
        double corners[9], axes[3][3], to[3];
        dGeomTriMeshGetTriangle(mesh, t, &v[0], &v[1], &v[2]);
        for (int k = 0; k < 3; k++) pinch_v3_copy(corners + 3 * k, v[k]);
        if (outside(box, corners)) continue;
        pinch_v3_sub(body->position, corners, to);
        for (int k = 0; k < 9; k++) corners[k] -= origin[k % 3];
        pinch_shape *shape = &shapes[triangles.shape_count];
        *shape = pinch_shape_of_triangle(corners);
        if (!pinch_shape_axes(shape, axes) || pinch_v3_dot(axes[0], to) < 0) continue;
        int before = list->count, index = triangles.shape_count;
        triangles.shape_count++;
        for (int k = 0; k < body->shape_count; k++) pinch_collide_pieces(body, k, &triangles, index, list);
        if (list->count == before) triangles.shape_count--;
    }
    if (body->shape_count > 1) pinch_drop_internal_edges(body, 0, list);
    if (triangles.shape_count > 1) pinch_drop_internal_edges(&triangles, 1, list);
}
