/* A manifold's points as contacts of a problem: frame, law, history, and motions that are prescribed. */
#include "islands/island_life.h"

#include "contacts/materials.h"
#include "contacts/surface.h"

#include "support/extremes.h"
#include "support/loop.h"
#include "support/vec3.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* Adds the velocity at a point of a body that is no unknown, or a driven body's own prescribed motion. Returns false
 * where there is none. */
static bool add_prescribed(const pinch_step_bodies *bodies, dBodyID body, int step_body, const double *point,
                           double sign, double *linear, double *angular)
{
    if (!body || (step_body >= 0 && bodies->items[step_body].drive < 0)) return false;
    const double *w = dBodyGetAngularVel(body);
    double arm[3], turned[3];
    pinch_v3_sub(point, dBodyGetPosition(body), arm);
    pinch_v3_cross(w, arm, turned);
    pinch_v3_add_scaled(linear, sign, dBodyGetLinearVel(body));
    pinch_v3_add_scaled(linear, sign, turned);
    pinch_v3_add_scaled(angular, sign, w);
    return true;
}

/* Any tangent will do for a cone that is round. This one takes no root, for which all that follows would wait: Duff et
 * al., "Building an orthonormal basis, revisited", 2017. */
static void round_tangent(const double *n, double *tangent)
{
    double sign = copysign(1, n[2]), a = -1 / (sign + n[2]) * n[0];
    pinch_v3_set(tangent, 1 + sign * n[0] * a, sign * n[1] * a, -sign * n[0]);
}

/* Chooses the first tangent: where there are facets, a material's facet axis, turned with its geom. A cone is round.
 * The facets are those of the force that the fingertip exerts; where it is body 1, the force that it gets is opposite,
 * and a polygon with an odd number of corners is not its own image. */
static void choose_tangent(const pinch_step_context *context, const pinch_contact_store *store, const pinch_pair *pair,
                           const double *normal, double *tangent)
{
    if (context->settings.faces == 0) {
        round_tangent(normal, tangent);
        return;
    }
    for (int side = 0; side < 2; side++) {
        const pinch_material *material = pinch_geom_material(store, pair->geom[side]);
        if (!material) continue;
        const double *axis = material->facet_axis;
        if (axis[0] == 0 && axis[1] == 0 && axis[2] == 0) continue;
        const double *R = pinch_side_pose(pair->id[side], pair->body[side]).rotation;
        for (int i = 0; i < 3; i++) tangent[i] = pinch_v3_dot(R + 4 * i, axis);
        double length = pinch_v3_norm(tangent);
        pinch_v3_make_perpendicular(tangent, normal);
        double left = pinch_v3_norm(tangent);
        if (left > 1e-6 * length) {
            bool gets_force = side == 0 && context->settings.faces % 2 == 1;
            pinch_v3_scale(tangent, (gets_force ? -1 : 1) / left);
            return;
        }
    }
    pinch_v3_any_perpendicular(normal, tangent);
}

/*
 * Bodies that are deeper in each other than this part of the smaller geom are not in touch: their overlaps point all
 * ways. Friction without a limit would lock each in what the others leave, for good, as soon as the solution is exact.
 * So it has a limit there. A plane pushes one way only, and locks nothing.
 */
static const double IN_EACH_OTHER = 0.05;

/* The law that the points of a pair share. */
typedef struct pair_law {
    const pinch_material *material; /* NULL: the points have surface parameters of their own */
    double part;                    /* of the fingertip's stiffness, for each point of its manifold that counts fully */
    double share; /* how much of the overlap lies between geom[0]'s surface and the contact; the points lie half way */
    double mobility;                        /* where there is no material: sum of the bodies' inverse masses, 1/kg */
    double size;                            /* likewise: of the smaller geom, m */
    double deepest;                         /* likewise: the depth of its deepest point, m */
    double bears;                           /* likewise: what each contact bore in the last step, in the mean, N */
    double approach_depth, recent_approach; /* out: the most of all points */
} pair_law;

static bool has_plane(const pinch_pair *pair)
{
    bool found = false;
    for (int side = 0; side < 2; side++)
        found = found || (pair->id[side] && dGeomGetClass(pair->id[side]) == dPlaneClass);
    return found;
}

static double mobility_of(const pinch_pair *pair)
{
    double mobility = 0;
    for (int side = 0; side < 2; side++) {
        if (!pair->body[side] || pair->step_body[side] < 0) continue;
        dMass mass;
        dBodyGetMass(pair->body[side], &mass);
        mobility += 1 / mass.mass;
    }
    return mobility;
}

static pair_law law_of_pair(const pinch_contact_store *store, const pinch_pair *pair, pinch_material *own)
{
    int count = pair->manifold.count;
    pair_law law = {.share = 0.5};
    if (pair->has_material) {
        law.part = 1 / pinch_manifold_weight(&pair->manifold);
        law.material = pinch_pair_material(store, pair, own, &law.share);
    } else {
        law.mobility = mobility_of(pair);
        law.size = pinch_pair_size(store, pair);
        double force = 0, stands_for = 0;
        for (int k = 0; k < count; k++) {
            const pinch_manifold_point *point = &pair->manifold.point[k];
            law.deepest = pinch_larger(point->depth, law.deepest);
            force += point->normal_force;
            stands_for += point->own->stands_for;
        }
        law.bears = stands_for > 0 ? force / stands_for : 0;
    }
    return law;
}

/* Gives a contact its share of the fingertip's law. */
static void apply_material(const pair_law *law, const pinch_manifold_point *point, pinch_contact *c)
{
    const pinch_material *material = law->material;
    double share = point->weight * law->part;
    c->model = material->model;
    for (int i = 0; i < 3; i++) {
        c->stiffness[i] = share * material->stiffness[i];
        c->damping[i] = share * material->damping[i];
    }
    c->friction[0] = c->friction[1] = point->slipping ? material->friction_kinetic : material->friction;
    c->torsional_friction = material->torsional_friction;
    c->max_force = share * material->max_force;
}

/* Returns the velocity (m/s) at which a pair's bodies part at a point, as they move now. */
static double parting_velocity(const pinch_pair *pair, const double *position, const double *normal)
{
    double linear[3] = {0, 0, 0};
    for (int side = 0; side < 2; side++) {
        dVector3 velocity;
        if (!pair->body[side]) continue;
        dBodyGetPointVel(pair->body[side], position[0], position[1], position[2], velocity);
        pinch_v3_add_scaled(linear, side ? -1 : 1, velocity);
    }
    return pinch_v3_dot(linear, normal);
}

/*
 * Estimates the speed at which a program moves the bodies of a pair into each other by their poses. It may set the pose
 * of a geom or of a body in each step, or in every tenth, or change a shape: the overlap then grows by more than the
 * velocities explain with which the bodies have moved. What happens once, as where a body is set down in another one,
 * is no motion. In a jam overlaps jump as well, as the collider finds another way out of them, but neither steadily nor
 * in one direction. Between two bodies that move by themselves overlaps jump more often, and only what the program has
 * moved counts: the centres are not where the last step has left them.
 */
static void estimate_pose_speed(const pinch_step_context *context, pinch_pair *pair,
                                const pinch_manifold_point *deepest, double size)
{
    static const double LEAST_WAY = 1e-4; /* of the size: turning bodies and rounding lead by less */
    static const double STEADY = 0.5, SAME_WAY = 0.95;
    enum { MOST_STEPS = 32 }; /* from one way to the next */
    pinch_pose_motion *posed = &pair->posed;
    bool may_be_posed = pair->buffered_before > 0 && deepest->depth > LEAST_WAY * size &&
                        pinch_v3_dot(deepest->normal, posed->seen_normal) > SAME_WAY;
    double way = 0;
    if (may_be_posed && pair->step_body[0] >= 0 && pair->step_body[1] >= 0)
        way = posed->apart - pinch_pair_apart(pair);
    else if (may_be_posed)
        way = deepest->depth - posed->seen_depth +
              context->h * parting_velocity(pair, deepest->position, deepest->normal);
    long steps = context->number - posed->way_step;
    if (way > LEAST_WAY * size) {
        bool steady = steps > 0 && steps <= MOST_STEPS && way > STEADY * posed->way && posed->way > STEADY * way;
        posed->speed = steady ? fmin(way, posed->way) / ((double)steps * context->h) : 0;
        posed->steps = steady ? steps : 0;
        posed->way = way;
        posed->way_step = context->number;
    } else if (steps > posed->steps) {
        posed->speed = 0;
    }
    posed->seen_step = context->number;
    posed->seen_depth = deepest->depth;
    pinch_v3_copy(posed->seen_normal, deepest->normal);
    posed->apart = pinch_pair_apart(pair); /* and so it stays where the island sleeps on */
}

/*
 * Finds the pace at which the bodies of a pair part: that of the longest step of late.
 *
 * A contact bears its load r with the depth C r h/erp. Under a floor of compliance, C = floor h W, that falls with the
 * square of the step. What is left over as steps become shorter is no overlap that should be pushed out by the part erp
 * in each of them: that would throw what rests, and the faster the shorter the step. So it comes up by the part erp
 * h/s, where the pace step s falls by erp/2 of the time that goes by. The depth d, with dd/dt = -erp d/s, falls with
 * s^2 as ds/dt = -erp/2, and so with the load that is borne at s. What bodies have come in by in longer steps, they
 * have come in by at the pace of these. A new pair knows the last step alone. A single long step, in which a program
 * hangs, does not count for more than a frame: what has fallen deep into the ground comes out again soon.
 */
static void follow_step(const pinch_step_context *context, pinch_pair *pair, double erp)
{
    static const double FORGOTTEN = 0.5; /* in a step, of erp and of its length */
    static const double FRAME = 1.0 / 60;
    double h = context->h, before = pair->buffered_before > 0 ? pair->paced_step : context->h_before;
    pair->paced_step = pinch_larger(h, pinch_smaller(before, FRAME) - FORGOTTEN * erp * h);
    if (!(pair->paced_step < before)) return;
    pair->recent_approach_before *= pair->paced_step / before;
    pair->approach_depth *= pair->paced_step / before;
}

/*
 * Looks, once in a step, at how the overlap of a pair goes on. What its bodies have come in by is forgotten where the
 * overlap points another way: a path turns little by little, and in a jam each way out leads into the next overlap.
 */
static void follow_overlap(const pinch_step_context *context, const pinch_contact_store *store, pinch_pair *pair,
                           double size)
{
    static const double NEARLY_SAME_WAY = 0.8;
    const pinch_manifold_point *deepest = &pair->manifold.point[0];
    if (!(pair->paced_step > 0))
        pair->paced_step = context->h; /* a new pair seems to be seen in a world's first step */
    if (pair->posed.seen_step == context->number) return;
    for (int k = 1; k < pair->manifold.count; k++)
        if (pair->manifold.point[k].depth > deepest->depth) deepest = &pair->manifold.point[k];
    bool goes_on =
        pair->buffered_before > 0 && pinch_v3_dot(deepest->normal, pair->posed.seen_normal) > NEARLY_SAME_WAY;
    pair->recent_approach_before = goes_on ? pair->recent_approach : 0;
    follow_step(context, pair, pinch_surface_erp(context, &store->surfaces.items[deepest->own->surface].surface));
    estimate_pose_speed(context, pair, deepest, size);
}

/*
 * Sets the compliances of the last step in which the contact was solved. Where they fall, its elastic state e shrinks
 * with them, so that its force stays (core's equation (29)). That force is k' e, with the stiffness k' = k C/C' which a
 * floor of compliance C' has left. So what C' would be now at the same k' counts as the last one: with p = k/(h k + c),
 * that is C' p/p_before. A contact that is damped more does not become stiffer.
 *
 * Nor does it in a step of another length. Stiffness and damping then keep their k' by themselves. Where a program
 * keeps ERP and CFM, or a floor h W is all of the compliance, k' is another one, and what sticks would creep if it lost
 * some of e wherever steps vary: so what would be as much in a step of this length counts, where that is less.
 */
static void set_compliance_before(double h, pinch_own_law *own, pinch_contact *c)
{
    double k = c->stiffness[0], damping = c->damping[0], h_before = own->step;
    own->closes_at = h * k + damping > 0 ? k / (h * k + damping) : 0;
    double ratio = own->closed_at > 0 ? own->closes_at / own->closed_at : 1;
    if (h_before > 0 && h < h_before) ratio = pinch_smaller(ratio, h / h_before);
    if (h > h_before && h * k + damping > 0) ratio = pinch_smaller(ratio, (h_before * k + damping) / (h * k + damping));
    for (int kind = 0; kind < 3; kind++) c->compliance[kind] = ratio * own->compliance[kind];
    own->stiffens_from = c->compliance[1];
}

/* Gives a contact the law of its point's own surface parameters, at the velocities of the start of the step. */
static void apply_surface(const pinch_step_context *context, const pinch_contact_store *store, const pinch_pair *pair,
                          pair_law *law, const pinch_manifold_point *point, pinch_contact *c)
{
    pinch_own_law *own = point->own;
    double approach = parting_velocity(pair, point->position, c->normal);
    pinch_surface_conditions conditions = {
        .tangent1 = own->tangent1,
        .mobility = law->mobility,
        .size = law->size,
        .stands_for = own->stands_for,
        .part = own->part,
        .bears = law->bears,
        .approach = approach,
        .recent_approach = pair->recent_approach_before,
        .approach_depth = pair->approach_depth,
        .paced_step = pair->paced_step,
        .pose_speed = pair->posed.speed,
        .force = point->normal_force,
        .gives_way = own->compliance[0] * point->normal_force,
    };
    c->max_force = INFINITY;
    own->rebound = pinch_surface_apply(context, &store->surfaces.items[own->surface].surface, &conditions, c);
    own->pose_speed = conditions.pose_speed;
    own->paced_step = conditions.paced_step;
    own->eased = conditions.eased;
    own->yields = conditions.yields;
    set_compliance_before(context->h, own, c);
    c->floor = own->floor;
    c->hold = own->hold;
    c->hold_span = own->hold_span;
    law->approach_depth = pinch_larger(conditions.approach_depth, law->approach_depth);
    law->recent_approach = pinch_larger(conditions.recent_approach, law->recent_approach);
}

static void fill_history(const pinch_manifold_point *point, const double *t2, pinch_contact *c)
{
    c->elastic[0] = pinch_v3_dot(c->tangent1, point->elastic);
    c->elastic[1] = pinch_v3_dot(t2, point->elastic);
    c->elastic[2] = point->twist;
    c->force[0] = point->normal_force;
    c->force[1] = pinch_v3_dot(c->tangent1, point->friction);
    c->force[2] = pinch_v3_dot(t2, point->friction);
    c->force[3] = point->torsion;
    const pinch_rolling *rolling = pinch_rolling_of(point);
    if (!rolling) return;
    c->rolling_elastic[0] = pinch_v3_dot(c->tangent1, rolling->rolled);
    c->rolling_elastic[1] = pinch_v3_dot(t2, rolling->rolled);
    c->rolling_moment[0] = pinch_v3_dot(c->tangent1, rolling->moment);
    c->rolling_moment[1] = pinch_v3_dot(t2, rolling->moment);
}

/*
 * Gives a contact back what has locked of its shear, where it becomes softer again.
 *
 * A contact that becomes stiffer keeps its force, and loses the shear that this needs no longer. As it becomes softer
 * its force drops to what is left of the shear: one that is soft and hard in turns would let what it holds sag a
 * little further each time. So what it loses is kept, as of a spring that stands behind the stiffer contact and locks.
 * As it comes loose it puts no energy in: with the shear e and the stiffness k before, the part p of the shear that
 * stays, under the stiffness k/p, and b times as much force at the end,
 *
 *     k/2 ((1-p) e + b p e)^2 <= (1-p) k/2 e^2 + p k/2 (b e)^2,
 *
 * the energy that was locked, and that of the stiffer contact. Of several springs that have locked those come loose
 * that are not stiffer than the contact is then.
 */
static void unlock_shear(const double *t2, pinch_own_law *own, pinch_contact *c)
{
    own->unlocks = 0;
    if (!(own->yields > own->yielded)) return;
    own->unlocks =
        own->yields < own->locked_from ? (own->yields - own->yielded) / (own->locked_from - own->yielded) : 1;
    c->elastic[0] += own->unlocks * pinch_v3_dot(c->tangent1, own->locked);
    c->elastic[1] += own->unlocks * pinch_v3_dot(t2, own->locked);
}

static void add_surface_velocity(const double *linear, const double *angular, const double *t2, pinch_contact *c)
{
    c->surface_velocity[0] += pinch_v3_dot(c->normal, linear);
    c->surface_velocity[1] += pinch_v3_dot(c->tangent1, linear);
    c->surface_velocity[2] += pinch_v3_dot(t2, linear);
    c->surface_velocity[3] += pinch_v3_dot(c->normal, angular);
    if (c->model != PINCH_CONTACT_ROLLING) return;
    c->surface_velocity[4] += pinch_v3_dot(c->tangent1, angular);
    c->surface_velocity[5] += pinch_v3_dot(t2, angular);
}

/* Tells whether a partner comes in at a speed (m/s) that counts beside the one at which the overlap parts. One that
 * hardly moves is ground: a platform that rolls a little would drive bodies on by one of their sides. */
static bool comes_in(const pinch_step_context *context, const pinch_contact *c, double speed, const pinch_own_law *own)
{
    static const double COUNTS = 0.25;
    double parts = c->stiffness[0] * c->depth / (context->h * c->stiffness[0] + c->damping[0]) - own->eased;
    return speed > 0 && speed > COUNTS * parts;
}

static void fill_contact(const pinch_step_context *context, const pinch_contact_store *store,
                         const pinch_step_bodies *bodies, const pinch_pair *pair, pair_law *law,
                         const pinch_manifold_point *point, pinch_contact *c)
{
    const int *body = pair->step_body;
    memset(c, 0, sizeof *c);
    c->body1 = body[0] >= 0 ? bodies->items[body[0]].local : PINCH_STATIC_BODY;
    c->body2 = body[1] >= 0 ? bodies->items[body[1]].local : PINCH_STATIC_BODY;
    pinch_v3_copy(c->position, point->position);
    pinch_v3_copy(c->normal, point->normal);
    c->depth = point->depth;
    if (law->material) {
        pinch_v3_add_scaled(c->position, (law->share - 0.5) * point->depth, point->normal);
        apply_material(law, point, c);
        choose_tangent(context, store, pair, c->normal, c->tangent1);
    } else {
        apply_surface(context, store, pair, law, point, c);
    }
    double t2[3], linear[3] = {0, 0, 0}, angular[3] = {0, 0, 0};
    pinch_v3_cross(c->normal, c->tangent1, t2);
    fill_history(point, t2, c);
    if (point->locks) unlock_shear(t2, point->own, c);
    bool prescribed = false;
    for (int side = 0; side < 2; side++) {
        prescribed |= add_prescribed(bodies, pair->body[side], body[side], c->position, side ? -1 : 1, linear, angular);
        /* a driven finger's force is its drive's: a limit below it would leave nothing to balance it */
        if (body[side] >= 0 && bodies->items[body[side]].drive >= 0) c->max_force = INFINITY;
    }
    if (prescribed) add_surface_velocity(linear, angular, t2, c);
    if (!law->material && !comes_in(context, c, -pinch_v3_dot(c->normal, linear), point->own)) point->own->eased = 0;
    if (!law->material)
        point->own->carries_at = prescribed ? hypot(pinch_v3_dot(c->tangent1, linear), pinch_v3_dot(t2, linear)) : 0;
}

typedef struct fill_task {
    const pinch_step_context *context;
    const pinch_contact_store *contacts;
    const pinch_step_bodies *bodies;
    const pinch_island *island;
    pinch_contact *filled;
    atomic_bool overlaps_deeply; /* a pair's bodies are in each other */
} fill_task;

static void fill_pairs(void *argument, int first, int end)
{
    fill_task *task = argument;
    const pinch_step_context *context = task->context;
    const pinch_contact_store *contacts = task->contacts;
    const pinch_step_bodies *bodies = task->bodies;
    const pinch_range pairs = task->island->pairs;
    pinch_contact *filled = task->filled;
    for (int i = first; i < end; i++) {
        pinch_pair *pair = pinch_island_pair(contacts, pairs, i);
        pinch_prefetch_island_pairs(contacts, pairs, i, PINCH_READS_OWN_LAWS);
        pinch_material own;
        pair_law law = law_of_pair(contacts, pair, &own);
        if (!pair->has_material) follow_overlap(context, contacts, pair, law.size);
        for (int k = 0; k < pair->manifold.count; k++)
            fill_contact(context, contacts, bodies, pair, &law, &pair->manifold.point[k],
                         &filled[pair->first_in_island + k]);
        pair->approach_depth = law.approach_depth;
        pair->recent_approach = law.recent_approach;
        pair->overlaps_deeply = law.deepest > IN_EACH_OTHER * law.size && !has_plane(pair);
        if (pair->overlaps_deeply) atomic_store_explicit(&task->overlaps_deeply, true, memory_order_relaxed);
    }
}

static pinch_step_body *side_of(const fill_task *task, const pinch_pair *pair, int side)
{
    return pair->step_body[side] < 0 ? NULL : &task->bodies->items[pair->step_body[side]];
}

/* Limits friction between bodies that are in each other, or in others. */
static void limit_friction_inside(const fill_task *task)
{
    const pinch_contact_store *store = task->contacts;
    const pinch_range pairs = task->island->pairs, bodies = task->island->bodies;
    for (int k = 0; k < bodies.count; k++) pinch_island_body(task->bodies, bodies, k)->overlaps_deeply = false;
    for (int i = 0; i < pairs.count; i++) {
        const pinch_pair *pair = pinch_island_pair(store, pairs, i);
        for (int side = 0; side < 2; side++) {
            pinch_step_body *body = side_of(task, pair, side);
            if (body) body->overlaps_deeply = body->overlaps_deeply || pair->overlaps_deeply;
        }
    }
    for (int i = 0; i < pairs.count; i++) {
        const pinch_pair *pair = pinch_island_pair(store, pairs, i);
        const pinch_step_body *first = side_of(task, pair, 0), *second = side_of(task, pair, 1);
        if (pair->has_material ||
            !(pair->overlaps_deeply || (first && second && first->overlaps_deeply && second->overlaps_deeply)))
            continue;
        for (int k = 0; k < pair->manifold.count; k++)
            pinch_surface_limit_friction(&store->surfaces.items[pair->manifold.point[k].own->surface].surface,
                                         pinch_pair_size(store, pair), &task->filled[pair->first_in_island + k]);
    }
}

void pinch_fill_contacts(const pinch_step_context *context, const pinch_contact_store *contacts,
                         const pinch_step_bodies *bodies, const pinch_island *island, pinch_problem *problem)
{
    fill_task task = {context, contacts, bodies, island, problem->contacts, false};
    pinch_each(problem->crew, island->pairs.count, fill_pairs, &task);
    if (task.overlaps_deeply) limit_friction_inside(&task);
}
