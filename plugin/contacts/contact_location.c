/*
 * Where a contact point lies along the normal.
 *
 * Two undeformed bodies overlap by the depth. The stiffer a body is, the less of the depth it gives; a rigid one gives
 * nothing, and contact happens at its surface. Colliders know no stiffness, and each puts its points where it likes: on
 * either surface, half way, at the centre of a ball that is deep inside. So the place is measured on the geoms: how far
 * the line through the point along the normal goes on inside each of them.
 *
 * Points between two flat faces stay where they are. With d from one touching point to the other, the velocity at the
 * point is the rate of d in the axes of the body whose surface the point is NOT on. The shear that adds up is a
 * function of the pose only where the normal is fixed in those axes, too. A round object between pads has the pads'
 * normal and the point on itself, so both agree. Of two faces the collider takes the normal of one and the points of
 * the other, which agrees as it is. Put on the rigid face, they came back from ten turns of gravity turned by 4e-9 rad
 * instead of 1e-11.
 */
#include "contacts/collider_points.h"

#include "support/extremes.h"
#include "support/vec3.h"

#include <pinch/fingertip.h>

#include <float.h>
#include <math.h>

/* The part of the line x + t d that lies in a body, by its parameters. It is empty where from > to. */
typedef struct stretch {
    double from, to;
} stretch;

static const stretch WHOLE = {-DBL_MAX, DBL_MAX}, NONE = {1, 0};

static inline stretch common(stretch a, stretch b)
{
    return (stretch){pinch_larger(a.from, b.from), pinch_smaller(a.to, b.to)};
}

/* Returns where |x + t d| <= half in one coordinate. A line along the slab's face lies in it whatever rounding says,
 * because contact points lie there. */
static inline stretch in_slab(double x, double d, double half)
{
    static const double PARALLEL = 1e-9, NEARLY = 1e-6;
    if (fabs(d) < PARALLEL) return fabs(x) <= (1 + NEARLY) * half ? WHOLE : NONE;
    double a = (-half - x) / d, b = (half - x) / d;
    return (stretch){pinch_smaller(a, b), pinch_larger(a, b)};
}

/* Returns where the first `axes` coordinates of x + t d lie in a ball of that many dimensions. */
static inline stretch in_ball(const double *x, const double *d, int axes, double radius)
{
    double a = 0, b = 0, c = -radius * radius;
    for (int i = 0; i < axes; i++) {
        a += d[i] * d[i];
        b += x[i] * d[i];
        c += x[i] * x[i];
    }
    if (a < DBL_EPSILON) return c <= 1e-6 * radius * radius ? WHOLE : NONE;
    double under_root = b * b - a * c;
    if (under_root < 0) return NONE;
    double root = sqrt(under_root);
    return (stretch){(-b - root) / a, (-b + root) / a};
}

static stretch in_capsule(const double *x, const double *d, double radius, double half)
{
    stretch within = common(in_ball(x, d, 2, radius), in_slab(x[2], d[2], half));
    for (int end = -1; end <= 1; end += 2) { /* the union of the parts, which is connected */
        const double from_end[3] = {x[0], x[1], x[2] - end * half};
        stretch ball = in_ball(from_end, d, 3, radius);
        if (ball.from > ball.to) continue;
        bool empty = within.from > within.to;
        within.from = empty ? ball.from : fmin(within.from, ball.from);
        within.to = empty ? ball.to : fmax(within.to, ball.to);
    }
    return within;
}

static stretch in_plane(dGeomID plane, const double *x, const double *d)
{
    dVector4 p;
    dGeomPlaneGetParams(plane, p);
    double along = pinch_v3_dot(p, d), above = pinch_v3_dot(p, x) - p[3];
    if (fabs(along) < DBL_EPSILON) return above <= 0 ? WHOLE : NONE;
    double meets = -above / along;
    return along < 0 ? (stretch){meets, DBL_MAX} : (stretch){-DBL_MAX, meets};
}

/* Finds the part of a line that lies in a geom, for convex geoms whose size ODE tells. Returns false for others. */
static bool line_in(dGeomID geom, int class, const pinch_pose *pose, const double *point, const double *direction,
                    stretch *within)
{
    double x[3], d[3], from[3], radius, length;
    dVector3 sides;
    if (class == dPlaneClass) {
        *within = in_plane(geom, point, direction);
        return true;
    }
    if (class != dSphereClass && class != dBoxClass && class != dCapsuleClass && class != dCylinderClass) return false;
    const double *R = pose->rotation;
    pinch_v3_sub(point, pose->position, from);
    for (int i = 0; i < 3; i++) {
        x[i] = R[i] * from[0] + R[4 + i] * from[1] + R[8 + i] * from[2];
        d[i] = R[i] * direction[0] + R[4 + i] * direction[1] + R[8 + i] * direction[2];
    }
    if (class == dSphereClass) {
        *within = in_ball(x, d, 3, dGeomSphereGetRadius(geom));
    } else if (class == dBoxClass) {
        dGeomBoxGetLengths(geom, sides);
        *within = WHOLE;
        for (int i = 0; i < 3; i++) *within = common(*within, in_slab(x[i], d[i], 0.5 * sides[i]));
    } else if (class == dCapsuleClass) {
        dGeomCapsuleGetParams(geom, &radius, &length);
        *within = in_capsule(x, d, radius, 0.5 * length);
    } else {
        dGeomCylinderGetParams(geom, &radius, &length);
        *within = common(in_ball(x, d, 2, radius), in_slab(x[2], d[2], 0.5 * length));
    }
    return true;
}

static bool is_faceted(dGeomID geom, int class)
{
    static const unsigned FACETED = 1u << dBoxClass | 1u << dConvexClass | 1u << dTriMeshClass | 1u << dPlaneClass;
    if (class < dFirstUserClass) return FACETED >> class & 1u;
    const pinch_tip *tip = pinch_tip_of(geom);
    return tip && (tip->type == PINCH_TIP_BOX || tip->type == PINCH_TIP_CONVEX);
}

bool pinch_both_faceted(dGeomID a, dGeomID b)
{
    return a && b && is_faceted(a, dGeomGetClass(a)) && is_faceted(b, dGeomGetClass(b));
}

/* A point that is off by more than this part of the depth means something else. */
static const double SLACK = 0.5;

/* A ball touches at its radius from its centre along the normal, whatever the other geom is. sign: 1 for the pair's
 * first geom, which the normal points into. Returns false for another shape. */
static inline bool place_on_ball(dGeomID ball, int class, const pinch_pose *pose, double sign,
                                 pinch_detected_point *detected)
{
    double out[3];
    if (class != dSphereClass) return false;
    pinch_v3_sub(pose->position, detected->position, out);
    double touching = dGeomSphereGetRadius(ball) - 0.5 * detected->depth;
    double move = pinch_v3_dot(out, detected->normal) - sign * touching;
    detected->on_ball = fabs(move) <= 0.5 * (1 + SLACK) * detected->depth;
    if (detected->on_ball) pinch_v3_add_scaled(detected->position, move, detected->normal);
    return true;
}

void pinch_locate_contact(const dGeomID geom[2], const int class[2], const pinch_pose pose[2],
                          pinch_detected_point *detected)
{
    if (place_on_ball(geom[0], class[0], &pose[0], 1, detected) ||
        place_on_ball(geom[1], class[1], &pose[1], -1, detected))
        return;
    if (is_faceted(geom[0], class[0]) && is_faceted(geom[1], class[1])) return;
    stretch in_a, in_b;
    const double *position = detected->position, *normal = detected->normal;
    bool known_a = line_in(geom[0], class[0], &pose[0], position, normal, &in_a) && in_a.from <= in_a.to;
    bool known_b = line_in(geom[1], class[1], &pose[1], position, normal, &in_b) && in_b.from <= in_b.to;
    if ((!known_a && !known_b) || !(detected->depth > 0)) return;
    double back = known_a ? -in_a.from : detected->depth - in_b.to; /* to a's surface, which faces against the normal */
    double on = known_b ? in_b.to : detected->depth - back;
    double low = pinch_smaller(back, on);
    if (!(fabs(back + on - detected->depth) <= SLACK * detected->depth) || low < -SLACK * detected->depth) return;
    pinch_v3_add_scaled(detected->position, 0.5 * (on - back), detected->normal);
}
