/* A finger on the object: is its point on the surface, which way are its axes, where is its tip. */

#include "common/vector.h"
#include "load.h"
#include "scenes/shape/shape.h"

/* interfaces: of the object's size, which is taken as the diameter of its bounding sphere */
static const double SURFACE_TOLERANCE = 1e-6;

static bool check_surface(const scene_node *node, const scene_object *object, const scene_finger *finger)
{
    double offset[3], point[3], normal[3];
    scene_subtract(finger->point, object->position, offset);
    scene_rotate_back(object->orientation, offset, point);
    scene_rotate_back(object->orientation, finger->normal, normal);
    double tolerance = SURFACE_TOLERANCE * 2.0 * object->shape.bounding_radius;
    double gap = scene_shape_distance(&object->shape, point);
    if (!(fabs(gap) <= tolerance)) {
        scene_node member = scene_member(node, "point");
        return scene_refuse_plainly(&member, "a point on the object's surface (within %g m), got a gap of %g m %s",
                                    tolerance, fabs(gap), gap > 0.0 ? "outside it" : "inside it");
    }
    if (scene_shape_points_in(&object->shape, point, normal, tolerance)) return true;
    scene_node member = scene_member(node, "normal");
    return scene_refuse_plainly(&member, "a normal that points into the object, got one that points out of it or along "
                                         "its surface");
}

static void least_aligned_axis(const double n[3], double axis[3])
{
    int best = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(n[i]) < fabs(n[best]) - 1e-12) best = i;
    for (int i = 0; i < 3; i++) axis[i] = i == best ? 1.0 : 0.0;
}

/*
 * t1 from `tangent` by Gram-Schmidt, twice: once leaves |t1.n| of the size of rounding over the sine between them. A
 * tangent that is perpendicular already stays as it is, so that a printed scene loads unchanged.
 */
static bool complete_frame(const scene_node *node, scene_finger *finger)
{
    const double *n = finger->normal;
    double *t1 = finger->t1;
    scene_node member = scene_member(node, "tangent");
    if (!scene_read_vector(node, "tangent", SCENE_FREE, "", t1)) return false;
    if (node->reader->dimension == 2) {
        t1[0] = -n[1];
        t1[1] = n[0];
        t1[2] = 0.0;
    } else {
        if (!member.value) least_aligned_axis(n, t1);
        if (!(scene_norm(t1) > 0.0)) return scene_refuse_plainly(&member, "a vector that is not zero");
        scene_normalise(t1, 3);
        for (int pass = 0; pass < 2; pass++) {
            double along = scene_dot(t1, n);
            if (fabs(along) <= 1e-15) break;
            scene_add_scaled(t1, -along, n);
            if (!(scene_norm(t1) > 1e-9))
                return scene_refuse_plainly(&member, "a vector that is not parallel to the normal");
            scene_normalise(t1, 3);
        }
    }
    scene_cross(n, t1, finger->t2);
    return true;
}

/*
 * The smallest rotation that takes +x to n is q ~ (1 + n_x, x cross n). Near -x, 1 + n_x is written without
 * cancellation, and at -x, where any half turn perpendicular to x would do, it is the one about z.
 */
static void smallest_rotation_from_x(const double n[3], double q[4])
{
    double across = hypot(n[1], n[2]);
    if (n[0] < 0.0 && across < 1e-12) {
        q[0] = q[1] = q[2] = 0.0;
        q[3] = 1.0;
        return;
    }
    q[0] = n[0] < 0.0 ? across * across / (1.0 - n[0]) : 1.0 + n[0];
    q[1] = 0.0;
    q[2] = 0.0 - n[2]; /* not -0 */
    q[3] = n[1];
    scene_normalise(q, 4);
}

static bool place_tip(const scene_node *node, scene_finger *finger)
{
    scene_node tip = scene_member(node, "tip");
    double direction[3], support[3], offset[3];
    smallest_rotation_from_x(finger->normal, finger->tip_orientation);
    if (!scene_read_quaternion(&tip, "orientation", finger->tip_orientation)) return false;
    scene_rotate_back(finger->tip_orientation, finger->normal, direction);
    scene_shape_support(&finger->tip, direction, support);
    scene_rotate(finger->tip_orientation, support, offset);
    scene_subtract(finger->point, offset, finger->tip_position);
    return true;
}

bool scene_place_finger(const scene_node *node, const scene_object *object, scene_finger *finger)
{
    return check_surface(node, object, finger) && complete_frame(node, finger) && place_tip(node, finger);
}
