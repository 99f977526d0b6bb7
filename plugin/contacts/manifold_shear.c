#include "contacts/manifold_shear.h"

#include "support/vec3.h"

#include <string.h>

pinch_shear_state pinch_shear_of(const pinch_manifold_point *points, int count)
{
    pinch_shear_state s;
    memset(&s, 0, sizeof s);
    for (int k = 0; k < count; k++) {
        pinch_v3_add_scaled(s.centre, 1.0 / count, points[k].position);
        pinch_v3_add_scaled(s.normal, 1, points[k].normal);
        pinch_v3_add_scaled(s.mean, 1.0 / count, points[k].elastic);
        s.twist += points[k].twist / count;
    }
    double length = pinch_v3_norm(s.normal);
    if (length > 0) pinch_v3_scale(s.normal, 1 / length);
    for (int k = 0; k < count; k++) {
        double arm[3], turned[3];
        pinch_v3_sub(points[k].position, s.centre, arm);
        pinch_v3_make_perpendicular(arm, s.normal);
        pinch_v3_cross(arm, points[k].elastic, turned);
        s.moment += pinch_v3_dot(turned, s.normal) / count;
        s.radius2 += pinch_v3_dot(arm, arm) / count;
    }
    return s;
}

/* elastic += shift + angle normal x (position - centre), kept in the point's own tangent plane */
static void add_rigid_shear(pinch_manifold_point *p, const pinch_shear_state *about, const double *shift, double angle)
{
    double arm[3], turned[3];
    pinch_v3_sub(p->position, about->centre, arm);
    pinch_v3_cross(about->normal, arm, turned);
    pinch_v3_add_scaled(p->elastic, 1, shift);
    pinch_v3_add_scaled(p->elastic, angle, turned);
    pinch_v3_make_perpendicular(p->elastic, p->normal);
}

static double rigid_angle(double moment, double radius2, double merge_distance)
{
    /* points that nearly coincide carry no moment by their shear */
    return radius2 > 1e-4 * merge_distance * merge_distance ? moment / radius2 : 0;
}

void pinch_shear_carry_over(pinch_manifold *m, int added, const pinch_shear_state *old, double merge_distance)
{
    double old_angle = rigid_angle(old->moment, old->radius2, merge_distance);
    for (int k = m->count - added; k < m->count; k++) {
        add_rigid_shear(&m->point[k], old, old->mean, old_angle);
        m->point[k].twist = old->twist;
    }
    pinch_shear_state now = pinch_shear_of(m->point, m->count);
    double shift[3], arm[3], offset[3];
    pinch_v3_sub(old->mean, now.mean, shift);
    pinch_v3_sub(now.centre, old->centre, arm);
    pinch_v3_cross(arm, old->mean, offset);
    double missing = old->moment - pinch_v3_dot(offset, old->normal) - now.moment;
    double angle = rigid_angle(missing, now.radius2, merge_distance);
    for (int k = 0; k < m->count; k++) {
        add_rigid_shear(&m->point[k], &now, shift, angle);
        m->point[k].twist += old->twist - now.twist;
    }
}
