/* The public calls that take geoms: contacts, closest points and curvatures. */
#include "collide.h"

#include "collision/penetration/penetration.h"
#include "collision/shape/feature.h"
#include "support/vec3.h"
#include "write_contacts.h"

#include <math.h>
#include <string.h>

/* Planes, meshes and rays come second in a pair. */
static bool comes_second(int class)
{
    return class == dPlaneClass || class == dTriMeshClass || class == dRayClass;
}

static int collide_ray(const pinch_posed_body *body, dGeomID ray, dGeomID g1, dGeomID g2, dContactGeom *contact)
{
    pinch_body_contacts one = {.count = 1};
    pinch_body_contact *t = &one.item[0];
    if (!pinch_cast_ray(body, ray, t->position, t->normal, &t->depth)) return 0;
    if (g1 != ray) pinch_v3_scale(t->normal, -1);
    return pinch_write_contacts(&one, g1, g2, 1, contact, (int)sizeof *contact);
}

int pinch_tip_collide(dGeomID g1, dGeomID g2, int room, dContactGeom *contacts, int skip)
{
    pinch_posed_body a, b;
    pinch_body_contacts list;
    list.count = 0;
    if (room < 1) return 0;
    bool swapped = comes_second(dGeomGetClass(g1));
    dGeomID first = swapped ? g2 : g1, second = swapped ? g1 : g2;
    int class = dGeomGetClass(second);
    if (!comes_second(class)) {
        if (!pinch_body_of_geom(g1, &a) || !pinch_body_of_geom(g2, &b)) return 0;
        return pinch_collide_bodies(&a, &b, room, contacts, skip);
    }
    if (!pinch_body_of_geom(first, &a)) return 0;
    if (class == dRayClass)
        return collide_ray(&a, second, swapped ? second : a.geom, swapped ? a.geom : second, contacts);
    if (class == dPlaneClass)
        pinch_collide_plane(&a, second, &list);
    else
        pinch_collide_trimesh(&a, second, &list);
    for (int k = 0; k < list.count && swapped; k++) pinch_v3_scale(list.item[k].normal, -1);
    return pinch_write_contacts(&list, swapped ? second : a.geom, swapped ? a.geom : second, room, contacts, skip);
}

pinch_status pinch_tip_closest_point(dGeomID geom, const double point[3], double *distance, double nearest[3],
                                     double normal[3])
{
    pinch_posed_body body;
    if (!geom || !point || !distance || !nearest || !normal) return PINCH_INVALID_ARGUMENT;
    for (int i = 0; i < 3; i++)
        if (!isfinite(point[i])) return PINCH_INVALID_ARGUMENT;
    if (dGeomGetClass(geom) == dPlaneClass) {
        dVector4 p;
        dGeomPlaneGetParams(geom, p);
        *distance = pinch_v3_dot(p, point) - p[3];
        pinch_v3_copy(normal, p);
    } else {
        if (comes_second(dGeomGetClass(geom)) || !pinch_body_of_geom(geom, &body)) return PINCH_UNSUPPORTED;
        *distance = pinch_signed_distance(&body, -1, point, normal);
    }
    pinch_v3_copy(nearest, point);
    pinch_v3_add_scaled(nearest, -*distance, normal);
    return PINCH_OK;
}

/* Returns the piece that extends farthest along d. */
static const pinch_shape *outermost(const pinch_posed_body *body, const double *d)
{
    const pinch_shape *best = body->shapes;
    for (int k = 1; k < body->shape_count; k++)
        if (pinch_support_value(&body->shapes[k], d) + body->shapes[k].margin >
            pinch_support_value(best, d) + best->margin)
            best = &body->shapes[k];
    return best;
}

/* The radii of curvature are the eigenvalues of the support Hessian, plus the margin. */
static void curvatures(const pinch_shape *shape, const double *d, double curvature[2], double *direction)
{
    pinch_feature part;
    double t1[3], t2[3], H[9], along[3];
    pinch_feature_at(shape, d, true, &part);
    pinch_v3_any_perpendicular(d, t1);
    pinch_v3_copy(direction, t1);
    curvature[0] = curvature[1] = 0;
    if (part.face) return;
    if (part.count == 2) {
        pinch_v3_sub(part.x[1], part.x[0], along);
        pinch_v3_scale(along, 1 / pinch_v3_norm(along));
        pinch_v3_copy(direction, along);
        bool is_round = shape->kind == PINCH_SHAPE_CYLINDER || shape->kind == PINCH_SHAPE_FLAT_CAPSULE;
        curvature[1] = 1 / (shape->margin + (is_round ? shape->radius : 0));
        return;
    }
    pinch_v3_cross(d, t1, t2);
    pinch_support_hessian(shape, d, H);
    double a = 0, b = 0, c = 0;
    for (int i = 0; i < 9; i++) {
        a += t1[i / 3] * H[i] * t1[i % 3];
        b += t1[i / 3] * H[i] * t2[i % 3];
        c += t2[i / 3] * H[i] * t2[i % 3];
    }
    double middle = 0.5 * (a + c), spread = hypot(0.5 * (a - c), b), angle = 0.5 * atan2(2 * b, a - c);
    for (int i = 0; i < 3; i++) direction[i] = cos(angle) * t1[i] + sin(angle) * t2[i];
    curvature[0] = 1 / (middle + spread + shape->margin);
    curvature[1] = 1 / (fmax(0, middle - spread) + shape->margin);
}

pinch_status pinch_tip_curvature(dGeomID geom, const double normal[3], double curvature[2], double direction[3])
{
    pinch_posed_body body;
    if (!geom || !normal || !curvature || !direction || !(fabs(pinch_v3_norm(normal) - 1) < 1e-6))
        return PINCH_INVALID_ARGUMENT;
    if (dGeomGetClass(geom) == dPlaneClass) {
        curvature[0] = curvature[1] = 0;
        pinch_v3_any_perpendicular(normal, direction);
        return PINCH_OK;
    }
    if (comes_second(dGeomGetClass(geom)) || !pinch_body_of_geom(geom, &body)) return PINCH_UNSUPPORTED;
    double d[3], local[3];
    for (int i = 0; i < 3; i++) d[i] = body.R[i] * normal[0] + body.R[3 + i] * normal[1] + body.R[6 + i] * normal[2];
    curvatures(outermost(&body, d), d, curvature, local);
    for (int i = 0; i < 3; i++) direction[i] = pinch_v3_dot(body.R + 3 * i, local);
    return PINCH_OK;
}
