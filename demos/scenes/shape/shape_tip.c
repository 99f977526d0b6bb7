#include "shape_tip.h"

#include <string.h>

static void set_long(pinch_tip *tip, double radius, double length)
{
    tip->size[0] = radius;
    tip->size[1] = length;
}

bool scene_shape_tip(const scene_shape *shape, pinch_tip *tip)
{
    static const pinch_tip_type types[SCENE_SHAPE_COUNT] = {[SCENE_BOX] = PINCH_TIP_BOX,
                                                            [SCENE_SPHERE] = PINCH_TIP_SPHERE,
                                                            [SCENE_CAPSULE] = PINCH_TIP_CAPSULE,
                                                            [SCENE_FLAT_CAPSULE] = PINCH_TIP_FLAT_CAPSULE,
                                                            [SCENE_CYLINDER] = PINCH_TIP_CYLINDER,
                                                            [SCENE_SUPERELLIPSOID] = PINCH_TIP_SUPERELLIPSOID,
                                                            [SCENE_ELLIPSOID] = PINCH_TIP_ELLIPSOID};
    *tip = pinch_default_tip(types[shape->type]);
    switch (shape->type) {
    case SCENE_BOX:
        memcpy(tip->size, shape->u.box.size, sizeof tip->size);
        tip->skin = shape->u.box.rounding;
        return true;
    case SCENE_SPHERE:
        tip->size[0] = shape->u.sphere.radius;
        return true;
    case SCENE_CAPSULE:
        set_long(tip, shape->u.capsule.radius, shape->u.capsule.length);
        return true;
    case SCENE_FLAT_CAPSULE:
        set_long(tip, shape->u.flat_capsule.radius, shape->u.flat_capsule.length);
        return true;
    case SCENE_CYLINDER:
        set_long(tip, shape->u.cylinder.radius, shape->u.cylinder.length);
        tip->skin = shape->u.cylinder.rounding;
        return true;
    case SCENE_ELLIPSOID:
        memcpy(tip->size, shape->u.ellipsoid.radii, sizeof tip->size);
        return true;
    case SCENE_SUPERELLIPSOID:
        memcpy(tip->size, shape->u.superellipsoid.radii, sizeof tip->size);
        memcpy(tip->exponent, shape->u.superellipsoid.exponents, sizeof tip->exponent);
        return true;
    default:
        return false;
    }
}
