#include "contacts/manifold.h"

#include "contacts/reduction.h"

#include "support/extremes.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/*
 * The shear state of a set of points that share one stiffness by their weights, about its centre: mean displacement,
 * mean moment of the displacements about the mean normal, mean twist, mean squared radius.
 */
typedef struct shear_state {
    double centre[3], normal[3], mean[3];
    double moment, twist, radius2;
} shear_state;

static shear_state shear_of(const pinch_manifold_point *points, const double *weight, int count)
{
    shear_state s;
    double all = 0;
    memset(&s, 0, sizeof s);
    for (int k = 0; k < count; k++) all += weight[k];
    for (int k = 0; k < count; k++) {
        pinch_v3_add_scaled(s.centre, weight[k] / all, points[k].position);
        pinch_v3_add_scaled(s.normal, weight[k], points[k].normal);
        pinch_v3_add_scaled(s.mean, weight[k] / all, points[k].elastic);
        s.twist += weight[k] * points[k].twist / all;
    }
    double length = pinch_v3_norm(s.normal);
    if (length > 0) pinch_v3_scale(s.normal, 1 / length);
    for (int k = 0; k < count; k++) {
        double arm[3], turned[3];
        pinch_v3_sub(points[k].position, s.centre, arm);
        pinch_v3_make_perpendicular(arm, s.normal);
        pinch_v3_cross(arm, points[k].elastic, turned);
        s.moment += weight[k] * pinch_v3_dot(turned, s.normal) / all;
        s.radius2 += weight[k] * pinch_v3_dot(arm, arm) / all;
    }
    return s;
}

/* Computes elastic += shift + angle normal x (position - centre), kept in the point's own tangent plane. */
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
 * Carries the resultant over to a changed set. New points take the rigid shear that fits the old ones best (least
 * squares: mean and moment). Then all points get the rigid shear that restores the resultant force and the moment about
 * the normal exactly. `old` is the state before, `added` the number of new points at the end.
 */
static void carry_shear_over(pinch_manifold *m, int added, const shear_state *old, double merge_distance)
{
    double old_angle = rigid_angle(old->moment, old->radius2, merge_distance);
    for (int k = m->count - added; k < m->count; k++) {
        add_rigid_shear(&m->point[k], old, old->mean, old_angle);
        m->point[k].twist = old->twist;
    }
    double weight[PINCH_MANIFOLD_POINTS];
    for (int k = 0; k < m->count; k++) weight[k] = m->point[k].weight;
    shear_state now = shear_of(m->point, weight, m->count);
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

/* Tells whether every detected point lies behind `point`, seen along `direction`, by more than half a merge distance.
 */
static bool leads(const double *point, const double *direction, pinch_detected_point *const *detected, int count,
                  double merge_distance)
{
    double margin = 0.5 * merge_distance * pinch_v3_norm(direction);
    if (!(margin > 0)) return false;
    for (int i = 0; i < count; i++) {
        double from[3];
        pinch_v3_sub(point, detected[i]->position, from);
        if (pinch_v3_dot(direction, from) <= margin) return false;
    }
    return true;
}

/* A point that was not detected is worth keeping only where it reaches beyond those that were: the other end of a line,
 * a corner of a face. Among or between them it would take a share of the load that is theirs. */
static bool extends(const double *position, const double *normal, pinch_detected_point *const *detected, int count,
                    double merge_distance)
{
    double centre[3] = {0, 0, 0}, direction[3];
    if (count == 0) return true;
    for (int i = 0; i < count; i++) {
        pinch_v3_add_scaled(centre, 1.0 / count, detected[i]->position);
        pinch_v3_sub(position, detected[i]->position, direction);
        pinch_v3_make_perpendicular(direction, normal);
        if (leads(position, direction, detected, count, merge_distance)) return true;
    }
    pinch_v3_sub(position, centre, direction);
    pinch_v3_make_perpendicular(direction, normal);
    return leads(position, direction, detected, count, merge_distance);
}

/* Tells whether the manifold has a point within `distance`. */
static bool is_known(const pinch_manifold *m, const pinch_detected_point *detected, double distance)
{
    for (int k = 0; k < m->count; k++)
        if (pinch_point_distance2(&m->point[k], detected) < distance * distance) return true;
    return false;
}

static void swap_points(pinch_detected_point *a, pinch_detected_point *b)
{
    if (a == b) return;
    pinch_detected_point other = *a;
    *a = *b;
    *b = other;
}

/* Returns how far (m) twins are apart at most: by the limit, or on either surface by the depth besides. */
static double reach_of_twins(const pinch_detected_point *points, int count, double limit)
{
    static const double MORE = 1.1; /* than the depth: pinch_detected_apart takes it for the depth */
    double deepest = 0;
    for (int i = 0; i < count; i++) deepest = pinch_larger(points[i].depth, deepest);
    return limit + MORE * deepest;
}

static bool is_within(const double *a, const double *b, double distance)
{
    double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z <= distance * distance;
}

/*
 * Where corners of two bodies lie on each other, rounding decides whether a collider returns one point or two, and
 * where an edge goes into a face, whether it returns its end alone or also where it goes through the surface. Each
 * point with stiffness of its own carries a share of the load, which must not jump: of twins the deeper one counts. Two
 * that the manifold already has are twins at half the distance only, so that none comes and goes with every step. Puts
 * the others last, and returns how many are left.
 */
static int leave_out_twins(const pinch_manifold *m, pinch_detected_point *points, int count, double merge_distance)
{
    static const double TWINS = 0.02; /* of the merge distance */
    double limit = TWINS * merge_distance, reach = reach_of_twins(points, count, limit);
    int kept = 0;
    for (int i = 0; i < count; i++) {
        pinch_detected_point *point = &points[i], *twin = NULL;
        for (int k = 0; k < kept && !twin; k++) {
            if (!is_within(point->position, points[k].position, reach)) continue;
            double apart = pinch_detected_apart(point, &points[k]);
            if (apart < limit &&
                !(apart > 0.5 * limit && is_known(m, point, 0.25 * limit) && is_known(m, &points[k], 0.25 * limit)))
                twin = &points[k];
        }
        if (twin && point->depth > twin->depth) swap_points(point, twin);
        point->redundant = twin != NULL;
        if (twin) continue;
        swap_points(point, &points[kept++]);
    }
    return kept;
}

/* Which detected points continue known ones. */
typedef struct measure {
    double (*distance2)(const pinch_manifold_point *known, const pinch_detected_point *detected); /* m^2 */
    double within, deepest; /* how far and how deep they may be, m */
} measure;

/* Returns the nearest of the known points that are not taken, of the square distances d2; -1: none is near enough. */
static int nearest_free(const double *d2, int count, const bool *taken, double within)
{
    int nearest = -1;
    for (int k = 0; k < count; k++)
        if (!taken[k] && (nearest < 0 ? d2[k] <= within * within : d2[k] < d2[nearest])) nearest = k;
    return nearest;
}

/*
 * Gives detected points that have none, and are not too deep, known points that are still free, those that are nearest
 * to each other first: a new one beside a known one would take its state before that one's own point comes. known_of[i]
 * is -1 for a new one.
 */
static void match_by(const measure *by, const pinch_manifold *m, pinch_detected_point *const *detected, int count,
                     int *known_of, bool *seen)
{
    double d2[PINCH_MANIFOLD_POINTS][PINCH_MANIFOLD_POINTS];
    int nearest[PINCH_MANIFOLD_POINTS]; /* the known point that is still free, -1: none, or none is wanted */
    for (int i = 0; i < count; i++) {
        bool waits = known_of[i] < 0 && detected[i]->depth <= by->deepest;
        for (int k = 0; k < m->count && waits; k++) d2[i][k] = by->distance2(&m->point[k], detected[i]);
        nearest[i] = waits ? nearest_free(d2[i], m->count, seen, by->within) : -1;
    }
    for (;;) {
        int first = -1;
        for (int i = 0; i < count; i++)
            if (nearest[i] >= 0 && (first < 0 || d2[i][nearest[i]] < d2[first][nearest[first]])) first = i;
        if (first < 0) return;
        int taken = known_of[first] = nearest[first];
        seen[taken] = true;
        nearest[first] = -1;
        for (int i = 0; i < count; i++)
            if (nearest[i] == taken) nearest[i] = nearest_free(d2[i], m->count, seen, by->within);
    }
}

/*
 * Finds the known point that each detected point continues. Those go first that are near in space: of two contacts one
 * above the other, as at a shelf that is thinner than the overlap, each finds its own. What is left over may lie on the
 * other of the two surfaces, farther away than the merge distance where soft bodies overlap deeply. Bodies that are
 * still deeper in each other are jammed, and their overlaps point all ways: friction that goes on there winds up
 * springs that throw them out.
 */
static void match(const pinch_manifold *m, pinch_detected_point *const *detected, int count, double merge_distance,
                  int *known_of, bool *seen)
{
    static const double JAMMED = 3; /* merge distances: 0.15 of the smaller geom, a quarter of a cube's edge */
    const measure near = {pinch_point_distance2, merge_distance, INFINITY};
    const measure across = {pinch_point_distance2_across, merge_distance, JAMMED * merge_distance};
    for (int i = 0; i < count; i++) known_of[i] = -1;
    match_by(&near, m, detected, count, known_of, seen);
    match_by(&across, m, detected, count, known_of, seen);
}

/* Tells whether a pair has more points than the corners of a face, each with a law of its own: those that come besides
 * count, wherever they are. */
static bool count_one_by_one(const pinch_manifold *m, const pinch_manifold_rules *rules)
{
    return !rules->shared && m->count > PINCH_SHARED_POINTS;
}

/* Tells whether the bodies have moved less than a distance against each other at every known point. */
static bool lies_still(const pinch_manifold *m, const pinch_pose pose[2], double distance)
{
    bool all = m->count > 0 && distance > 0;
    for (int k = 0; k < m->count && all; k++) all = pinch_point_lies_still(&m->point[k], pose, distance);
    return all;
}

/* Returns how deep the deepest of the known points was when the last step was solved. */
static double deepest_known(const pinch_manifold *m)
{
    double deepest = m->point[0].depth;
    for (int k = 1; k < m->count; k++)
        if (m->point[k].depth > deepest) deepest = m->point[k].depth;
    return deepest;
}

/* Tells whether a point has the direction of one that is known. */
static bool has_known_direction(const pinch_manifold *m, const pinch_detected_point *detected)
{
    static const double SAME_FACE = 0.99; /* the cosine of 0.14 rad */
    for (int k = 0; k < m->count; k++)
        if (pinch_v3_dot(m->point[k].normal, detected->normal) > SAME_FACE) return true;
    return false;
}

/*
 * Where edges of two faces lie along each other, rounding decides how often they cross, and a collider returns points
 * between others that come and go. As long as the bodies hardly move against each other, a new point counts only where
 * it reaches beyond the known ones. But a face is flat: what lies between is no deeper than the points around it, and
 * has their direction. A point that is or has not was made by a shape that is another one now, and counts. Returns how
 * many detected points are left.
 */
static int drop_between(const pinch_manifold *m, const pinch_pose pose[2], pinch_detected_point **detected, int count,
                        const pinch_manifold_rules *rules, int *known_of)
{
    static const double ROUNDING = 10; /* times the quiet distance */
    pinch_detected_point known[PINCH_MANIFOLD_POINTS], *known_list[PINCH_MANIFOLD_POINTS];
    int kept = 0, new_count = 0;
    for (int i = 0; i < count; i++) new_count += known_of[i] < 0;
    if (new_count == 0 || count_one_by_one(m, rules) || !lies_still(m, pose, rules->quiet_distance)) return count;
    double deepest = deepest_known(m) + ROUNDING * rules->quiet_distance;
    for (int k = 0; k < m->count; k++) {
        pinch_v3_copy(known[k].position, m->point[k].position);
        known_list[k] = &known[k];
    }
    for (int i = 0; i < count; i++) {
        const pinch_detected_point *d = detected[i];
        if (known_of[i] < 0 && d->depth <= deepest && has_known_direction(m, d) &&
            !is_known(m, d, rules->merge_distance) &&
            !extends(d->position, d->normal, known_list, m->count, rules->merge_distance))
            continue;
        known_of[kept] = known_of[i];
        detected[kept++] = detected[i];
    }
    return kept;
}

static void continue_points(pinch_manifold *m, const pinch_pose pose[2], pinch_detected_point *const *detected,
                            int count, const pinch_manifold_rules *rules, const int *known_of)
{
    for (int i = 0; i < count; i++) {
        detected[i]->point = known_of[i];
        if (known_of[i] < 0) continue;
        pinch_point_continue(&m->point[known_of[i]], pose, rules, detected[i]);
        m->point[known_of[i]].weight = 1;
    }
}

/* Returns how deep (m) the deepest of the detected points is; 0: none is pressed in. */
static double deepest_of(pinch_detected_point *const *detected, int count)
{
    double deepest = 0;
    for (int i = 0; i < count; i++) deepest = pinch_larger(detected[i]->depth, deepest);
    return deepest;
}

/* Decides which of the points that were not detected stay, and returns how many points stay in all. */
static int keep_undetected(pinch_manifold *m, const pinch_pose pose[2], pinch_detected_point *const *detected,
                           int count, const pinch_manifold_rules *rules, const bool *seen, bool *stays)
{
    double slack = deepest_of(detected, count);
    int staying = 0;
    for (int k = 0; k < m->count; k++) {
        pinch_manifold_point *p = &m->point[k];
        stays[k] = seen[k] || (pinch_point_refresh(p, pose, rules, slack) &&
                               extends(p->position, p->normal, detected, count, rules->merge_distance) &&
                               (!rules->bears || rules->bears(rules->geoms, p, slack)));
        staying += stays[k];
    }
    return staying;
}

/*
 * Points that share one stiffness do so by their weights. Where a corner lifts, its share goes over to the others, and
 * where one comes down it takes its share, little by little: the force of a pad that tilts has no jumps. So a point
 * that comes beside deeper ones counts as much as it is pressed in beside them, and fully from a quarter of that on. It
 * goes on to count fully when it lifts, for a patch does not lose it at once, and then less and less up to where it is
 * dropped. Points that come together, as those of a face that is laid down flat, count fully and alike.
 */
static void weigh(pinch_manifold_point *p, double deepest)
{
    static const double FULLY = 0.25, LEAST = 1e-4; /* of the deepest one's depth; no contact is without stiffness */
    p->grown = pinch_larger(p->grown, deepest > 0 ? pinch_within(p->depth / (FULLY * deepest), 0, 1) : 1);
    p->weight = pinch_larger(pinch_smaller(p->weight, p->grown), LEAST);
}

/*
 * Weighs all points, of which the first `known` had the weights `before`, out of `all` together. Where shares change,
 * each spring gives way or comes back by so much that it bears what it bore. Where only the number of points that count
 * fully changes, that is left to carry_shear_over.
 */
static void weigh_all(pinch_manifold *m, double deepest, const double *before, int known, double all)
{
    bool differ = false, changed = m->count != known;
    for (int k = 0; k < m->count; k++) {
        weigh(&m->point[k], deepest);
        differ = differ || m->point[k].weight != 1 || (k < known && before[k] != 1);
        changed = changed || m->point[k].weight != before[k];
    }
    double now = pinch_manifold_weight(m);
    for (int k = 0; k < known && differ && (changed || now != all); k++) {
        pinch_manifold_point *p = &m->point[k];
        double softer = before[k] / all * now / p->weight;
        pinch_v3_scale(p->elastic, softer);
        p->twist *= softer;
    }
}

bool pinch_manifold_continue(pinch_manifold *m, const pinch_pose pose[2], pinch_detected_point *points, int count,
                             const pinch_manifold_rules *rules)
{
    if (count != 1 || m->count != 1) return false;
    pinch_point_anchor(pose, points);
    if (pinch_point_distance2(m->point, points) > rules->merge_distance * rules->merge_distance) return false;
    points->point = 0;
    pinch_point_continue(m->point, pose, rules, points);
    m->point->weight = m->point->grown = 1;
    return true;
}

/* Leaves out the known points that do not stay, and their weights, and adds the detected ones that continue none. */
static void replace_points(pinch_manifold *m, const pinch_pose pose[2], pinch_detected_point *const *detected,
                           int count, const int *known_of, const bool *stays, double *weights)
{
    int place[PINCH_MANIFOLD_POINTS], known_count = m->count;
    m->count = 0;
    for (int k = 0; k < known_count; k++) {
        place[k] = stays[k] ? m->count : -1;
        if (!stays[k]) continue;
        weights[m->count] = weights[k];
        m->point[m->count++] = m->point[k];
    }
    for (int i = 0; i < count; i++) {
        if (known_of[i] >= 0) {
            detected[i]->point = place[known_of[i]];
            continue;
        }
        memset(&m->point[m->count], 0, sizeof m->point[m->count]);
        m->point[m->count].weight = 1;
        detected[i]->point = m->count;
        pinch_point_set_geometry(&m->point[m->count++], pose, detected[i]);
    }
}

void pinch_manifold_update(pinch_manifold *m, const pinch_pose pose[2], pinch_detected_point *points, int count,
                           const pinch_manifold_rules *rules)
{
    pinch_detected_point *detected[PINCH_MANIFOLD_POINTS];
    int new_count = 0;
    for (int i = 0; i < count; i++) {
        points[i].point = -1;
        pinch_point_anchor(pose, &points[i]);
    }
    if (!rules->shared && count <= PINCH_MOST_COMPARED)
        count = leave_out_twins(m, points, count, rules->merge_distance);
    if (rules->rims_bear_nothing) count = pinch_leave_out_rims(points, count);
    if (count > rules->most_points)
        count = pinch_reduce_points(m, rules->merge_distance, rules->most_points, points, count, detected);
    else
        for (int i = 0; i < count; i++) detected[i] = &points[i];

    int known_of[PINCH_MANIFOLD_POINTS], known_count = m->count;
    bool seen[PINCH_MANIFOLD_POINTS] = {false}, stays[PINCH_MANIFOLD_POINTS];
    double before[PINCH_MANIFOLD_POINTS];
    for (int k = 0; k < known_count; k++) before[k] = m->point[k].weight;
    match(m, detected, count, rules->merge_distance, known_of, seen);
    count = drop_between(m, pose, detected, count, rules, known_of);
    continue_points(m, pose, detected, count, rules, known_of);
    for (int i = 0; i < count; i++) new_count += known_of[i] < 0;
    int staying = keep_undetected(m, pose, detected, count, rules, seen, stays);
    for (int k = 0; k < known_count && staying + new_count > rules->most_points; k++) {
        if (seen[k] || !stays[k]) continue;
        stays[k] = false;
        staying--;
    }
    shear_state old;
    double all = 0;
    bool replaced = staying < known_count || new_count > 0;
    bool carries = rules->shared && replaced && known_count > 0 && staying + new_count > 0;
    for (int k = 0; k < known_count; k++) all += before[k];
    if (carries) old = shear_of(m->point, before, known_count);
    if (replaced) replace_points(m, pose, detected, count, known_of, stays, before);
    if (rules->shared) weigh_all(m, deepest_of(detected, count), before, staying, all);
    if (carries) carry_shear_over(m, new_count, &old, rules->merge_distance);
}
