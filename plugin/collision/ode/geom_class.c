/* The geom class of fingertips, as ODE calls it. */
#include "collide.h"

#include "collision/shape/shape_pair.h"
#include "collision/shape/tip_data.h"

#include <math.h>
#include <string.h>

void pinch_close_tips(void)
{
    pinch_forget_convexes();
    pinch_set_tip_class(-1);
}

static void bounding_box(dGeomID geom, dReal box[6])
{
    pinch_posed_body body;
    if (!pinch_body_of_geom(geom, &body)) return;
    for (int i = 0; i < 3; i++) {
        double low = INFINITY, high = -INFINITY;
        for (int k = 0; k < body.shape_count; k++) {
            const pinch_shape *shape = &body.shapes[k];
            const double *row = body.R + 3 * i, back[3] = {-row[0], -row[1], -row[2]};
            high = fmax(high, pinch_support_value(shape, row) + shape->margin);
            low = fmin(low, -pinch_support_value(shape, back) - shape->margin);
        }
        box[2 * i] = body.position[i] + low;
        box[2 * i + 1] = body.position[i] + high;
    }
}

static int collider(dGeomID g1, dGeomID g2, int flags, dContactGeom *contacts, int skip)
{
    return pinch_tip_collide(g1, g2, flags & 0xffff, contacts, skip);
}

/* ODE takes spaces apart before they come here. Height fields have no public way in. */
static dColliderFn *collider_with(int class)
{
    bool known_class = class <= dRayClass || class == dConvexClass || class == dGeomTransformClass ||
                       class == dTriMeshClass || class == pinch_tip_class();
    return known_class ? collider : NULL;
}

static void destroy(dGeomID geom)
{
    pinch_tip_data_free(pinch_tip_data_of(geom));
}

static bool register_class(void)
{
    static const dGeomClass class = {.bytes = sizeof(pinch_tip_data *),
                                     .collider = collider_with,
                                     .aabb = bounding_box,
                                     .aabb_test = NULL,
                                     .dtor = destroy};
    if (pinch_tip_class() < 0) pinch_set_tip_class(dCreateGeomClass(&class));
    return pinch_tip_class() >= 0;
}

pinch_status pinch_create_tip(dSpaceID space, const pinch_tip *tip, dGeomID *geom)
{
    if (!geom) return PINCH_INVALID_ARGUMENT;
    *geom = NULL;
    if (!pinch_tip_legal(tip)) return PINCH_INVALID_ARGUMENT;
    if (!register_class()) return PINCH_UNSUPPORTED;
    pinch_tip_data *data = pinch_tip_data_create(tip);
    if (!data) return PINCH_OUT_OF_MEMORY;
    *geom = dCreateGeom(pinch_tip_class());
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
