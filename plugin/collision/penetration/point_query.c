#include "penetration.h"

#include "support/vec3.h"

#include <float.h>
#include <string.h>

double pinch_signed_distance(const pinch_posed_body *body, int piece, const double point[3], double normal[3])
{
    static const double IDENTITY[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double least = DBL_MAX;
    for (int k = 0; k < body->shape_count; k++) {
        if (piece >= 0 && k != piece) continue;
        const pinch_shape *shape = &body->shapes[k];
        pinch_posed_body at;
        double from[3];
        memcpy(at.R, IDENTITY, sizeof at.R);
        pinch_v3_copy(at.position, point);
        pinch_v3_sub(point, body->position, from);
        memset(&at.own, 0, sizeof at.own);
        at.own.margin = at.own.bound = 2 * (pinch_v3_norm(from) + shape->bound); /* so large that nothing is cut off */
        pinch_shape_pair pair;
        pinch_contact_normal found;
        pinch_least_face faces[2];
        pinch_pair_of(body, shape, &at, &at.own, &pair); /* in the body's axes; the normal points into the body */
        pair.b = &at.own;
        if (!pinch_find_contact_normal(&pair, &found, faces)) continue;
        double distance = -found.overlap - shape->margin;
        if (distance >= least) continue;
        least = distance;
        for (int i = 0; i < 3; i++) normal[i] = -pinch_v3_dot(body->R + 3 * i, found.normal);
    }
    return least;
}

/*
 * From outside, the ray goes on to where it meets the plane through the nearest surface point, again and again. That is
 * Newton's method. The plane keeps all of the body behind it, so nothing is passed by. Returns -1 if there is no hit.
 */
static double ray_enters(const pinch_posed_body *body, int piece, const double *start, const double *direction,
                         double length, double *normal)
{
    enum { MAX_STEPS = 200 };
    double t = 0, x[3], tolerance = 1e-13 * (body->shapes[piece].bound + length);
    for (int k = 0; k < MAX_STEPS; k++) {
        pinch_v3_copy(x, start);
        pinch_v3_add_scaled(x, t, direction);
        double distance = pinch_signed_distance(body, piece, x, normal), closing = -pinch_v3_dot(normal, direction);
        if (distance <= tolerance) return t;
        if (!(closing > 1e-12)) return -1;
        t += distance / closing;
        if (t > length) return -1;
    }
    return t;
}

bool pinch_cast_ray(const pinch_posed_body *body, dGeomID ray, double position[3], double normal[3], double *depth)
{
    dVector3 start, direction;
    double length = dGeomRayGetLength(ray), n[3], end[3], back[3];
    dGeomRayGet(ray, start, direction);
    pinch_v3_copy(end, start);
    pinch_v3_add_scaled(end, length, direction);
    for (int i = 0; i < 3; i++) back[i] = -direction[i];
    *depth = -1;
    for (int k = 0; k < body->shape_count; k++) {
        double t;
        if (pinch_signed_distance(body, k, start, n) > 0) {
            t = ray_enters(body, k, start, direction, length, n);
        } else { /* from inside, the way out is the way in from the ray's other end */
            t = ray_enters(body, k, end, back, length, n);
            t = t > 0 ? length - t : -1;
            pinch_v3_scale(n, -1);
        }
        if (t < 0 || (*depth >= 0 && t >= *depth)) continue;
        *depth = t;
        pinch_v3_copy(normal, n);
    }
    if (*depth < 0) return false;
    pinch_v3_copy(position, start);
    pinch_v3_add_scaled(position, *depth, direction);
    return true;
}
