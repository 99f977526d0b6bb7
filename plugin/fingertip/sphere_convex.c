#include <pinch/fingertip.h>

#include "support/vec3.h"

#include <float.h>
#include <stdbool.h>
#include <string.h>

static double plane_distance(const double *plane, const double *point)
{
    return pinch_v3_dot(plane, point) - plane[3];
}

/* The point of the segment ab nearest to p. */
static void nearest_on_segment(const double *a, const double *b, const double *p, double *nearest)
{
    double ab[3], ap[3];
    pinch_v3_sub(b, a, ab);
    pinch_v3_sub(p, a, ap);
    double length2 = pinch_v3_dot(ab, ab), t = length2 > 0 ? pinch_v3_dot(ap, ab) / length2 : 0;
    pinch_v3_copy(nearest, a);
    pinch_v3_add_scaled(nearest, t < 0 ? 0 : t > 1 ? 1 : t, ab);
}

/* The point of a face nearest to p: its foot on the plane when that is inside the polygon, else the nearest edge's. */
static void nearest_on_face(const pinch_convex *convex, const double *plane, const unsigned *polygon, const double *p,
                            double *nearest)
{
    unsigned corners = polygon[0];
    double best = DBL_MAX;
    bool inside = true;
    pinch_v3_copy(nearest, p);
    pinch_v3_add_scaled(nearest, -plane_distance(plane, p), plane);
    double foot[3];
    pinch_v3_copy(foot, nearest);
    for (unsigned i = 0; i < corners; i++) {
        const double *a = convex->points + 3 * polygon[1 + i], *b = convex->points + 3 * polygon[1 + (i + 1) % corners];
        double edge[3], outward[3], from[3], candidate[3];
        pinch_v3_sub(b, a, edge);
        pinch_v3_cross(edge, plane, outward);
        pinch_v3_sub(foot, a, from);
        if (pinch_v3_dot(from, outward) <= 0) continue;
        inside = false;
        nearest_on_segment(a, b, p, candidate);
        pinch_v3_sub(p, candidate, from);
        double distance2 = pinch_v3_dot(from, from);
        if (distance2 < best) {
            best = distance2;
            pinch_v3_copy(nearest, candidate);
        }
    }
    if (inside) pinch_v3_copy(nearest, foot);
}

/* Signed distance of p to the polyhedron and the unit direction away from it, in the polyhedron's coordinates. */
static double distance_to(const pinch_convex *convex, const double *p, double *away)
{
    double deepest = -DBL_MAX, nearest2 = DBL_MAX;
    const unsigned *polygon = convex->polygons;
    bool outside = false;
    for (unsigned f = 0; f < convex->plane_count; f++, polygon += polygon[0] + 1) {
        const double *plane = convex->planes + 4 * f;
        double s = plane_distance(plane, p);
        if (s > deepest && !outside) {
            deepest = s;
            pinch_v3_copy(away, plane);
        }
        if (s <= 0) continue;
        outside = true;
        double nearest[3], from[3];
        nearest_on_face(convex, plane, polygon, p, nearest);
        pinch_v3_sub(p, nearest, from);
        double distance2 = pinch_v3_dot(from, from);
        if (distance2 >= nearest2) continue;
        nearest2 = distance2;
        double distance = sqrt(distance2);
        /* hardly outside, the difference of the points has no direction left: the face's own normal has */
        if (distance > 0.5 * s && distance > 1e-12)
            pinch_v3_copy(away, from);
        else
            pinch_v3_copy(away, plane);
        pinch_v3_scale(away, 1 / pinch_v3_norm(away));
    }
    return outside ? sqrt(nearest2) : deepest;
}

int pinch_collide_sphere_convex(dGeomID sphere, dGeomID convex_geom, const pinch_convex *convex, dContactGeom *contact)
{
    const double *centre = dGeomGetPosition(sphere), *origin = dGeomGetPosition(convex_geom);
    const double *R = dGeomGetRotation(convex_geom);
    double from[3], local[3], away[3] = {0, 0, 1};
    pinch_v3_sub(centre, origin, from);
    for (int i = 0; i < 3; i++) local[i] = R[i] * from[0] + R[4 + i] * from[1] + R[8 + i] * from[2];
    double radius = dGeomSphereGetRadius(sphere), depth = radius - distance_to(convex, local, away);
    if (!(depth >= 0)) return 0;

    memset(contact, 0, sizeof *contact);
    for (int i = 0; i < 3; i++) contact->normal[i] = pinch_v3_dot(R + 4 * i, away);
    for (int i = 0; i < 3; i++) contact->pos[i] = centre[i] - (radius - 0.5 * depth) * contact->normal[i];
    contact->depth = depth;
    contact->g1 = sphere;
    contact->g2 = convex_geom;
    contact->side1 = contact->side2 = -1;
    return 1;
}
