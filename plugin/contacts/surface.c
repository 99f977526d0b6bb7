/*
 * ODE's contact rows are  w + cfm r = erp depth/h  with r >= 0, and  w + cfm r = motion  with |r| limited
 * (dxJointContact in ODE's sources). The first is a spring and damper, erp = h kn/(h kn + cn), cfm = 1/(h kn + cn); the
 * second has no memory and creeps. Here the tangents get a spring of their own, in proportion to the normal's.
 */
#include "contacts/surface.h"

#include "support/extremes.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* A compliance of 0 is replaced by this part of what the bodies' masses give a contact in a step, which is far below
 * every compliance floor. */
static const double NO_COMPLIANCE = 1e-9;

/*
 * Friction without a limit is solved as a row without one, as in ODE. Where nothing presses, that would be glue: a
 * point that did not press in the last step has this coefficient in the next.
 */
static const double UNLIMITED = 10;

/* ODE's manual has bounces from 0 to 1. A larger one would give energy in each impact, which the account of what pushes
 * give would take away again, and all of the bounce with it. */
static const double ELASTIC = 1;

/* The coefficient of friction without a limit between bodies that are in each other. */
static const double INSIDE = 1;

/*
 * Bodies that should be hard and are found deep in each other, by more than this part of their size, come apart at the
 * pace of that depth. erp depth/h would shoot them: a depth of 0.2 m in steps of 2 ms is 20 m/s. Nor do they come apart
 * faster than takes them out against gravity: the shorter the step, the higher they would hop. Contacts that are soft
 * by their own parameters (their compliance is no small part of what inertia gives them in a step) are meant to be
 * deep. So deep as bodies have come by their own motion of late, they may come out at ODE's pace: after a single step
 * it is erp times the speed that they came with, and no energy is gained; after many it is twice that speed at most.
 * And what the program moves into a body step by step by its pose, without a velocity, as a geom whose pose is set,
 * does not go through it: where that is faster than half the pace of deep bodies, the contact comes apart as fast at
 * least.
 *
 * In steps of LONG_STEP seconds the part of the size is slow enough, and in shorter ones as fast: jams come apart, and
 * small weights are no reason to stay. Without weight there is no height to hop to.
 *
 * In a step that is shorter than others of late a hard contact takes back the less, and all of this goes at the pace of
 * the longest of these: a depth may be what the contact bears its load with, which is the deeper the longer the step
 * is.
 */
static const double DEEP = 0.02, STIFF = 0.01, LONG_STEP = 5e-3, SLOWLY_POSED = 0.5;

static double not_negative(double value)
{
    return value > 0 ? value : 0;
}

static bool all_numbers(const dSurfaceParameters *s)
{
    double sum = s->mu < 0 ? 0 : isnan(s->mu);
    if (s->mode & dContactMu2) sum += isnan(s->mu2);
    if (s->mode & dContactBounce) sum += !isfinite(s->bounce) + isnan(s->bounce_vel);
    if (s->mode & dContactSoftERP) sum += !(s->soft_erp >= 0 && s->soft_erp <= 1);
    if (s->mode & dContactSoftCFM) sum += !(s->soft_cfm >= 0 && isfinite(s->soft_cfm));
    if (s->mode & dContactMotion1) sum += !isfinite(s->motion1);
    if (s->mode & dContactMotion2) sum += !isfinite(s->motion2);
    if (s->mode & dContactMotionN) sum += !isfinite(s->motionN);
    if (s->mode & dContactSlip1) sum += !(s->slip1 >= 0 && isfinite(s->slip1));
    if (s->mode & dContactSlip2) sum += !(s->slip2 >= 0 && isfinite(s->slip2));
    if (s->mode & dContactRolling) sum += isnan(s->rho);
    if ((s->mode & dContactRolling) && (s->mode & dContactAxisDep)) sum += isnan(s->rho2) + isnan(s->rhoN);
    return sum == 0;
}

bool pinch_surface_is_given_again(const dSurfaceParameters *a, const dSurfaceParameters *b)
{
    int mode = a->mode;
    bool again = mode == b->mode && a->mu == b->mu;
    if (mode & dContactMu2) again = again && a->mu2 == b->mu2;
    if (mode & dContactBounce) again = again && a->bounce == b->bounce && a->bounce_vel == b->bounce_vel;
    if (mode & dContactSoftERP) again = again && a->soft_erp == b->soft_erp;
    if (mode & dContactSoftCFM) again = again && a->soft_cfm == b->soft_cfm;
    if (mode & dContactMotion1) again = again && a->motion1 == b->motion1;
    if (mode & dContactMotion2) again = again && a->motion2 == b->motion2;
    if (mode & dContactMotionN) again = again && a->motionN == b->motionN;
    if (mode & dContactSlip1) again = again && a->slip1 == b->slip1;
    if (mode & dContactSlip2) again = again && a->slip2 == b->slip2;
    if (mode & dContactRolling) again = again && a->rho == b->rho;
    if ((mode & dContactRolling) && (mode & dContactAxisDep)) again = again && a->rho2 == b->rho2 && a->rhoN == b->rhoN;
    return again;
}

bool pinch_surface_direction(const dContact *contact, double *tangent)
{
    if (!(contact->surface.mode & dContactFDir1)) return false;
    pinch_v3_copy(tangent, contact->fdir1);
    double given = pinch_v3_norm(tangent);
    pinch_v3_make_perpendicular(tangent, contact->geom.normal);
    double length = pinch_v3_norm(tangent);
    if (!(length > 1e-6 * given && isfinite(length))) return false;
    pinch_v3_scale(tangent, 1 / length);
    return true;
}

void pinch_surface_tangent(const double *normal, double *tangent)
{
    dVector3 n = {normal[0], normal[1], normal[2]}, p, q;
    dPlaneSpace(n, p, q);
    pinch_v3_copy(tangent, p);
}

static void read_friction(const dSurfaceParameters *from, pinch_surface *s)
{
    bool by_axis = from->mode & dContactMu2, first = from->mode & dContactApprox1_1;
    bool second = from->mode & dContactApprox1_2, about = from->mode & dContactApprox1_N;
    s->friction[0] = not_negative(from->mu);
    s->friction[1] = by_axis ? not_negative(from->mu2) : s->friction[0];
    s->coefficient[0] = s->coefficient[3] = first;
    s->coefficient[1] = s->coefficient[4] = second;
    s->coefficient[2] = about;
    if (!(from->mode & dContactRolling)) return;
    s->friction[3] = not_negative(from->rho);
    s->friction[4] = by_axis ? not_negative(from->rho2) : s->friction[3];
    s->friction[2] = by_axis ? not_negative(from->rhoN) : s->friction[3];
    s->rolls = s->friction[2] > 0 || s->friction[3] > 0 || s->friction[4] > 0;
}

bool pinch_surface_of(const dContact *contact, bool swapped, pinch_surface *s)
{
    const dSurfaceParameters *from = &contact->surface;
    memset(s, 0, sizeof *s);
    if (!all_numbers(from)) return false;
    read_friction(from, s);
    s->erp = from->mode & dContactSoftERP ? from->soft_erp : NAN;
    s->cfm = from->mode & dContactSoftCFM ? from->soft_cfm : NAN;
    if (from->mode & dContactBounce && from->bounce_vel >= 0) {
        s->bounce = fmin(from->bounce, ELASTIC);
        s->bounce_velocity = from->bounce_vel;
    }
    if (from->mode & dContactMotionN) s->motion[0] = from->motionN;
    if (from->mode & dContactMotion1) s->motion[1] = from->motion1;
    if (from->mode & dContactMotion2) s->motion[2] = from->motion2;
    if (from->mode & dContactSlip1) s->slip[0] = from->slip1;
    if (from->mode & dContactSlip2) s->slip[1] = from->slip2;
    /* with bodies and normal exchanged and tangent1 kept, tangent2 turns round: along it the relative velocity is the
     * same, along tangent1 the opposite */
    if (swapped) s->motion[1] = -s->motion[1];
    return true;
}

/*
 * Returns the normal row's right hand side as ODE builds it: the push-out velocity and the motion that is aimed at,
 * together no faster than the world allows, or the bounce where that is faster. *rebound is by how much it is.
 */
static double target_velocity(const pinch_surface *s, const pinch_world_values *world, double push_out, double approach,
                              double *rebound)
{
    double slow = pinch_smaller(world->correcting_velocity, push_out + s->motion[0]), target = slow;
    double outgoing = approach - s->motion[0];
    if (s->bounce != 0 && -outgoing > s->bounce_velocity) target = fmax(slow, -s->bounce * outgoing + s->motion[0]);
    *rebound = target - slow;
    return target;
}

/*
 * Adds what the bodies come in by in a step, at their velocities before it. A body on a curved path does so in each
 * step, along a tangent of the path: a ball in a bowl, and a disc that rolls on its rim. What has come in is pushed out
 * by the part erp in each step, and forgotten by half of that. Bodies that come in at a steady speed may then come
 * apart at up to twice that speed. A disc that rocks needs it: pushed on one side, it turns and comes in on the other.
 *
 * What has come in within this step alone is on no such path, nor is what comes apart again, nor what gives way to its
 * force, as in a jam.
 */
static void add_approach(pinch_surface_conditions *conditions, double h, double erp, double depth)
{
    static const double FORGOTTEN = 0.5; /* in a step, of erp */
    double in_step = not_negative(-h * conditions->approach);
    double along_path = not_negative(in_step - h * conditions->gives_way);
    double still = (1 - FORGOTTEN * erp) * conditions->recent_approach;
    conditions->recent_approach = pinch_smaller(still + along_path, depth);
    double at_a_time = along_path > 0 ? pinch_larger(in_step, still) : in_step;
    conditions->approach_depth = pinch_smaller(pinch_larger(at_a_time, conditions->approach_depth), depth);
}

double pinch_surface_erp(const pinch_step_context *context, const pinch_surface *s)
{
    return isnan(s->erp) ? pinch_within(context->values.erp, 0, 1) : s->erp;
}

/*
 * Returns the depth (m) at the pace of which bodies that are so deep in each other come apart. What the contact's own
 * compliance gives way to the force that it bears comes back at twice that pace at least: joints may put more weight on
 * a light body than its mass tells, and it would sink for good.
 */
static double deepest_in(const pinch_step_context *context, pinch_surface_conditions *conditions, double erp,
                         double cfm, double depth)
{
    double limit = DEEP * conditions->size, pace = context->h / erp;
    double g = pinch_v3_norm(context->gravity), most = limit, slow = limit * conditions->paced_step / LONG_STEP;
    if (g > 0) most = pinch_smaller(pinch_larger(pace * sqrt(2 * g * depth), slow), limit);
    if (!(pace * conditions->pose_speed > SLOWLY_POSED * most)) conditions->pose_speed = 0;
    /* where erp is 0, the pace has no bound, and no number comes of it beside a contact that bears nothing */
    return pinch_larger(pace * pinch_larger(2 * cfm * conditions->force, conditions->pose_speed),
                        pinch_larger(most, conditions->approach_depth));
}

static void set_limit(const pinch_surface *s, const pinch_surface_conditions *conditions, int i, double *coefficient,
                      double *limit)
{
    bool pressed = conditions->force > 0;
    *coefficient = s->coefficient[i] ? s->friction[i] : 0;
    *limit = s->coefficient[i] ? 0 : conditions->stands_for * s->friction[i];
    if (isinf(s->friction[i])) {
        *coefficient = pressed ? 0 : UNLIMITED;
        *limit = pressed ? INFINITY : 0;
    }
}

static void set_friction(const pinch_surface *s, const pinch_surface_conditions *conditions, pinch_contact *c)
{
    for (int i = 0; i < 2; i++) {
        set_limit(s, conditions, i, &c->friction[i], &c->friction_limit[i]);
        set_limit(s, conditions, 3 + i, &c->rolling_friction[i], &c->friction_limit[3 + i]);
        c->viscous[i] = s->slip[i] / conditions->stands_for;
    }
    set_limit(s, conditions, 2, &c->torsional_friction, &c->friction_limit[2]);
}

bool pinch_surface_has_forces(const pinch_surface *s)
{
    for (int i = 0; i < 5; i++)
        if (!s->coefficient[i] && s->friction[i] > 0 && !isinf(s->friction[i])) return true;
    return false;
}

void pinch_surface_limit_friction(const pinch_surface *s, double size, pinch_contact *c)
{
    double *const coefficients[5] = {&c->friction[0], &c->friction[1], &c->torsional_friction, &c->rolling_friction[0],
                                     &c->rolling_friction[1]};
    for (int i = 0; i < 5; i++) {
        if (!isinf(s->friction[i])) continue;
        *coefficients[i] = i < 2 ? INSIDE : INSIDE * size;
        c->friction_limit[i] = 0;
    }
}

static void set_tangent(const double *tangent1, pinch_contact *c)
{
    pinch_v3_copy(c->tangent1, tangent1);
    pinch_v3_make_perpendicular(c->tangent1, c->normal);
    double length = pinch_v3_norm(c->tangent1);
    if (length > 1e-6)
        pinch_v3_scale(c->tangent1, 1 / length);
    else
        pinch_v3_any_perpendicular(c->normal, c->tangent1);
}

/*
 * Returns the least compliance, as a part of what the bodies' inertia gives a contact in a step. Many contacts of a
 * pair share a load in equal parts, or in proportion to what they stand for. A solve gives stiff contacts a floor of
 * compliance that is another one at each place, and leaves most to those in the middle. So they are softer than that
 * floor, and by as much softer than the stiffest of them as they stand for fewer; but no springs, and not so soft that
 * what is heavy beside the bodies' own mass sinks.
 */
static double least_compliance(const pinch_surface_conditions *conditions, double h, double erp)
{
    static const double ABOVE_FLOORS = 7.1e-4, SUNK = 1e-4; /* the first at the corner of a box; of the size */
    if (!(conditions->part > 0)) return NO_COMPLIANCE;
    double most = conditions->bears * conditions->stands_for / conditions->part; /* N, on the stiffest */
    double sinks = h * h * conditions->mobility * most; /* m, times erp: with as much compliance as inertia gives */
    double bearable = SUNK * conditions->size * erp;    /* of which there is none at an ERP of 0 */
    double least = sinks * ABOVE_FLOORS > bearable ? bearable / sinks : ABOVE_FLOORS;
    return pinch_within(least / conditions->part, NO_COMPLIANCE, 0.9 * STIFF);
}

double pinch_surface_apply(const pinch_step_context *context, const pinch_surface *s,
                           pinch_surface_conditions *conditions, pinch_contact *c)
{
    const pinch_world_values *world = &context->values;
    double h = context->h;
    double erp = pinch_surface_erp(context, s);
    double cfm = isnan(s->cfm) ? not_negative(world->cfm) : s->cfm;
    conditions->yields = erp > 0 ? h * cfm / erp : INFINITY;
    cfm /= conditions->stands_for;
    bool stiff = cfm < STIFF * conditions->paced_step * conditions->mobility; /* a short step makes no springs */
    if (stiff) erp *= h / conditions->paced_step;
    cfm = pinch_larger(cfm, least_compliance(conditions, h, erp) * h * conditions->mobility);
    c->model = s->rolls ? PINCH_CONTACT_ROLLING : PINCH_CONTACT_HARD;
    c->may_soften = true;
    for (int i = 0; i < 3; i++) {
        double ratio = i == 1 ? context->settings.tangential_ratio : 1;
        c->stiffness[i] = ratio * erp / (h * cfm);
        c->damping[i] = ratio * (1 - erp) / cfm;
    }
    set_tangent(conditions->tangent1, c);
    set_friction(s, conditions, c);

    if (c->depth > 0) c->depth = not_negative(c->depth - world->surface_layer);
    add_approach(conditions, h, erp, c->depth);
    double pressed_in = c->depth, push_out = erp * c->depth / h;
    if (stiff && pressed_in > conditions->approach_depth)
        pressed_in = pinch_smaller(deepest_in(context, conditions, erp, cfm, pressed_in), pressed_in);
    else
        conditions->pose_speed = 0;
    double rebound, target = target_velocity(s, world, erp * pressed_in / h, conditions->approach, &rebound);
    conditions->eased = push_out + s->motion[0] - (target - rebound);
    c->surface_velocity[0] -= target - push_out;
    c->surface_velocity[1] -= s->motion[1];
    c->surface_velocity[2] -= s->motion[2];
    return rebound;
}
