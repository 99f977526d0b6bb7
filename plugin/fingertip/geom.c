/* The geom class, and ODE's own geoms as cores. */
#include "body.h"

#include "support/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ODE's geom classes belong to the process, and so does what is known about its convex geoms. */
static int tip_class = -1;

typedef struct known_convex {
    dGeomID geom;
    pinch_core_hull hull;
} known_convex;

static known_convex *known;
static int known_count, known_room;

static _Thread_local pinch_tip_stats counters;

pinch_tip_stats *pinch_tip_counters(void)
{
    return &counters;
}

pinch_tip_stats pinch_tip_statistics(void)
{
    return counters;
}

void pinch_tip_reset_statistics(void)
{
    memset(&counters, 0, sizeof counters);
}

static pinch_tip_data *data_of(dGeomID geom)
{
    pinch_tip_data *data;
    memcpy(&data, dGeomGetClassData(geom), sizeof data);
    return data;
}

int pinch_tip_class(void)
{
    return tip_class;
}

const pinch_tip *pinch_tip_of(dGeomID geom)
{
    return geom && tip_class >= 0 && dGeomGetClass(geom) == tip_class ? &data_of(geom)->tip : NULL;
}

void pinch_close_tips(void)
{
    for (int k = 0; k < known_count; k++) free((void *)known[k].hull.edges);
    free(known);
    known = NULL;
    known_count = known_room = 0;
    tip_class = -1;
}

static const pinch_core_hull *hull_of_geom(dGeomID geom)
{
    for (int k = 0; k < known_count; k++)
        if (known[k].geom == geom) return &known[k].hull;
    return NULL;
}

pinch_status pinch_tip_know_convex(dGeomID geom, const pinch_convex *convex)
{
    if (!geom || (convex && dGeomGetClass(geom) != dConvexClass)) return PINCH_INVALID_ARGUMENT;
    pinch_core_hull hull;
    pinch_tip tip = {.type = PINCH_TIP_CONVEX, .pieces = convex, .piece_count = 1};
    if (convex && !pinch_tip_legal(&tip)) return PINCH_INVALID_ARGUMENT;
    if (convex && !pinch_hull_of_convex(convex, &hull)) return PINCH_OUT_OF_MEMORY;
    for (int k = 0; k < known_count; k++) {
        if (known[k].geom != geom) continue;
        free((void *)known[k].hull.edges);
        known[k] = known[--known_count];
        break;
    }
    if (!convex) return PINCH_OK;
    if (known_count == known_room) {
        int room = known_room ? 2 * known_room : 16;
        known_convex *more = realloc(known, (size_t)room * sizeof *more);
        if (!more) {
            free((void *)hull.edges);
            return PINCH_OUT_OF_MEMORY;
        }
        known = more;
        known_room = room;
    }
    known[known_count++] = (known_convex){geom, hull};
    return PINCH_OK;
}

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

/* In place, for every call: fields that the kind does not use stay 0. */
static bool own_core(dGeomID geom, pinch_tip_body *body)
{
    pinch_core *core = &body->own;
    double radius, length;
    dVector3 sides;
    memset(core, 0, sizeof *core);
    body->cores = core;
    body->core_count = 1;
    switch (dGeomGetClass(geom)) {
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
    case dConvexClass: {
        const pinch_core_hull *hull = hull_of_geom(geom);
        const pinch_tip tip = {.type = PINCH_TIP_CONVEX};
        counters.unknown_convex += !hull;
        if (hull) *core = pinch_core_of_tip(&tip, hull);
        return hull != NULL;
    }
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
    if (class == tip_class) {
        const pinch_tip_data *data = data_of(geom);
        body->cores = data->cores;
        body->core_count = data->tip.type == PINCH_TIP_CONVEX ? data->tip.piece_count : 1;
    } else if (!own_core(geom, body)) {
        return false;
    }
    set_pose(dGeomGetPosition(geom), dGeomGetRotation(geom), body);
    return true;
}

static void bounding_box(dGeomID geom, dReal box[6])
{
    pinch_tip_body body;
    if (!pinch_body_of_geom(geom, &body)) return;
    for (int i = 0; i < 3; i++) {
        double low = INFINITY, high = -INFINITY;
        for (int k = 0; k < body.core_count; k++) {
            const pinch_core *core = &body.cores[k];
            const double *row = body.R + 3 * i, back[3] = {-row[0], -row[1], -row[2]};
            high = fmax(high, pinch_core_reach(core, row) + core->skin);
            low = fmin(low, -pinch_core_reach(core, back) - core->skin);
        }
        box[2 * i] = body.position[i] + low;
        box[2 * i + 1] = body.position[i] + high;
    }
}

static int collider(dGeomID g1, dGeomID g2, int flags, dContactGeom *contacts, int skip)
{
    return pinch_tip_collide(g1, g2, flags & 0xffff, contacts, skip);
}

/* Spaces are taken apart by ODE before they come here, height fields have no public way in. */
static dColliderFn *collider_with(int class)
{
    bool known_class = class <= dRayClass || class == dConvexClass || class == dGeomTransformClass ||
                       class == dTriMeshClass || class == tip_class;
    return known_class ? collider : NULL;
}

static void destroy(dGeomID geom)
{
    pinch_tip_data_free(data_of(geom));
}

static bool register_class(void)
{
    static const dGeomClass class = {.bytes = sizeof(pinch_tip_data *),
                                     .collider = collider_with,
                                     .aabb = bounding_box,
                                     .aabb_test = NULL,
                                     .dtor = destroy};
    if (tip_class >= 0) return true;
    tip_class = dCreateGeomClass(&class);
    return tip_class >= 0;
}

pinch_status pinch_create_tip(dSpaceID space, const pinch_tip *tip, dGeomID *geom)
{
    if (!geom) return PINCH_INVALID_ARGUMENT;
    *geom = NULL;
    if (!pinch_tip_legal(tip)) return PINCH_INVALID_ARGUMENT;
    if (!register_class()) return PINCH_UNSUPPORTED;
    pinch_tip_data *data = pinch_tip_data_create(tip);
    if (!data) return PINCH_OUT_OF_MEMORY;
    *geom = dCreateGeom(tip_class);
    memcpy(dGeomGetClassData(*geom), &data, sizeof data);
    if (space) dSpaceAdd(space, *geom);
    return PINCH_OK;
}

pinch_status pinch_tip_take_over(int class1, int class2)
{
    for (int side = 0; side < 2; side++) {
        int class = side ? class2 : class1, other = side ? class1 : class2;
        bool body = class == dSphereClass || class == dBoxClass || class == dCapsuleClass || class == dCylinderClass ||
                    class == dConvexClass;
        bool ground =
            (class == dPlaneClass || class == dTriMeshClass) && other != dPlaneClass && other != dTriMeshClass;
        if (!body && !ground) return PINCH_INVALID_ARGUMENT;
    }
    dSetColliderOverride(class1, class2, collider);
    return PINCH_OK;
}
