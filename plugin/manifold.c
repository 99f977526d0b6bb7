#include "manifold.h"

#include "support/vec3.h"

#include <float.h>
#include <string.h>

enum { MAX_FRESH = 64 }; /* of one pair in one step; what a collider returns beyond is not looked at */

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

/* The touching points lie half the depth to either side of the contact position: body 1's deepest point is inside body
 * 2, and moving body 1 by depth along the normal brings the two together. */
static void set_geometry(pinch_manifold_point *p, const pinch_pose pose[2], const pinch_fresh_point *fresh)
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

/* Distance from a fresh point to a known one: the smaller of the two anchors' motions, as a point may be fixed on
 * either body and slide over the other. */
static double anchor_distance2(const pinch_manifold_point *p, const pinch_pose pose[2], const pinch_fresh_point *fresh)
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

/*
 * Recomputes a point that the collider did not return from its anchors; false when it is no contact any more. A corner
 * that has lifted by less than the others are pressed in (`slack`) still belongs to the patch: its share of the
 * fingertip's stiffness must not go to the others each time it loses touch.
 */
static bool refresh_stale(pinch_manifold_point *p, const pinch_pose pose[2], double merge_distance, double stale_tilt,
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

/* Is every fresh point behind `point`, seen along `direction`, by more than half a merge distance? */
static bool leads(const double *point, const double *direction, pinch_fresh_point *const *fresh, int count,
                  double merge_distance)
{
    double margin = 0.5 * merge_distance * pinch_v3_norm(direction);
    if (!(margin > 0)) return false;
    for (int i = 0; i < count; i++) {
        double from[3];
        pinch_v3_sub(point, fresh[i]->position, from);
        if (pinch_v3_dot(direction, from) <= margin) return false;
    }
    return true;
}

/* A point that the collider did not return is worth keeping only where it reaches beyond those that it did: the other
 * end of a line, a corner of a face. Among or between them it would take a share of the load that is theirs. */
static bool extends(const pinch_manifold_point *p, pinch_fresh_point *const *fresh, int count, double merge_distance)
{
    double centre[3] = {0, 0, 0}, direction[3];
    if (count == 0) return true;
    for (int i = 0; i < count; i++) {
        pinch_v3_add_scaled(centre, 1.0 / count, fresh[i]->position);
        pinch_v3_sub(p->position, fresh[i]->position, direction);
        pinch_v3_make_perpendicular(direction, p->normal);
        if (leads(p->position, direction, fresh, count, merge_distance)) return true;
    }
    pinch_v3_sub(p->position, centre, direction);
    pinch_v3_make_perpendicular(direction, p->normal);
    return leads(p->position, direction, fresh, count, merge_distance);
}

/* Does the manifold have a point just there? */
static bool is_known(const pinch_manifold *m, const pinch_pose pose[2], const pinch_fresh_point *fresh, double distance)
{
    for (int k = 0; k < m->count; k++)
        if (anchor_distance2(&m->point[k], pose, fresh) < distance * distance) return true;
    return false;
}

/*
 * Where corners of two bodies lie on each other, a collider returns one point or two, as rounding has it. Each point
 * with stiffness of its own carries a share of the load, which must not jump: of twins the deeper one counts. Two that
 * the manifold already has are twins at half the distance only, so that none comes and goes with every step.
 */
static int drop_twins(const pinch_manifold *m, const pinch_pose pose[2], pinch_fresh_point **fresh, int count,
                      double merge_distance)
{
    static const double TWINS = 0.02; /* of the merge distance */
    double limit = TWINS * merge_distance;
    int kept = 0;
    for (int i = 0; i < count; i++) {
        int twin = -1;
        for (int k = 0; k < kept && twin < 0; k++) {
            double d[3];
            pinch_v3_sub(fresh[i]->position, fresh[k]->position, d);
            double apart = pinch_v3_norm(d);
            if (apart < limit && !(apart > 0.5 * limit && is_known(m, pose, fresh[i], 0.25 * limit) &&
                                   is_known(m, pose, fresh[k], 0.25 * limit)))
                twin = k;
        }
        if (twin < 0)
            fresh[kept++] = fresh[i];
        else if (fresh[i]->depth > fresh[twin]->depth)
            fresh[twin] = fresh[i];
    }
    return kept;
}

/* When a collider returns more than the manifold holds: the deepest point, then always the one farthest from those
 * kept. */
static int reduce(pinch_fresh_point **fresh, int count, int most)
{
    if (count <= most) return count;
    double distance2[MAX_FRESH];
    int best = 0;
    for (int i = 0; i < count; i++) {
        distance2[i] = DBL_MAX;
        if (fresh[i]->depth > fresh[best]->depth) best = i;
    }
    for (int kept = 0; kept < most; kept++) {
        pinch_fresh_point *chosen = fresh[best];
        double chosen_distance = distance2[best];
        fresh[best] = fresh[kept];
        distance2[best] = distance2[kept];
        fresh[kept] = chosen;
        distance2[kept] = chosen_distance;
        best = kept + 1;
        for (int i = kept + 1; i < count; i++) {
            double d[3];
            pinch_v3_sub(fresh[i]->position, chosen->position, d);
            distance2[i] = fmin(distance2[i], pinch_v3_dot(d, d));
            if (distance2[i] > distance2[best]) best = i;
        }
    }
    return most;
}

/*
 * The shear state of a set of points that share one stiffness equally, about its centre: mean displacement, mean moment
 * of the displacements about the mean normal, mean twist, mean squared radius.
 */
typedef struct shear_state {
    double centre[3], normal[3], mean[3];
    double moment, twist, radius2;
} shear_state;

static shear_state shear_of(const pinch_manifold_point *points, int count)
{
    shear_state s;
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
static void add_rigid_shear(pinch_manifold_point *p, const shear_state *about, const double *shift, double angle)
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

/*
 * Carries the resultant over to a changed set: new points take the rigid shear that fits the old ones best (least
 * squares: mean and moment), then all points get the rigid shear that restores the resultant force and the moment about
 * the normal exactly. `old` is the state before, `added` how many points at the end are new.
 */
static void carry_over(pinch_manifold *m, int added, const shear_state *old, double merge_distance)
{
    double old_angle = rigid_angle(old->moment, old->radius2, merge_distance);
    for (int k = m->count - added; k < m->count; k++) {
        add_rigid_shear(&m->point[k], old, old->mean, old_angle);
        m->point[k].twist = old->twist;
    }
    shear_state now = shear_of(m->point, m->count);
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

/* Each fresh point goes to the nearest known point that is still free. known_of[i] = -1: new. */
static void match(const pinch_manifold *m, const pinch_pose pose[2], pinch_fresh_point *const *fresh, int count,
                  double merge_distance, int *known_of, bool *seen)
{
    for (int i = 0; i < count; i++) {
        double best = merge_distance * merge_distance;
        known_of[i] = -1;
        for (int k = 0; k < m->count; k++) {
            if (seen[k]) continue;
            double d2 = anchor_distance2(&m->point[k], pose, fresh[i]);
            if (d2 <= best) {
                best = d2;
                known_of[i] = k;
            }
        }
        if (known_of[i] >= 0) seen[known_of[i]] = true;
    }
}

/* A point's vectors turn with its normal. */
static void turn_with_normal(pinch_manifold_point *p, const double *old_normal)
{
    pinch_v3_rotate_from_to(old_normal, p->normal, p->elastic);
    pinch_v3_rotate_from_to(old_normal, p->normal, p->friction);
    if (!p->own || !p->own->surface.rolls) return;
    pinch_v3_rotate_from_to(old_normal, p->normal, p->own->rolled);
    pinch_v3_rotate_from_to(old_normal, p->normal, p->own->rolling_moment);
}

static void continue_points(pinch_manifold *m, const pinch_pose pose[2], pinch_fresh_point *const *fresh, int count,
                            double steady, const int *known_of)
{
    for (int i = 0; i < count; i++) {
        fresh[i]->point = known_of[i];
        if (known_of[i] < 0) continue;
        pinch_manifold_point *p = &m->point[known_of[i]];
        double old_normal[3];
        pinch_v3_copy(old_normal, p->normal);
        pinch_fresh_point settled = settle_position(p, pose, fresh[i]);
        stay_put(p, pose, steady, &settled);
        set_geometry(p, pose, &settled);
        turn_with_normal(p, old_normal);
    }
}

/* Which of the points that were not seen stay; returns how many stay in all. */
static int judge_stale(pinch_manifold *m, const pinch_pose pose[2], pinch_fresh_point *const *fresh, int count,
                       double merge_distance, double stale_tilt, const bool *seen, bool *stays)
{
    double slack = 0;
    int staying = 0;
    for (int i = 0; i < count; i++)
        if (fresh[i]->depth > slack) slack = fresh[i]->depth;
    for (int k = 0; k < m->count; k++) {
        stays[k] = seen[k];
        if (!seen[k]) {
            pinch_manifold_point *p = &m->point[k];
            double old_normal[3];
            pinch_v3_copy(old_normal, p->normal);
            stays[k] =
                refresh_stale(p, pose, merge_distance, stale_tilt, slack) && extends(p, fresh, count, merge_distance);
            turn_with_normal(p, old_normal);
        }
        staying += stays[k];
    }
    return staying;
}

void pinch_manifold_update(pinch_manifold *m, const pinch_pose pose[2], pinch_fresh_point *pool, int first,
                           double merge_distance, double steady, double stale_tilt, bool shared, int most)
{
    pinch_fresh_point *fresh[MAX_FRESH];
    int fresh_count = 0, fresh_new = 0;
    for (int i = first; i >= 0; i = pool[i].next) {
        pool[i].point = -1;
        if (fresh_count < MAX_FRESH) fresh[fresh_count++] = &pool[i];
    }
    if (!shared) fresh_count = drop_twins(m, pose, fresh, fresh_count, merge_distance);
    fresh_count = reduce(fresh, fresh_count, most);

    int known_of[PINCH_MANIFOLD_POINTS], known_count = m->count;
    bool seen[PINCH_MANIFOLD_POINTS] = {false}, stays[PINCH_MANIFOLD_POINTS];
    match(m, pose, fresh, fresh_count, merge_distance, known_of, seen);
    continue_points(m, pose, fresh, fresh_count, steady, known_of);
    for (int i = 0; i < fresh_count; i++) fresh_new += known_of[i] < 0;
    int staying = judge_stale(m, pose, fresh, fresh_count, merge_distance, stale_tilt, seen, stays);
    for (int k = 0; k < known_count && staying + fresh_new > most; k++) {
        if (seen[k] || !stays[k]) continue;
        stays[k] = false;
        staying--;
    }
    if (staying == known_count && fresh_new == 0) return;

    shear_state old = shear_of(m->point, known_count);
    int count = 0, place[PINCH_MANIFOLD_POINTS];
    for (int k = 0; k < known_count; k++) {
        place[k] = stays[k] ? count : -1;
        if (stays[k]) m->point[count++] = m->point[k];
    }
    for (int i = 0; i < fresh_count; i++) {
        if (known_of[i] >= 0) {
            fresh[i]->point = place[known_of[i]];
            continue;
        }
        memset(&m->point[count], 0, sizeof m->point[count]);
        fresh[i]->point = count;
        set_geometry(&m->point[count++], pose, fresh[i]);
    }
    m->count = count;
    if (shared && known_count > 0 && count > 0) carry_over(m, fresh_new, &old, merge_distance);
}
