#include "contacts/manifold.h"

#include "contacts/manifold_point.h"
#include "contacts/manifold_shear.h"

#include "support/vec3.h"

#include <float.h>
#include <string.h>

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
        if (pinch_point_distance2(&m->point[k], pose, fresh) < distance * distance) return true;
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
    double distance2[PINCH_MANIFOLD_FRESH];
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

/* Each fresh point goes to the nearest known point that is still free. known_of[i] = -1: new. */
static void match(const pinch_manifold *m, const pinch_pose pose[2], pinch_fresh_point *const *fresh, int count,
                  double merge_distance, int *known_of, bool *seen)
{
    for (int i = 0; i < count; i++) {
        double best = merge_distance * merge_distance;
        known_of[i] = -1;
        for (int k = 0; k < m->count; k++) {
            if (seen[k]) continue;
            double d2 = pinch_point_distance2(&m->point[k], pose, fresh[i]);
            if (d2 <= best) {
                best = d2;
                known_of[i] = k;
            }
        }
        if (known_of[i] >= 0) seen[known_of[i]] = true;
    }
}

static void continue_points(pinch_manifold *m, const pinch_pose pose[2], pinch_fresh_point *const *fresh, int count,
                            double steady, const int *known_of)
{
    for (int i = 0; i < count; i++) {
        fresh[i]->point = known_of[i];
        if (known_of[i] < 0) continue;
        pinch_manifold_point *p = &m->point[known_of[i]];
        pinch_point_continue(p, pose, steady, fresh[i]);
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
            stays[k] = pinch_point_refresh(p, pose, merge_distance, stale_tilt, slack) &&
                       extends(p, fresh, count, merge_distance);
        }
        staying += stays[k];
    }
    return staying;
}

void pinch_manifold_update(pinch_manifold *m, const pinch_pose pose[2], pinch_fresh_point *points, int point_count,
                           double merge_distance, double steady, double stale_tilt, bool shared, int most)
{
    pinch_fresh_point *fresh[PINCH_MANIFOLD_FRESH];
    int fresh_count = point_count, fresh_new = 0;
    for (int i = 0; i < point_count; i++) {
        fresh[i] = &points[i];
        points[i].point = -1;
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

    pinch_shear_state old = pinch_shear_of(m->point, known_count);
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
        pinch_point_set_geometry(&m->point[count++], pose, fresh[i]);
    }
    m->count = count;
    if (shared && known_count > 0 && count > 0) pinch_shear_carry_over(m, fresh_new, &old, merge_distance);
}
