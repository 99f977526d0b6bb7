/* A scene's shapes as ODE geoms: ODE's own where it has them, fingertip geoms for the rest. */
#include "scenes/shape/shape_tip.h"
#include "world.h"

#include <stdlib.h>

static dGeomID make_tip(const pinch_tip *tip)
{
    dGeomID geom;
    return pinch_create_tip(NULL, tip, &geom) == PINCH_OK ? geom : NULL;
}

static dGeomID make_convex(const scene_hull *hulls, size_t count)
{
    pinch_convex *pieces = calloc(count, sizeof *pieces);
    pinch_tip tip = pinch_default_tip(PINCH_TIP_CONVEX);
    if (!pieces) return NULL;
    for (size_t k = 0; k < count; k++)
        pieces[k] = (pinch_convex){hulls[k].planes, (unsigned)hulls[k].face_count, hulls[k].vertices, hulls[k].polygons,
                                   (unsigned)hulls[k].vertex_count};
    tip.pieces = pieces;
    tip.piece_count = (int)count;
    dGeomID geom = make_tip(&tip);
    free(pieces);
    return geom;
}

dGeomID world_make_geom(const scene_shape *shape)
{
    pinch_tip tip;
    bool rounded = (shape->type == SCENE_BOX && shape->u.box.rounding > 0.0) ||
                   (shape->type == SCENE_CYLINDER && shape->u.cylinder.rounding > 0.0);
    if (rounded) return scene_shape_tip(shape, &tip) ? make_tip(&tip) : NULL;
    switch (shape->type) {
    case SCENE_BOX:
        return dCreateBox(NULL, shape->u.box.size[0], shape->u.box.size[1], shape->u.box.size[2]);
    case SCENE_SPHERE:
        return dCreateSphere(NULL, shape->u.sphere.radius);
    case SCENE_CAPSULE:
        return dCreateCapsule(NULL, shape->u.capsule.radius, shape->u.capsule.length);
    case SCENE_CYLINDER:
        return dCreateCylinder(NULL, shape->u.cylinder.radius, shape->u.cylinder.length);
    case SCENE_CONVEX:
    case SCENE_PRISM:
        return make_convex(&shape->hull, 1);
    case SCENE_MESH:
        return make_convex(shape->pieces, shape->piece_count);
    default:
        return scene_shape_tip(shape, &tip) ? make_tip(&tip) : NULL;
    }
}
