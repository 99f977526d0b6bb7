#include "collide.h"

#include "collision/penetration/penetration.h"
#include "collision/shape/shape_pair.h"
#include "collision/shape/tip_data.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

static void set_pose(const double *position, const double *rotation, pinch_tip_body *body)
{
    pinch_v3_copy(body->position, position);
    for (int i = 0; i < 9; i++) body->R[i] = rotation[4 * (i / 3) + i % 3];
}

/* A sharp cylinder's core, or with round ends the line in a capsule's. */
static void set_long(pinch_core *core, pinch_core_kind kind, double radius, double length)
{
    core->kind = kind;
    core->half[2] = 0.5 * length;
    if (kind == PINCH_CORE_SEGMENT) {
        core->skin = radius;
        core->bound = core->half[2] + radius;
    } else {
        core->radius = radius;
        core->bound = sqrt(radius * radius + core->half[2] * core->half[2]);
    }
}

/* Not `corner`, which triangles alone use. */
static void clear(pinch_core *core)
{
    core->kind = PINCH_CORE_POINT;
    core->half[0] = core->half[1] = core->half[2] = 0;
    core->radius = core->middle = core->power[0] = core->power[1] = 0;
    core->skin = core->erosion = core->bound = 0;
    core->hull = NULL;
}

/* In place, for every call: fields that the kind does not use stay 0. */
static bool own_core(dGeomID geom, int class, pinch_tip_body *body)
{
    pinch_core *core = &body->own;
    double radius, length;
    dVector3 sides;
    clear(core);
    body->cores = core;
    body->core_count = 1;
    switch (class) {
    case dSphereClass:
        core->skin = core->bound = dGeomSphereGetRadius(geom);
        return true;
    case dBoxClass:
        core->kind = PINCH_CORE_BOX;
        dGeomBoxGetLengths(geom, sides);
        for (int i = 0; i < 3; i++) core->half[i] = 0.5 * sides[i];
        core->bound = pinch_v3_norm(core->half);
        return true;
    case dCapsuleClass:
        dGeomCapsuleGetParams(geom, &radius, &length);
        set_long(core, PINCH_CORE_SEGMENT, radius, length);
        return true;
    case dCylinderClass:
        dGeomCylinderGetParams(geom, &radius, &length);
        set_long(core, PINCH_CORE_CYLINDER, radius, length);
        return true;
    case dConvexClass:
        body->cores = pinch_known_core(geom);
        pinch_tip_counters()->unknown_convex += !body->cores;
        return body->cores != NULL;
    default:
        return false;
    }
}

/* A transform's geom has its pose in the transform's axes. ODE deprecates transforms, and programs still have them. */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
static bool transformed(dGeomID transform, pinch_tip_body *body)
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

bool pinch_body_of_geom(dGeomID geom, pinch_tip_body *body)
{
    int class = dGeomGetClass(geom);
    body->geom = geom;
    if (class == dGeomTransformClass) return transformed(geom, body);
    if (class == pinch_tip_class()) {
        const pinch_tip_data *data = pinch_tip_data_of(geom);
        body->cores = data->cores;
        body->core_count = data->tip.type == PINCH_TIP_CONVEX ? data->tip.piece_count : 1;
    } else if (!own_core(geom, class, body)) {
        return false;
    }
    set_pose(dGeomGetPosition(geom), dGeomGetRotation(geom), body);
    return true;
}
