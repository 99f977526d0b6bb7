#include "contacts/manifold_point.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>

static void to_local(const pinch_pose *pose, const double *world, double *local)
{
    const double *R = pose->rotation;
    double d[3];
    pinch_v3_sub(world, pose->position, d);
    for (int i = 0; i < 3; i++) local[i] = R[i] * d[0] + R[4 + i] * d[1] + R[8 + i] * d[2];
}

static void rotate(const pinch_pose *pose, const double *local, double *world)
{
    for (int i = 0; i < 3; i++) world[i] = pinch_v3_dot(pose->rotation + 4 * i, local);
}

static void rotate_back(const pinch_pose *pose, const double *world, double *local)
{
    const double *R = pose->rotation;
    for (int i = 0; i < 3; i++) local[i] = R[i] * world[0] + R[4 + i] * world[1] + R[8 + i] * world[2];
}

void pinch_point_set_geometry(pinch_manifold_point *p, const pinch_pose pose[2], const pinch_fresh_point *fresh)
{
    for (int side = 0; side < 2; side++) {
        double touching[3];
        pinch_v3_copy(touching, fresh->position);
        pinch_v3_add_scaled(touching, (side ? 0.5 : -0.5) * fresh->depth, fresh->normal);
        to_local(&pose[side], touching, p->anchor[side]);
        rotate_back(&pose[side], fresh->normal, p->seen_normal[side]);
    }
    pinch_v3_copy(p->position, fresh->position);
    pinch_v3_copy(p->normal, fresh->normal);
    p->depth = fresh->depth;
}

/* Half way between the touching points that the bodies carry along; gap: from body 1's to body 2's. */
static void carried_position(const pinch_manifold_point *p, const pinch_pose pose[2], double *position, double *gap)
{
    for (int i = 0; i < 3; i++) position[i] = gap[i] = 0;
    for (int side = 0; side < 2; side++) {
        double touching[3];
        rotate(&pose[side], p->anchor[side], touching);
        pinch_v3_add_scaled(touching, 1, pose[side].position);
        pinch_v3_add_scaled(position, 0.5, touching);
        pinch_v3_add_scaled(gap, side ? 1 : -1, touching);
    }
}

/*
 * Where along the normal a collider puts a point is a convention: on either surface or half way. ODE's box-box changes
 * it from step to step when the faces are parallel to rounding, and with it the lever arm of the friction force. A
 * point that goes on keeps the convention it had: its fresh position is moved by the multiple of half the depth that
 * brings it to where the point was carried, when one clearly does. That can be told only while the depth is steady.
 */
static pinch_fresh_point settle_position(const pinch_manifold_point *p, const pinch_pose pose[2],
                                         const pinch_fresh_point *fresh)
{
    static const double CLEARLY = 0.05; /* of the depth */
    pinch_fresh_point settled = *fresh;
    double away[3], gap[3], half = 0.5 * fresh->depth;
    if (!(fabs(fresh->depth - p->depth) < CLEARLY * fresh->depth)) return settled;
    carried_position(p, pose, away, gap);
    pinch_v3_sub(away, fresh->position, away);
    double along = pinch_v3_dot(away, fresh->normal), halves = nearbyint(along / half);
    if (fabs(halves) <= 2 && fabs(along - halves * half) < CLEARLY * fresh->depth)
        pinch_v3_add_scaled(settled.position, halves * half, fresh->normal);
    return settled;
}

/*
 * Bodies that have not moved against each other since the last step, but for rounding, have not moved their points: the
 * fresh point goes to where the bodies carried the known one, and has its depth from there. Where that is not the
 * collider's depth, it has another point in mind.
 */
static void stay_put(const pinch_manifold_point *p, const pinch_pose pose[2], double steady, pinch_fresh_point *fresh)
{
    static const double ANOTHER = 1e4; /* times `steady` */
    double position[3], gap[3], moved[3];
    if (!(steady > 0)) return;
    carried_position(p, pose, position, gap);
    pinch_v3_copy(moved, gap);
    pinch_v3_add_scaled(moved, -p->depth, p->normal);
    double depth = pinch_v3_dot(gap, fresh->normal);
    if (!(pinch_v3_dot(moved, moved) < steady * steady && fabs(depth - fresh->depth) < ANOTHER * steady)) return;
    pinch_v3_copy(fresh->position, position);
    fresh->depth = depth;
}

/* A point's vectors turn with its normal. */
static void turn_with_normal(pinch_manifold_point *p, const double *old_normal)
{
    pinch_v3_rotate_from_to(old_normal, p->normal, p->elastic);
    pinch_v3_rotate_from_to(old_normal, p->normal, p->friction);
    pinch_rolling *rolling = pinch_rolling_of(p);
    if (!rolling) return;
    pinch_v3_rotate_from_to(old_normal, p->normal, rolling->rolled);
    pinch_v3_rotate_from_to(old_normal, p->normal, rolling->moment);
}

void pinch_point_continue(pinch_manifold_point *p, const pinch_pose pose[2], double steady,
                          const pinch_fresh_point *fresh)
{
    double old_normal[3];
    pinch_v3_copy(old_normal, p->normal);
    pinch_fresh_point settled = settle_position(p, pose, fresh);
    stay_put(p, pose, steady, &settled);
    pinch_point_set_geometry(p, pose, &settled);
    turn_with_normal(p, old_normal);
}

double pinch_point_distance2(const pinch_manifold_point *p, const pinch_pose pose[2], const pinch_fresh_point *fresh)
{
    double best = DBL_MAX;
    for (int side = 0; side < 2; side++) {
        double touching[3], local[3];
        pinch_v3_copy(touching, fresh->position);
        pinch_v3_add_scaled(touching, (side ? 0.5 : -0.5) * fresh->depth, fresh->normal);
        to_local(&pose[side], touching, local);
        pinch_v3_sub(local, p->anchor[side], local);
        double d2 = pinch_v3_dot(local, local);
        if (d2 < best) best = d2;
    }
    return best;
}

static bool follow_anchors(pinch_manifold_point *p, const pinch_pose pose[2], double merge_distance, double stale_tilt,
                           double slack)
{
    double touching[2][3], normal[2][3], tilt[3], gap[3];
    for (int side = 0; side < 2; side++) {
        rotate(&pose[side], p->anchor[side], touching[side]);
        pinch_v3_add_scaled(touching[side], 1, pose[side].position);
        rotate(&pose[side], p->seen_normal[side], normal[side]);
    }
    pinch_v3_cross(normal[0], normal[1], tilt);
    if (pinch_v3_norm(tilt) > stale_tilt || pinch_v3_dot(normal[0], normal[1]) <= 0) return false;
    for (int i = 0; i < 3; i++) {
        p->normal[i] = normal[0][i] + normal[1][i];
        p->position[i] = 0.5 * (touching[0][i] + touching[1][i]);
    }
    pinch_v3_scale(p->normal, 1 / pinch_v3_norm(p->normal));
    pinch_v3_sub(touching[1], touching[0], gap);
    p->depth = pinch_v3_dot(gap, p->normal);
    pinch_v3_add_scaled(gap, -p->depth, p->normal);
    return p->depth > -slack && pinch_v3_dot(gap, gap) <= merge_distance * merge_distance;
}

bool pinch_point_refresh(pinch_manifold_point *p, const pinch_pose pose[2], double merge_distance, double stale_tilt,
                         double slack)
{
    double old_normal[3];
    pinch_v3_copy(old_normal, p->normal);
    bool touches = follow_anchors(p, pose, merge_distance, stale_tilt, slack);
    turn_with_normal(p, old_normal);
    return touches;
}
