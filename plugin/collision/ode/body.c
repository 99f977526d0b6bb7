#include "collide.h"

#include "collision/penetration/penetration.h"
#include "collision/shape/shape_pair.h"
#include "collision/shape/tip_data.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

static void set_pose(const double *position, const double *rotation, pinch_posed_body *body)
{
    pinch_v3_copy(body->position, position);
    for (int i = 0; i < 9; i++) body->R[i] = rotation[4 * (i / 3) + i % 3];
}

/* Makes a sharp cylinder, or the line inside a capsule. */
static void set_long(pinch_shape *shape, pinch_shape_kind kind, double radius, double length)
{
    shape->kind = kind;
    shape->half[2] = 0.5 * length;
    if (kind == PINCH_SHAPE_SEGMENT) {
        shape->margin = radius;
        shape->bound = shape->half[2] + radius;
    } else {
        shape->radius = radius;
        shape->bound = sqrt(radius * radius + shape->half[2] * shape->half[2]);
    }
}

/* Clears all fields but `corner`, which only triangles use. */
static void clear(pinch_shape *shape)
{
    shape->kind = PINCH_SHAPE_POINT;
    shape->half[0] = shape->half[1] = shape->half[2] = 0;
    shape->radius = shape->middle = shape->power[0] = shape->power[1] = 0;
    shape->margin = shape->erosion = shape->bound = 0;
    shape->hull = NULL;
}

/* The shape is made in place at every call. Fields that the kind does not use stay 0. */
static bool own_shape(dGeomID geom, int class, pinch_posed_body *body)
{
    pinch_shape *shape = &body->own;
    double radius, length;
    dVector3 sides;
    clear(shape);
    body->shapes = shape;
    body->shape_count = 1;
    switch (class) {
    case dSphereClass:
        shape->margin = shape->bound = dGeomSphereGetRadius(geom);
        return true;
    case dBoxClass:
        shape->kind = PINCH_SHAPE_BOX;
        dGeomBoxGetLengths(geom, sides);
        for (int i = 0; i < 3; i++) shape->half[i] = 0.5 * sides[i];
        shape->bound = pinch_v3_norm(shape->half);
        return true;
    case dCapsuleClass:
        dGeomCapsuleGetParams(geom, &radius, &length);
        set_long(shape, PINCH_SHAPE_SEGMENT, radius, length);
        return true;
    case dCylinderClass:
        dGeomCylinderGetParams(geom, &radius, &length);
        set_long(shape, PINCH_SHAPE_CYLINDER, radius, length);
        return true;
    case dConvexClass:
        body->shapes = pinch_known_convex(geom);
        pinch_tip_counters()->unknown_convex += !body->shapes;
        return body->shapes != NULL;
    default:
        return false;
    }
}

/* The geom inside a transform has its pose in the transform's axes. ODE deprecates transforms, but programs still have
 * them. */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
static bool transformed(dGeomID transform, pinch_posed_body *body)
{
    dGeomID inner = dGeomTransformGetGeom(transform);
    if (!inner || dGeomGetClass(inner) == dGeomTransformClass || !pinch_body_of_geom(inner, body)) return false;
    const double *P = dGeomGetPosition(transform), *Q = dGeomGetRotation(transform);
    double R[9], x[3];
    for (int i = 0; i < 3; i++) {
        x[i] = P[i] + pinch_v3_dot(Q + 4 * i, body->position);
        for (int j = 0; j < 3; j++)
            R[3 * i + j] = Q[4 * i] * body->R[j] + Q[4 * i + 1] * body->R[3 + j] + Q[4 * i + 2] * body->R[6 + j];
    }
    memcpy(body->R, R, sizeof R);
    pinch_v3_copy(body->position, x);
    if (dGeomTransformGetInfo(transform)) body->geom = transform;
    return true;
}
#pragma GCC diagnostic pop

bool pinch_body_of_geom(dGeomID geom, pinch_posed_body *body)
{
    int class = dGeomGetClass(geom);
    body->geom = geom;
    if (class == dGeomTransformClass) return transformed(geom, body);
    if (class == pinch_tip_class()) {
        const pinch_tip_data *data = pinch_tip_data_of(geom);
        body->shapes = data->shapes;
        body->shape_count = data->tip.type == PINCH_TIP_CONVEX ? data->tip.piece_count : 1;
    } else if (!own_shape(geom, class, body)) {
        return false;
    }
    set_pose(dGeomGetPosition(geom), dGeomGetRotation(geom), body);
    return true;
}

/* Of a mesh ODE tells the triangles where they are in the world. */
static bool sides_of_trimesh(dGeomID mesh, double sides[3])
{
    const double *position = dGeomGetPosition(mesh), *R = dGeomGetRotation(mesh);
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    int count = dGeomTriMeshGetTriangleCount(mesh);
    for (int t = 0; t < count; t++) {
        dVector3 corner[3];
        dGeomTriMeshGetTriangle(mesh, t, &corner[0], &corner[1], &corner[2]);
        for (int k = 0; k < 9; k++) {
            double from[3];
            int i = k % 3;
            pinch_v3_sub(corner[k / 3], position, from);
            double along = R[i] * from[0] + R[4 + i] * from[1] + R[8 + i] * from[2];
            low[i] = fmin(low[i], along);
            high[i] = fmax(high[i], along);
        }
    }
    for (int i = 0; i < 3; i++) sides[i] = high[i] - low[i];
    return count > 0;
}

bool pinch_own_sides(dGeomID geom, double sides[3])
{
    int class = dGeomGetClass(geom);
    pinch_posed_body body;
    if (class == dTriMeshClass) return sides_of_trimesh(geom, sides);
    if (class == dConvexClass && !pinch_known_convex(geom)) return false; /* nobody has asked for its contacts */
    if (!pinch_body_of_geom(geom, &body)) return false;
    for (int i = 0; i < 3; i++) {
        double out[3] = {0, 0, 0}, back[3] = {0, 0, 0}, low = INFINITY, high = -INFINITY;
        out[i] = 1;
        back[i] = -1;
        for (int k = 0; k < body.shape_count; k++) {
            const pinch_shape *shape = &body.shapes[k];
            high = fmax(high, pinch_support_value(shape, out) + shape->margin);
            low = fmin(low, -pinch_support_value(shape, back) - shape->margin);
        }
        sides[i] = high - low;
    }
    return true;
}
