/* One island's part of a step: its data filled in, solved, checked and read out. Touches nothing of other islands. */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* The island's problem, on the thread's desk or where it is to stay; still empty. False: no memory. */
static bool lay_out(pinch_ode *p, int worker, const pinch_island *island, double h, pinch_problem *problem)
{
    bool keep = p->settings.keep_islands;
    pinch_desk *desk = keep ? &p->kept : &p->desk[worker];
    int rows = PINCH_JOINT_MAX_ROWS * island->joint_count;
    if (!keep && !pinch_desk_reserve(desk, island->body_count, island->contact_count, rows + 1)) return false;
    *problem = (pinch_problem){
        .step = h,
        .faces = p->settings.faces,
        .memory = p->settings.cold_start ? NULL : p->memories.items[island - p->islands.items],
        .tag = (uint64_t)(uintptr_t)p->bodies.items[p->body_of.items[island->first_body]].body,
        .body_count = island->body_count,
        .contact_count = island->contact_count,
        .bodies = desk->bodies.items + (keep ? island->first_body : 0),
        .contacts = desk->contacts.items + (keep ? island->first_contact : 0),
        .rows = desk->rows.items + (keep ? PINCH_JOINT_MAX_ROWS * island->first_joint : 0),
    };
    return true;
}

static void fill(pinch_ode *p, pinch_island *island, double h, pinch_problem *problem)
{
    pinch_fill_bodies(p, island, h, problem->bodies);
    pinch_fill_joints(p, island, h, problem);
    pinch_apply_external(problem->bodies, problem->body_count, h);
    pinch_fill_contacts(p, island, h, problem->contacts);
}

static void forget_warm_start(pinch_problem *problem)
{
    for (int k = 0; k < problem->contact_count; k++) {
        memset(problem->contacts[k].force, 0, sizeof problem->contacts[k].force);
        memset(problem->contacts[k].rolling_moment, 0, sizeof problem->contacts[k].rolling_moment);
    }
    for (int k = 0; k < problem->row_count; k++) problem->rows[k].force = 0;
}

/* Velocities that no body has, and whose squares soon are no numbers. */
static bool overflows(const pinch_problem *problem)
{
    static const double LARGEST = 1e100;
    for (int b = 0; b < problem->body_count; b++)
        for (int i = 0; i < 6; i++)
            if (!(fabs(problem->bodies[b].velocity_end[i]) < LARGEST)) return true;
    return false;
}

/* The declared order of falling back: the solver asked for, from the last forces; NSNMGK with Newton's steps from no
 * forces; Newton alone from none. */
static void try_solvers(pinch_ode *p, pinch_step_solver *solver, pinch_problem *problem, pinch_island *island)
{
    pinch_solver_settings settings[3] = {p->settings.solver, p->settings.solver, p->settings.solver};
    settings[1].solver = PINCH_SOLVER_NSNMGK;
    settings[1].newton_finish = true;
    settings[2].solver = PINCH_SOLVER_NEWTON;
    pinch_step_result *result = &island->result;
    island->solved = island->first_try = false;
    for (int attempt = 0; attempt < 3 && !island->solved; attempt++) {
        if (attempt > 0 || p->settings.cold_start) forget_warm_start(problem);
        island->status = pinch_step_solve(solver, problem, &settings[attempt], result);
        if (island->status == PINCH_UNSUPPORTED) continue; /* the reference methods do not know all laws */
        if (island->status != PINCH_OK) return;
        island->solved = result->solve.status == PINCH_SOLVE_CONVERGED;
        island->first_try = island->solved && attempt == 0;
    }
    /* numbers that overflow in here would do so in ODE's solver, too */
    bool overflow = result->solve.status == PINCH_SOLVE_DIVERGED || (island->solved && overflows(problem));
    island->status = overflow ? PINCH_INVALID_ARGUMENT : PINCH_OK;
    if (overflow) island->solved = false;
}

/* Adds a contact force to what its body is to get. */
static void add_wrench(pinch_step_body *body, const double *point, const double *force, double sign)
{
    double arm[3], torque[3];
    pinch_v3_sub(point, body->position, arm);
    pinch_v3_cross(arm, force, torque);
    pinch_v3_add_scaled(body->wrench, sign, force);
    pinch_v3_add_scaled(body->wrench + 3, sign, torque);
}

static double smaller_limit(const pinch_contact *c)
{
    double limit[2];
    for (int i = 0; i < 2; i++) limit[i] = c->friction_limit[i] + c->friction[i] * c->force[0];
    return limit[0] < limit[1] ? limit[0] : limit[1];
}

/* Copies the solution of one contact into the read-out. */
static void read_out(const pinch_contact *c, pinch_ode_contact *out)
{
    double t2[3];
    pinch_v3_cross(c->normal, c->tangent1, t2);
    pinch_v3_copy(out->position, c->position);
    pinch_v3_copy(out->normal, c->normal);
    pinch_v3_copy(out->stiffness, c->stiffness);
    out->depth = c->depth;
    out->normal_force = c->force[0];
    out->torsion = c->force[3];
    out->twist = c->elastic_end[2];
    out->slip_twist = c->slip[2];
    out->spin = c->relative_velocity[3];
    out->friction_limit = c->model == PINCH_CONTACT_FRICTIONLESS ? 0 : smaller_limit(c);
    out->state = c->state;
    for (int i = 0; i < 3; i++) {
        out->tangential[i] = c->tangent1[i] * c->force[1] + t2[i] * c->force[2];
        out->rolling_moment[i] = 0;
        if (c->model == PINCH_CONTACT_ROLLING)
            out->rolling_moment[i] = c->tangent1[i] * c->rolling_moment[0] + t2[i] * c->rolling_moment[1];
        out->force[i] = c->normal[i] * c->force[0] + out->tangential[i];
        out->elastic[i] = c->tangent1[i] * c->elastic_end[0] + t2[i] * c->elastic_end[1];
        out->slip[i] = c->tangent1[i] * c->slip[0] + t2[i] * c->slip[1];
        out->relative_velocity[i] = c->normal[i] * c->relative_velocity[0] + c->tangent1[i] * c->relative_velocity[1] +
                                    t2[i] * c->relative_velocity[2];
    }
}

static void name_point(const pinch_pair *pair, pinch_ode_contact *out)
{
    out->geom1 = pair->id[0];
    out->geom2 = pair->id[1];
    out->body1 = pair->body[0];
    out->body2 = pair->body[1];
}

/* Where there is no answer: whose points they are, and no force. */
static void leave_unsolved(pinch_ode *p, pinch_island *island)
{
    island->solved = island->rests = false;
    for (int i = 0; i < island->pair_count; i++) {
        const pinch_pair *pair = &p->pairs.items[p->pair_of.items[island->first_pair + i]];
        for (int k = 0; k < pair->manifold.count; k++) {
            pinch_ode_contact *out = &p->contacts.items[pair->first_contact + k];
            memset(out, 0, sizeof *out);
            name_point(pair, out);
        }
    }
}

/* An answer that is not to be given to ODE, and not to pass for one. */
static void refuse(pinch_ode *p, pinch_island *island, pinch_problem *problem)
{
    for (int k = 0; k < problem->contact_count; k++) problem->contacts[k].force[0] = NAN;
    leave_unsolved(p, island);
}

/* What only a point with surface parameters of its own has. */
static void keep_own(const pinch_contact *c, const double *rolling_moment, const pinch_manifold_point *point)
{
    pinch_own_law *own = point->own;
    pinch_rolling *rolling = pinch_rolling_of(point);
    double t2[3];
    pinch_v3_cross(c->normal, c->tangent1, t2);
    for (int i = 0; i < 3 && rolling; i++)
        rolling->rolled[i] = c->tangent1[i] * c->rolling_elastic_end[0] + t2[i] * c->rolling_elastic_end[1];
    if (rolling) pinch_v3_copy(rolling->moment, rolling_moment);
    pinch_v3_copy(own->compliance, c->compliance);
    own->floor = c->floor;
    own->hold = c->hold;
}

/* Results to the read-out, and the contacts' forces and torques to the bodies. */
static void read_out_pair(pinch_ode *p, const pinch_pair *pair, const pinch_contact *contacts, double *depth_max)
{
    for (int k = 0; k < pair->manifold.count; k++) {
        const pinch_contact *c = &contacts[pair->first_core + k];
        pinch_ode_contact *out = &p->contacts.items[pair->first_contact + k];
        name_point(pair, out);
        read_out(c, out);
        for (int side = 0; side < 2; side++) {
            if (pair->step_body[side] < 0) continue;
            double sign = side ? -1 : 1;
            pinch_step_body *body = &p->bodies.items[pair->step_body[side]];
            add_wrench(body, c->position, out->force, sign);
            if (c->model >= PINCH_CONTACT_SOFT) pinch_v3_add_scaled(body->wrench + 3, sign * c->force[3], c->normal);
            if (c->model == PINCH_CONTACT_ROLLING) pinch_v3_add_scaled(body->wrench + 3, sign, out->rolling_moment);
        }
        if (!pair->has_material) keep_own(c, out->rolling_moment, &pair->manifold.point[k]);
        if (c->depth > *depth_max) *depth_max = c->depth;
    }
}

static void read_bodies(pinch_ode *p, const pinch_island *island, const pinch_body *bodies)
{
    for (int k = 0; k < island->body_count; k++) {
        pinch_step_body *b = pinch_island_body(p, island, k);
        pinch_v3_copy(b->position, bodies[k].position);
        memcpy(b->velocity, bodies[k].velocity_end, sizeof b->velocity);
    }
}

/* What a solve leaves in an island that stays where it is in the layout. */
static void clear_answer(pinch_ode *p, pinch_island *island)
{
    for (int k = 0; k < island->body_count; k++) {
        pinch_step_body *b = pinch_island_body(p, island, k);
        memset(b->wrench, 0, sizeof b->wrench);
    }
    for (int k = 0; k < island->joint_count; k++) pinch_island_joint(p, island, k)->met = false;
    island->solved = island->first_try = island->rests = island->again = island->takes_joints = false;
    island->depth_max = island->mismatch[0] = island->mismatch[1] = 0;
}

void pinch_solve_island(pinch_ode *p, int worker, pinch_island *island, double h)
{
    const int *pairs = p->pair_of.items + island->first_pair;
    pinch_problem problem;
    if (pinch_island_same(p, worker, island, h)) {
        pinch_rest_on(p, island);
        return;
    }
    clear_answer(p, island);
    if (!lay_out(p, worker, island, h, &problem)) {
        island->status = PINCH_OUT_OF_MEMORY;
        return;
    }
    fill(p, island, h, &problem);
    if (island->awake && pinch_joints_left_anyway(p, island)) {
        island->first_try = true; /* none has failed */
        refuse(p, island, &problem);
        return;
    }
    if (island->awake && !p->settings.ode_solves) try_solvers(p, p->solver[worker], &problem, island);
    if (!island->awake || island->status != PINCH_OK || !island->solved) {
        leave_unsolved(p, island);
        return;
    }
    island->rests = (island->joint_count == 0 || p->at_once) && pinch_island_rests(p, island, h, &problem);
    if (island->rests) pinch_bring_to_rest(&problem);
    read_bodies(p, island, problem.bodies);
    if (pinch_drives_run_away(p, island, h)) {
        refuse(p, island, &problem);
        return;
    }
    pinch_read_joints(p, island, &problem);
    for (int i = 0; i < island->pair_count; i++)
        read_out_pair(p, &p->pairs.items[pairs[i]], problem.contacts, &island->depth_max);
    pinch_give_forces(p, island);
    if (p->at_once) pinch_give_joint_forces(p, island, h);
    if (pinch_joints_distrusted(p, island, h)) {
        pinch_take_back_forces(p, island);
        refuse(p, island, &problem);
        return;
    }
    island->rests = island->rests && (island->joint_count == 0 || island->takes_joints);
    if (!island->rests) return;
    pinch_hold_still(p, island);
    island->joint_bits = pinch_joint_bits(island, problem.rows, problem.row_count);
}
