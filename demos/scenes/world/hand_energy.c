/*
 * The part of hands in the energy ledger.
 *
 * With the velocities at the end of a step, the works of all forces on a body add up to its change of kinetic energy
 * and what the step loses. A joint's feedback holds its servo, whose work is a drive's, its dry friction, and its
 * stops, but not what pushes it beside the servo. What it takes to move the base, which has no inertia here, is a
 * drive's work, too. Springs and armatures store energy; what their law takes beyond that and the damping is the
 * step's.
 */
#include "world_hand.h"

#include "common/vector.h"

#include <math.h>
#include <string.h>

static double along(const double row[6], dBodyID body)
{
    return scene_dot(row, dBodyGetLinearVel(body)) + scene_dot(row + 3, dBodyGetAngularVel(body));
}

static double power(const double force[3], const double torque[3], dBodyID body)
{
    return scene_dot(force, dBodyGetLinearVel(body)) + scene_dot(torque, dBodyGetAngularVel(body));
}

/* The part of the rate that is the base's. */
static double base_rate(const world_joint *j)
{
    return dBodyIsKinematic(j->parent) ? along(j->row[1], j->parent) : 0;
}

static double storage_of(const world_joint *j, double rate)
{
    double stretched = j->position - j->of->spring_reference;
    return 0.5 * j->of->armature * rate * rate + 0.5 * j->of->stiffness * stretched * stretched;
}

void world_begin_hand_ledger(world *w, bool first)
{
    for (int k = 0; k < w->hand_count; k++) {
        for (int i = 0; i < w->hands[k].joint_count; i++) {
            world_joint *j = &w->hands[k].joints[i];
            j->energy.body = j->body;
            energy_body_begin(&j->energy, first);
            if (first) j->storage = j->storage_start = storage_of(j, j->velocity);
            memset(&j->feedback, 0, sizeof j->feedback);
        }
        for (int i = 0; i < w->hands[k].loop_count; i++)
            memset(&w->hands[k].loops[i].feedback, 0, sizeof w->hands[k].loops[i].feedback);
    }
}

static void add_body(world *w, const world_joint *j, double h)
{
    energy_ledger *l = &w->ledger;
    dMass mass;
    const double *v = dBodyGetLinearVel(j->body);
    dBodyGetMass(j->body, &mass);
    ledger_add(l, &l->gravity, -h * mass.mass * scene_dot(w->loads.v[SCENE_GRAVITY], v));
    ledger_add(l, &l->work_external, -h * mass.mass * scene_dot(w->loads.v[SCENE_BASE_ACCELERATION], v));
    if (j->relieved > 0) ledger_add(l, &l->gravity, -h * power(j->relief_force, j->relief_torque, j->body));
    l->integrator += energy_body_integrator(&j->energy, h);
    l->kinetic += body_kinetic_energy(j->body) - j->energy.kinetic_start;
}

/* A force f along a coordinate whose rate has a part that is the base's: what the base does, and what remains. */
static double split_work(energy_ledger *l, double h, double force, double rate, double of_base)
{
    ledger_add(l, &l->work_drives, -h * force * of_base);
    return h * force * rate;
}

static void add_joint(world *w, const world_joint *j, double h)
{
    energy_ledger *l = &w->ledger;
    const dJointFeedback *f = &j->feedback;
    double rate = world_joint_rate(j), outer = h * power(f->f1, f->t1, j->body),
           inner = h * power(f->f2, f->t2, j->parent);
    double motor = h * j->own_torque * rate, rest = outer + inner - h * (j->own_torque - j->pushed) * rate;
    ledger_add(l, &l->work_drives, motor);
    if (j->pushed != 0) ledger_add(l, &l->work_drives, -h * j->pushed * base_rate(j));
    if (dBodyIsKinematic(j->parent)) ledger_add(l, &l->work_drives, -inner);
    /* Dry friction that does work is at its bound. What remains is that of the joint's other rows, of stops and of
     * errors that are taken back. */
    double rubbed = j->at_limit ? 0 : h * j->of->friction * fabs(rate);
    ledger_add(l, &l->friction, rubbed);
    l->integrator -= rest + rubbed;
}

static void add_damper(world *w, world_joint *j, double h)
{
    energy_ledger *l = &w->ledger;
    double position, force, rate = world_joint_rate(j), storage = storage_of(j, rate);
    if (j->damper < 0) return;
    if (pinch_ode_coupling_state(w->plugin, j->damper, &position, &force) != PINCH_OK) return;
    double work = split_work(l, h, force, rate, base_rate(j)), lost = h * j->of->damping * rate * rate;
    ledger_add(l, &l->damping, lost);
    l->elastic += storage - j->storage_start;
    l->integrator += -work - (storage - j->storage) - lost;
    j->storage = storage;
}

static void add_tie(world *w, const world_hand *of, const world_tie *t, double h)
{
    energy_ledger *l = &w->ledger;
    double rate = 0, of_base = 0;
    for (int i = 0; i < t->terms; i++) {
        rate += t->factor[i] * world_joint_rate(&of->joints[t->joint[i]]);
        of_base += t->factor[i] * base_rate(&of->joints[t->joint[i]]);
    }
    double work = split_work(l, h, t->force, rate, of_base);
    if (t->control)
        ledger_add(l, &l->work_drives, work);
    else if (t->is_friction)
        ledger_add(l, &l->friction, -work);
    else if (t->dissipates)
        ledger_add(l, &l->damping, -work);
    else
        l->integrator -= work;
}

/* A connection does no work but for taking back errors of position. */
static void add_loop(world *w, const world_loop *loop, double h)
{
    for (int side = 0; side < 2; side++) {
        dBodyID body = dJointGetBody(loop->ball, side);
        const dJointFeedback *f = &loop->feedback;
        double work = h * power(side ? f->f2 : f->f1, side ? f->t2 : f->t1, body);
        if (dBodyIsKinematic(body)) ledger_add(&w->ledger, &w->ledger.work_drives, -work);
        w->ledger.integrator -= work;
    }
}

void world_update_hand_ledger(world *w)
{
    double h = w->scene->step;
    for (int k = 0; k < w->hand_count; k++) {
        const world_hand *of = &w->hands[k];
        for (int i = 0; i < of->joint_count; i++) {
            add_body(w, &of->joints[i], h);
            add_joint(w, &of->joints[i], h);
            add_damper(w, &of->joints[i], h);
        }
        for (int i = 0; i < of->tie_count; i++) add_tie(w, of, &of->ties[i], h);
        for (int i = 0; i < of->loop_count; i++) add_loop(w, &of->loops[i], h);
    }
}
