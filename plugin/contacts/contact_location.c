/*
 * Where a contact point lies along the normal. Two undeformed bodies overlap by the depth; the stiffer they are, the
 * less of it they give, and a rigid one gives nothing: what touches is its surface. Colliders know no sides, and each
 * puts its points where it likes: on either surface, half way, at the centre of a ball that is deep inside. So the
 * place is measured, on the geoms themselves: how far the line through the point along the normal goes on inside each.
 *
 * Not between two flat faces. With d from one touching point to the other, the velocity at the point is the rate of d
 * in the axes of the body whose surface the point is NOT on; the shear that adds up is a function of the pose only
 * where the normal is fixed in those axes, too. A round object between pads has the pads' normal and the point on
 * itself: both agree. Of two faces the collider takes the normal of one and points of the other, which agrees as it is;
 * put on the rigid face, they came back from ten turns of gravity turned by 4e-9 rad instead of 1e-11.
 */
#include "plugin.h"

#include "support/vec3.h"

#include <pinch/fingertip.h>

#include <float.h>
#include <math.h>

/* Part of the line x + t d in a body, as parameters; empty where from > to. */
typedef struct stretch {
    double from, to;
} stretch;

static const stretch WHOLE = {-DBL_MAX, DBL_MAX}, NONE = {1, 0};

static stretch common(stretch a, stretch b)
{
    return (stretch){fmax(a.from, b.from), fmin(a.to, b.to)};
}

/* |x + t d| <= half in one coordinate. A line along the slab's face stays in it, rounding or not: points lie there. */
static stretch in_slab(double x, double d, double half)
{
    static const double PARALLEL = 1e-9, NEARLY = 1e-6;
    if (fabs(d) < PARALLEL) return fabs(x) <= (1 + NEARLY) * half ? WHOLE : NONE;
    double a = (-half - x) / d, b = (half - x) / d;
    return (stretch){fmin(a, b), fmax(a, b)};
}

/* The first `axes` coordinates of x + t d in a ball of that many dimensions. */
static stretch in_ball(const double *x, const double *d, int axes, double radius)
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

/* Of ODE's geoms that are convex and whose size it tells; false for others. */
static bool line_in(dGeomID geom, const double *point, const double *direction, stretch *within)
{
    int class = dGeomGetClass(geom);
    double x[3], d[3], from[3], radius, length;
    dVector3 sides;
    if (class == dPlaneClass) {
        *within = in_plane(geom, point, direction);
        return true;
    }
    if (class != dSphereClass && class != dBoxClass && class != dCapsuleClass && class != dCylinderClass) return false;
    const double *R = dGeomGetRotation(geom);
    pinch_v3_sub(point, dGeomGetPosition(geom), from);
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

static bool is_faceted(dGeomID geom)
{
    int class = dGeomGetClass(geom);
    const pinch_tip *tip = pinch_tip_of(geom);
    return class == dBoxClass || class == dConvexClass || class == dTriMeshClass || class == dPlaneClass ||
           (tip && (tip->type == PINCH_TIP_BOX || tip->type == PINCH_TIP_CONVEX));
}

bool pinch_place_as_found(const pinch_geom_record *a, const pinch_geom_record *b)
{
    return is_faceted(a->geom) && is_faceted(b->geom);
}

static const double SLACK = 0.5; /* of the depth: more than that off, and the collider means something else */

/* What a ball touches with lies at its radius from its centre along the normal: no need to look at the other geom.
 * sign: 1 for the pair's first geom, which the normal points into. */
static bool place_on_ball(dGeomID ball, double sign, pinch_fresh_point *fresh)
{
    double out[3];
    if (dGeomGetClass(ball) != dSphereClass) return false;
    pinch_v3_sub(dGeomGetPosition(ball), fresh->position, out);
    double touching = dGeomSphereGetRadius(ball) - 0.5 * fresh->depth;
    double move = pinch_v3_dot(out, fresh->normal) - sign * touching;
    if (fabs(move) <= 0.5 * (1 + SLACK) * fresh->depth) pinch_v3_add_scaled(fresh->position, move, fresh->normal);
    return true;
}

void pinch_place_half_way(const pinch_geom_record *a, const pinch_geom_record *b, pinch_fresh_point *fresh)
{
    if (place_on_ball(a->geom, 1, fresh) || place_on_ball(b->geom, -1, fresh)) return;
    stretch in_a, in_b;
    bool known_a = line_in(a->geom, fresh->position, fresh->normal, &in_a) && in_a.from <= in_a.to;
    bool known_b = line_in(b->geom, fresh->position, fresh->normal, &in_b) && in_b.from <= in_b.to;
    if ((!known_a && !known_b) || !(fresh->depth > 0)) return;
    double back = known_a ? -in_a.from : fresh->depth - in_b.to; /* to a's surface, which faces against the normal */
    double on = known_b ? in_b.to : fresh->depth - back;
    double low = fmin(back, on);
    if (!(fabs(back + on - fresh->depth) <= SLACK * fresh->depth) || low < -SLACK * fresh->depth) return;
    pinch_v3_add_scaled(fresh->position, 0.5 * (on - back), fresh->normal);
}
