/* What worlds are made of: bodies, geoms, materials. */
#include "world.h"

#include "common/vector.h"
#include "scenes/shape/shape.h"

#include <stdlib.h>
#include <string.h>

/* ---- Shapes as ODE geoms: ODE's own where it has them, fingertip geoms for the rest. ---- */

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

/* Makes a geom in no space. It copies what it needs. NULL when memory runs out. */
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

/* ---- Bodies and materials. ---- */

dBodyID world_make_body(world *w, const double position[3], const double orientation[4])
{
    if (w->body_count % 64 == 0) {
        dBodyID *more = realloc(w->bodies, ((size_t)w->body_count + 64) * sizeof *more);
        if (!more) return NULL;
        w->bodies = more;
    }
    dBodyID body = dBodyCreate(w->ode);
    w->bodies[w->body_count++] = body;
    dBodySetPosition(body, position[0], position[1], position[2]);
    dBodySetQuaternion(body, orientation);
    dBodySetFiniteRotationMode(body, 1);
    return body;
}

/* The scene's first tangent in the tip's own axes: the facets of a linearized cone turn with the tip. Links have none.
 */
static void facet_axis(const scene_finger *f, double axis[3])
{
    dMatrix3 R;
    dVector3 local;
    memset(axis, 0, 3 * sizeof *axis);
    if (scene_norm(f->t1) == 0) return;
    dQtoR(f->tip_orientation, R);
    dMultiply1_331(local, R, f->t1);
    for (int i = 0; i < 3; i++) axis[i] = local[i];
}

pinch_material world_finger_material(const scene_finger *f)
{
    pinch_material m = {
        .model = f->model == SCENE_FRICTIONLESS ? PINCH_CONTACT_FRICTIONLESS
                 : f->model == SCENE_HARD       ? PINCH_CONTACT_HARD
                                                : PINCH_CONTACT_SOFT,
        .stiffness = {f->stiffness.normal, f->stiffness.tangential, f->stiffness.torsional},
        .damping = {f->damping.normal, f->damping.tangential, f->damping.torsional},
        .friction = f->friction.static_,
        .friction_kinetic = f->friction.kinetic,
        .torsional_friction = f->torsional_friction,
        .max_force = f->max_force,
        .hertz_modulus = f->stiffness.hertz,
    };
    facet_axis(f, m.facet_axis);
    return m;
}

world_status world_add_geom(world *w, dGeomID geom, const pinch_material *material, int category)
{
    pinch_ode *plugin = w->plugin ? w->plugin : w->manifolds;
    if (plugin && pinch_ode_set_material(plugin, geom, material) != PINCH_OK) return WORLD_NO_MEMORY;
    w->materials[w->geom_count] = *material;
    w->categories[w->geom_count] = category;
    w->geoms[w->geom_count++] = geom;
    return WORLD_OK;
}
