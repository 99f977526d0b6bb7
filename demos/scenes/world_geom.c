/* A scene's shapes as ODE geoms: ODE's own where it has them, fingertip geoms for the rest. */
#include "world.h"

#include <pinch/fingertip.h>

#include <string.h>

static dGeomID make_tip(const pinch_tip *tip)
{
    dGeomID geom;
    return pinch_create_tip(NULL, tip, &geom) == PINCH_OK ? geom : NULL;
}

static dGeomID make_ellipsoid(const double radii[3])
{
    pinch_tip tip = pinch_default_tip(PINCH_TIP_ELLIPSOID);
    memcpy(tip.size, radii, sizeof tip.size);
    return make_tip(&tip);
}

static dGeomID make_convex(const scene_hull *hull)
{
    pinch_convex piece = {hull->planes, (unsigned)hull->face_count, hull->vertices, hull->polygons,
                          (unsigned)hull->vertex_count};
    pinch_tip tip = pinch_default_tip(PINCH_TIP_CONVEX);
    tip.pieces = &piece;
    tip.piece_count = 1;
    return make_tip(&tip);
}

dGeomID world_make_geom(const scene_shape *shape)
{
    switch (shape->type) {
    case SCENE_BOX:
        return dCreateBox(NULL, shape->u.box.size[0], shape->u.box.size[1], shape->u.box.size[2]);
    case SCENE_SPHERE:
        return dCreateSphere(NULL, shape->u.sphere.radius);
    case SCENE_CAPSULE:
        return dCreateCapsule(NULL, shape->u.capsule.radius, shape->u.capsule.length);
    case SCENE_CYLINDER:
        return dCreateCylinder(NULL, shape->u.cylinder.radius, shape->u.cylinder.length);
    case SCENE_ELLIPSOID:
        return make_ellipsoid(shape->u.ellipsoid.radii);
    case SCENE_CONVEX:
    case SCENE_PRISM:
        return make_convex(&shape->hull);
    default:
        return NULL;
    }
}
