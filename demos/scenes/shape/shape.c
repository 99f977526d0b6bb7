/* Mass properties and bounding radius of the shapes. */

#include "shape.h"
#include "common/vector.h"

#include <stdlib.h>
#include <string.h>

void scene_shape_free(scene_shape *shape)
{
    switch (shape->type) {
    case SCENE_CONVEX:
        free(shape->u.convex.vertices);
        break;
    case SCENE_PRISM:
        free(shape->u.prism.vertices);
        break;
    case SCENE_MESH:
        free(shape->u.mesh.file);
        break;
    default:
        break;
    }
    mesh_hull_free(&shape->hull);
    for (size_t k = 0; k < shape->piece_count; k++) mesh_hull_free(&shape->pieces[k]);
    free(shape->pieces);
    memset(shape, 0, sizeof *shape);
}

/* xx, yy and zz are the mean squares of the coordinates over the volume. */
static void set_unit_inertia(scene_shape *shape, double xx, double yy, double zz)
{
    memset(shape->unit_inertia, 0, sizeof shape->unit_inertia);
    shape->unit_inertia[0] = yy + zz;
    shape->unit_inertia[4] = zz + xx;
    shape->unit_inertia[8] = xx + yy;
}

static void complete_box(scene_shape *shape)
{
    const double *s = shape->u.box.size;
    shape->volume = s[0] * s[1] * s[2];
    shape->bounding_radius = 0.5 * scene_norm(s);
    set_unit_inertia(shape, s[0] * s[0] / 12.0, s[1] * s[1] / 12.0, s[2] * s[2] / 12.0);
}

static void complete_ellipsoid(scene_shape *shape, const double r[3])
{
    shape->volume = 4.0 / 3.0 * SCENE_PI * r[0] * r[1] * r[2];
    shape->bounding_radius = fmax(r[0], fmax(r[1], r[2]));
    set_unit_inertia(shape, r[0] * r[0] / 5.0, r[1] * r[1] / 5.0, r[2] * r[2] / 5.0);
}

static void complete_cylinder(scene_shape *shape)
{
    double r = shape->u.cylinder.radius, l = shape->u.cylinder.length;
    shape->volume = SCENE_PI * r * r * l;
    shape->bounding_radius = hypot(r, 0.5 * l);
    set_unit_inertia(shape, r * r / 4.0, r * r / 4.0, l * l / 12.0);
}

/* A capsule is a cylinder of volume pi r^2 l and two half balls, together a ball of volume 4/3 pi r^3. About the
 * capsule's middle a half ball's mean z^2 is that of the ball about its centre, r^2/5, plus what the distance of l/2
 * adds: with the half ball's mean height 3 r/8 over its flat side, mean (z + l/2)^2 = r^2/5 + 3 r l/8 + l^2/4. */
static void complete_capsule(scene_shape *shape)
{
    double r = shape->u.capsule.radius, l = shape->u.capsule.length;
    double tube = SCENE_PI * r * r * l, ball = 4.0 / 3.0 * SCENE_PI * r * r * r;
    double part = ball / (tube + ball);
    double radial = (1.0 - part) * r * r / 4.0 + part * r * r / 5.0;
    double axial = (1.0 - part) * l * l / 12.0 + part * (r * r / 5.0 + 3.0 * r * l / 8.0 + l * l / 4.0);
    shape->volume = tube + ball;
    shape->bounding_radius = r + 0.5 * l;
    set_unit_inertia(shape, radial, radial, axial);
}

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

/* The moments of rounded boxes and cylinders, flat capsules and superellipsoids come from Pinch's fingertip geometry.
 */
static bool complete_by_tip(scene_shape *shape, double bounding_radius)
{
    pinch_tip tip;
    shape->bounding_radius = bounding_radius;
    return scene_shape_tip(shape, &tip) && pinch_tip_inertia(&tip, &shape->volume, shape->unit_inertia) == PINCH_OK;
}

static double rounded_radius(double x, double y, double z, double rounding)
{
    return scene_norm((double[3]){x - rounding, y - rounding, z - rounding}) + rounding;
}

static bool complete_rounded_box(scene_shape *shape)
{
    const double *s = shape->u.box.size;
    return complete_by_tip(shape, rounded_radius(0.5 * s[0], 0.5 * s[1], 0.5 * s[2], shape->u.box.rounding));
}

static bool complete_rounded_cylinder(scene_shape *shape)
{
    double rounding = shape->u.cylinder.rounding;
    return complete_by_tip(
        shape, rounded_radius(shape->u.cylinder.radius, rounding, 0.5 * shape->u.cylinder.length, rounding));
}

static double hull_radius(const scene_hull *hull)
{
    double radius = 0.0;
    for (size_t i = 0; i < hull->vertex_count; i++) radius = fmax(radius, scene_norm(hull->vertices + 3 * i));
    return radius;
}

static void move_vertices(scene_shape *shape, const double shift[3])
{
    if (shape->type == SCENE_CONVEX)
        for (size_t i = 0; i < shape->u.convex.count; i++)
            scene_add_scaled(shape->u.convex.vertices + 3 * i, -1.0, shift);
    else
        for (size_t i = 0; i < shape->u.prism.count; i++)
            for (int k = 0; k < 2; k++) shape->u.prism.vertices[2 * i + (size_t)k] -= shift[k];
}

static scene_shape_fault complete_polyhedron(scene_shape *shape)
{
    scene_hull *hull = &shape->hull;
    scene_shape_fault fault =
        shape->type == SCENE_CONVEX
            ? scene_hull_of_points(shape->u.convex.vertices, shape->u.convex.count, hull)
            : scene_hull_of_prism(shape->u.prism.vertices, shape->u.prism.count, shape->u.prism.height, hull);
    if (fault != SCENE_SHAPE_FINE) return fault;

    /* Far from the origin one pass leaves rounding of that distance behind, so passes are repeated until the centre is
     * at the origin to rounding. Vertices that are there already keep their bits, so that a printed scene loads
     * unchanged. */
    double centre[3], second[9];
    for (int pass = 0; pass < 8; pass++) {
        mesh_hull_moments(hull, &shape->volume, centre, second);
        shape->bounding_radius = hull_radius(hull);
        if (shape->type == SCENE_PRISM) centre[2] = 0.0;
        if (!(scene_norm(centre) > 1e-13 * shape->bounding_radius)) break;
        scene_add_scaled(shape->shift, 1.0, centre);
        move_vertices(shape, centre);
        mesh_hull_recentre(hull, centre);
    }
    double r = shape->bounding_radius;
    /* A coin a millionth as thick as wide still passes. A thinner hull is rounding. */
    if (!(shape->volume > 1e-7 * r * r * r)) return SCENE_SHAPE_FLAT;
    double trace = second[0] + second[4] + second[8];
    for (int i = 0; i < 9; i++) shape->unit_inertia[i] = ((i % 4 ? 0.0 : trace) - second[i]) / shape->volume;
    return SCENE_SHAPE_FINE;
}

scene_shape_fault scene_shape_complete(scene_shape *shape)
{
    scene_shape_fault fault = SCENE_SHAPE_FINE;
    memset(shape->shift, 0, sizeof shape->shift);
    switch (shape->type) {
    case SCENE_BOX:
        if (!(shape->u.box.rounding > 0.0))
            complete_box(shape);
        else if (!complete_rounded_box(shape))
            return SCENE_SHAPE_OUT_OF_RANGE;
        break;
    case SCENE_SPHERE: {
        double r = shape->u.sphere.radius;
        complete_ellipsoid(shape, (double[3]){r, r, r});
        break;
    }
    case SCENE_CAPSULE:
        complete_capsule(shape);
        break;
    case SCENE_CYLINDER:
        if (!(shape->u.cylinder.rounding > 0.0))
            complete_cylinder(shape);
        else if (!complete_rounded_cylinder(shape))
            return SCENE_SHAPE_OUT_OF_RANGE;
        break;
    case SCENE_FLAT_CAPSULE:
        if (!complete_by_tip(shape, scene_flat_capsule_radius(shape))) return SCENE_SHAPE_OUT_OF_RANGE;
        break;
    case SCENE_SUPERELLIPSOID:
        if (!complete_by_tip(shape, scene_superellipsoid_radius(shape))) return SCENE_SHAPE_OUT_OF_RANGE;
        break;
    case SCENE_ELLIPSOID:
        complete_ellipsoid(shape, shape->u.ellipsoid.radii);
        break;
    case SCENE_CONVEX:
    case SCENE_PRISM:
        fault = complete_polyhedron(shape);
        break;
    default:
        return SCENE_SHAPE_OUT_OF_RANGE;
    }
    if (fault != SCENE_SHAPE_FINE) return fault;
    bool usable = isfinite(shape->volume) && shape->volume > 0.0 && isfinite(shape->bounding_radius);
    for (int i = 0; i < 9; i += 4) usable = usable && isfinite(shape->unit_inertia[i]) && shape->unit_inertia[i] > 0.0;
    return usable ? SCENE_SHAPE_FINE : SCENE_SHAPE_OUT_OF_RANGE;
}
