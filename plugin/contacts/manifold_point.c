#include "contacts/manifold_point.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

static inline void to_local(const pinch_pose *pose, const double *world, double *local)
{
    const double *R = pose->rotation;
    double d[3];
    pinch_v3_sub(world, pose->position, d);
    for (int i = 0; i < 3; i++) local[i] = R[i] * d[0] + R[4 + i] * d[1] + R[8 + i] * d[2];
}

static inline void rotate(const pinch_pose *pose, const double *local, double *world)
{
    for (int i = 0; i < 3; i++) world[i] = pinch_v3_dot(pose->rotation + 4 * i, local);
}

static inline void rotate_back(const pinch_pose *pose, const double *world, double *local)
{
    const double *R = pose->rotation;
    for (int i = 0; i < 3; i++) local[i] = R[i] * world[0] + R[4 + i] * world[1] + R[8 + i] * world[2];
}

static inline void find_anchors(const pinch_pose pose[2], const double *position, const double *normal, double depth,
                                double anchor[2][3])
{
    for (int side = 0; side < 2; side++) {
        double touching[3];
        pinch_v3_copy(touching, position);
        pinch_v3_add_scaled(touching, (side ? 0.5 : -0.5) * depth, normal);
        to_local(&pose[side], touching, anchor[side]);
    }
}

void pinch_point_anchor(const pinch_pose pose[2], pinch_detected_point *detected)
{
    find_anchors(pose, detected->position, detected->normal, detected->depth, detected->anchor);
}

void pinch_point_set_geometry(pinch_manifold_point *p, const pinch_pose pose[2], const pinch_detected_point *detected)
{
    memcpy(p->anchor, detected->anchor, sizeof p->anchor);
    for (int side = 0; side < 2; side++) rotate_back(&pose[side], detected->normal, p->seen_normal[side]);
    pinch_v3_copy(p->position, detected->position);
    pinch_v3_copy(p->normal, detected->normal);
    p->depth = detected->depth;
}

/* Finds the place half way between the touching points that the bodies carry along, and the gap from body 1's to body
 * 2's. */
static inline void carried_position(const pinch_manifold_point *p, const pinch_pose pose[2], double *position,
                                    double *gap)
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
 * point that goes on keeps the convention it had: its detected position is moved by the multiple of half the depth that
 * brings it to where the point was carried, when one clearly does. That can be told only while the depth is steady. On
 * a ball there is no convention. Returns whether the point is elsewhere than detected.
 */
static inline bool restore_convention(const pinch_manifold_point *p, const double *carried,
                                      const pinch_detected_point *detected, double *restored)
{
    static const double CLEARLY = 0.05; /* of the depth */
    double away[3], half = 0.5 * detected->depth;
    pinch_v3_copy(restored, detected->position);
    if (detected->on_ball || !(fabs(detected->depth - p->depth) < CLEARLY * detected->depth)) return false;
    pinch_v3_sub(carried, detected->position, away);
    double along = pinch_v3_dot(away, detected->normal), halves = nearbyint(along / half);
    if (halves == 0 || !(fabs(halves) <= 2) || !(fabs(along - halves * half) < CLEARLY * detected->depth)) return false;
    pinch_v3_add_scaled(restored, halves * half, detected->normal);
    return true;
}

/*
 * Bodies that have not moved against each other since the last step, but for rounding, have not moved their points: the
 * detected point goes to where the bodies carried the known one, and takes its depth from there. Where that is not the
 * collider's depth, the collider means another point. Returns whether the point has gone there.
 */
static bool stay_put(const pinch_manifold_point *p, const double *carried, const double *gap, double steady_distance,
                     const double *normal, double *detected_position, double *detected_depth)
{
    static const double ANOTHER = 1e4; /* times the steady distance */
    double moved[3];
    if (!(steady_distance > 0)) return false;
    pinch_v3_copy(moved, gap);
    pinch_v3_add_scaled(moved, -p->depth, p->normal);
    double depth = pinch_v3_dot(gap, normal);
    if (!(pinch_v3_dot(moved, moved) < steady_distance * steady_distance &&
          fabs(depth - *detected_depth) < ANOTHER * steady_distance))
        return false;
    pinch_v3_copy(detected_position, carried);
    *detected_depth = depth;
    return true;
}

bool pinch_point_lies_still(const pinch_manifold_point *p, const pinch_pose pose[2], double distance)
{
    double position[3], moved[3];
    carried_position(p, pose, position, moved);
    pinch_v3_add_scaled(moved, -p->depth, p->normal);
    return pinch_v3_dot(moved, moved) < distance * distance;
}

/* Rotates a point's vectors with its normal. One that has not turned leaves them as they are, to the bit. */
static inline void turn_with_normal(pinch_manifold_point *p, const double *old_normal)
{
    const double *normal = p->normal;
    if (normal[0] == old_normal[0] && normal[1] == old_normal[1] && normal[2] == old_normal[2]) return;
    const pinch_v3_turn turn = pinch_v3_turn_between(old_normal, normal);
    pinch_v3_rotate(&turn, p->elastic);
    pinch_v3_rotate(&turn, p->friction);
    if (p->locks) pinch_v3_rotate(&turn, p->own->locked);
    pinch_rolling *rolling = pinch_rolling_of(p);
    if (!rolling) return;
    pinch_v3_rotate(&turn, rolling->rolled);
    pinch_v3_rotate(&turn, rolling->moment);
}

/* Where a point was when the last step was solved. */
typedef struct known_place {
    double position[3], normal[3], depth;
} known_place;

static inline known_place place_of(const pinch_manifold_point *p)
{
    known_place k = {.depth = p->depth};
    pinch_v3_copy(k.position, p->position);
    pinch_v3_copy(k.normal, p->normal);
    return k;
}

/*
 * Adds to the shear of the last step what the contact's own motion makes of it. The step summed up h P w with the
 * relative velocity w and the projector P onto the tangent plane at the place that it knew, which is the rule of the
 * left end: to and fro over the same path it leaves an error of the order of h behind each time. The mean of both ends,
 * (h/2) (P w + P' w'), leaves none of that order. Here comes what is in it of the contact's new place and normal, the
 * bodies' motion comes in history.c: w' has the relative turn times the way of the contact, and of the part of w along
 * the old normal, which is the rate of the depth, P' makes a part of the new tangent plane.
 */
static inline void add_rolling(pinch_manifold_point *p, const known_place *from, const double *turned)
{
    double way[3], shear[3], tilt[3];
    if (p->twist == 0 && p->elastic[0] == 0 && p->elastic[1] == 0 && p->elastic[2] == 0) return;
    pinch_v3_sub(p->position, from->position, way);
    pinch_v3_cross(turned, way, shear);
    pinch_v3_add_scaled(shear, from->depth - p->depth, from->normal);
    pinch_v3_make_perpendicular(shear, p->normal);
    pinch_v3_add_scaled(p->elastic, 0.5, shear);
    pinch_v3_sub(p->normal, from->normal, tilt);
    p->twist += 0.5 * pinch_v3_dot(turned, tilt);
}

void pinch_point_continue(pinch_manifold_point *p, const pinch_pose pose[2], const pinch_manifold_rules *rules,
                          const pinch_detected_point *detected)
{
    known_place from = place_of(p);
    double carried[3] = {0, 0, 0}, gap[3] = {0, 0, 0}, position[3], depth = detected->depth;
    if (!detected->on_ball || rules->steady_distance > 0) carried_position(p, pose, carried, gap); /* who asks for it */
    bool restored = restore_convention(p, carried, detected, position);
    bool stays = stay_put(p, carried, gap, rules->steady_distance, detected->normal, position, &depth);
    pinch_point_set_geometry(p, pose, detected);
    if (restored || stays) {
        find_anchors(pose, position, detected->normal, depth, p->anchor);
        pinch_v3_copy(p->position, position);
        p->depth = depth;
    }
    turn_with_normal(p, from.normal);
    add_rolling(p, &from, rules->turned);
}

double pinch_across2(const double *way, const double *normal, double overlap)
{
    double along = fabs(pinch_v3_dot(way, normal)), half = 0.5 * fmax(overlap, 0);
    double counts = fmin(along, fmin(fabs(along - half), fabs(along - 2 * half)));
    return fmax(pinch_v3_dot(way, way) - along * along, 0) + counts * counts;
}

double pinch_detected_apart(const pinch_detected_point *a, const pinch_detected_point *b)
{
    static const double NEARLY = 0.05; /* of the depth */
    const pinch_detected_point *deeper = a->depth > b->depth ? a : b;
    double way[3], depth = deeper->depth;
    if (pinch_on_other_face(a->normal, b->normal)) return DBL_MAX;
    pinch_v3_sub(a->position, b->position, way);
    double along = fabs(pinch_v3_dot(way, deeper->normal));
    bool on_either = fabs(along - depth) < NEARLY * depth;
    return sqrt(on_either ? pinch_across2(way, deeper->normal, along) : pinch_v3_dot(way, way));
}

/* Returns the smaller of the two anchors' squared ways, of which `overlap` along the normal does not count. */
static double distance2(const pinch_manifold_point *p, const pinch_detected_point *detected, double overlap)
{
    double best = DBL_MAX;
    if (pinch_on_other_face(p->normal, detected->normal)) return best;
    for (int side = 0; side < 2; side++) {
        double apart[3];
        pinch_v3_sub(detected->anchor[side], p->anchor[side], apart);
        double d2 = overlap > 0 ? pinch_across2(apart, p->seen_normal[side], overlap) : pinch_v3_dot(apart, apart);
        if (d2 < best) best = d2;
    }
    return best;
}

double pinch_point_distance2(const pinch_manifold_point *p, const pinch_detected_point *detected)
{
    return distance2(p, detected, 0);
}

double pinch_point_distance2_across(const pinch_manifold_point *p, const pinch_detected_point *detected)
{
    return distance2(p, detected, fmax(p->depth, detected->depth));
}

/* Returns 1 up to half of a limit, and falls to 0 at it. */
static double fading(double value, double limit)
{
    if (!(value > 0.5 * limit)) return 1;
    return limit > 0 ? fmax(2 * (1 - value / limit), 0) : 0;
}

static bool follow_anchors(pinch_manifold_point *p, const pinch_pose pose[2], const pinch_manifold_rules *rules,
                           double slack)
{
    double touching[2][3], normal[2][3], tilt[3], gap[3];
    for (int side = 0; side < 2; side++) {
        rotate(&pose[side], p->anchor[side], touching[side]);
        pinch_v3_add_scaled(touching[side], 1, pose[side].position);
        rotate(&pose[side], p->seen_normal[side], normal[side]);
    }
    pinch_v3_cross(normal[0], normal[1], tilt);
    if (pinch_v3_norm(tilt) > rules->stale_tilt || pinch_v3_dot(normal[0], normal[1]) <= 0) return false;
    for (int i = 0; i < 3; i++) {
        p->normal[i] = normal[0][i] + normal[1][i];
        p->position[i] = 0.5 * (touching[0][i] + touching[1][i]);
    }
    pinch_v3_scale(p->normal, 1 / pinch_v3_norm(p->normal));
    pinch_v3_sub(touching[1], touching[0], gap);
    p->depth = pinch_v3_dot(gap, p->normal);
    pinch_v3_add_scaled(gap, -p->depth, p->normal);
    if (rules->shared)
        p->weight = fmin(fading(-p->depth, slack), fmin(fading(pinch_v3_norm(tilt), rules->stale_tilt),
                                                        fading(pinch_v3_norm(gap), rules->merge_distance)));
    return p->depth > -slack && pinch_v3_dot(gap, gap) <= rules->merge_distance * rules->merge_distance;
}

bool pinch_point_refresh(pinch_manifold_point *p, const pinch_pose pose[2], const pinch_manifold_rules *rules,
                         double slack)
{
    known_place from = place_of(p);
    bool touches = follow_anchors(p, pose, rules, slack);
    turn_with_normal(p, from.normal);
    add_rolling(p, &from, rules->turned);
    return touches;
}
