/* The stations of a step: solve, hand the forces to ODE, let it step, carry the contact histories on. */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static void forget_warm_start(pinch_problem *problem)
{
    for (int k = 0; k < problem->contact_count; k++) {
        memset(problem->contacts[k].force, 0, sizeof problem->contacts[k].force);
        memset(problem->contacts[k].rolling_moment, 0, sizeof problem->contacts[k].rolling_moment);
    }
    for (int k = 0; k < problem->row_count; k++) problem->rows[k].force = 0;
}

/* Keeps the statistics of one island's solve. */
static void count_solve(pinch_ode_stats *stats, const pinch_step_result *result)
{
    stats->islands++;
    stats->iterations += result->solve.iterations;
    stats->projections += result->solve.projections;
    stats->newton_steps += result->solve.newton_steps;
    if (result->solve.iterations > stats->iterations_max) stats->iterations_max = result->solve.iterations;
    stats->residual_max = larger(stats->residual_max, result->residual_max);
    stats->cone = larger(stats->cone, result->cone);
    stats->complementarity = larger(stats->complementarity, result->complementarity);
    stats->slip_direction = larger(stats->slip_direction, result->slip_direction);
    stats->force_scale = larger(stats->force_scale, result->force_scale);
    stats->softened_islands += result->floor_depth > 0;
    stats->floor_depth_max = larger(stats->floor_depth_max, result->floor_depth);
    if (result->rung > stats->rung_max) stats->rung_max = result->rung;
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
static pinch_status solve_island(pinch_ode *p, pinch_problem *problem, bool *first_try, bool *solved)
{
    pinch_solver_settings settings[3] = {p->settings.solver, p->settings.solver, p->settings.solver};
    settings[1].solver = PINCH_SOLVER_NSNMGK;
    settings[1].newton_finish = true;
    settings[2].solver = PINCH_SOLVER_NEWTON;
    pinch_step_result result;
    *solved = false;
    for (int attempt = 0; attempt < 3 && !*solved; attempt++) {
        if (attempt > 0 || p->settings.cold_start) forget_warm_start(problem);
        pinch_status status = pinch_step_solve(p->solver, problem, &settings[attempt], &result);
        if (status == PINCH_UNSUPPORTED) continue; /* the reference methods do not know all laws */
        if (status != PINCH_OK) return status;
        *solved = result.solve.status == PINCH_SOLVE_CONVERGED;
        if (attempt == 0)
            *first_try = *solved;
        else
            p->stats.retried_islands += *solved;
    }
    if (*solved) count_solve(&p->stats, &result);
    /* numbers that overflow in here would do so in ODE's solver, too */
    return result.solve.status == PINCH_SOLVE_DIVERGED || (*solved && overflows(problem)) ? PINCH_INVALID_ARGUMENT
                                                                                          : PINCH_OK;
}

/* Adds a contact force to what its body is to get; core bodies' `external` has done its work and holds the sum. */
static void add_wrench(pinch_body *body, const double *point, const double *force, double sign)
{
    double arm[3], torque[3];
    pinch_v3_sub(point, body->position, arm);
    pinch_v3_cross(arm, force, torque);
    pinch_v3_add_scaled(body->external, sign, force);
    pinch_v3_add_scaled(body->external + 3, sign, torque);
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
        if (c->model == PINCH_CONTACT_ROLLING)
            out->rolling_moment[i] = c->tangent1[i] * c->rolling_moment[0] + t2[i] * c->rolling_moment[1];
        out->force[i] = c->normal[i] * c->force[0] + out->tangential[i];
        out->elastic[i] = c->tangent1[i] * c->elastic_end[0] + t2[i] * c->elastic_end[1];
        out->slip[i] = c->tangent1[i] * c->slip[0] + t2[i] * c->slip[1];
        out->relative_velocity[i] = c->normal[i] * c->relative_velocity[0] + c->tangent1[i] * c->relative_velocity[1] +
                                    t2[i] * c->relative_velocity[2];
    }
}

static void give_forces(pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->body_count; k++) {
        pinch_step_body *b = &p->bodies.items[p->body_of.items[island->first_body + k]];
        const pinch_body *core = &p->core_bodies.items[island->first_body + k];
        if (b->drive < 0) {
            const double *f = core->external;
            pinch_v3_copy(b->given, dBodyGetForce(b->body));
            pinch_v3_copy(b->given + 3, dBodyGetTorque(b->body));
            dBodyAddForce(b->body, f[0], f[1], f[2]);
            dBodyAddTorque(b->body, f[3], f[4], f[5]);
            continue;
        }
        pinch_drive *drive = &p->drives.items[b->drive];
        drive->speed = pinch_v3_dot(core->velocity_end, drive->axis);
        const double *v = dBodyGetLinearVel(b->body);
        dBodySetLinearVel(b->body, v[0] + drive->speed * drive->axis[0], v[1] + drive->speed * drive->axis[1],
                          v[2] + drive->speed * drive->axis[2]);
    }
}

/* Forces to the bodies, velocities to the force-controlled ones, results to the read-out. */
static void hand_over(pinch_ode *p, const pinch_island *island)
{
    pinch_body *bodies = p->core_bodies.items + island->first_body;
    for (int k = 0; k < island->body_count; k++) memset(bodies[k].external, 0, sizeof bodies[k].external);
    for (int k = 0; k < island->contact_count; k++) {
        int place = island->first_contact + k;
        const pinch_contact *c = &p->core_contacts.items[place];
        pinch_ode_contact *out = &p->contacts.items[p->point_of.items[place]];
        read_out(c, out);
        const int local[2] = {c->body1, c->body2};
        for (int side = 0; side < 2; side++) {
            if (local[side] < 0) continue;
            double sign = side ? -1 : 1;
            add_wrench(&bodies[local[side]], c->position, out->force, sign);
            double *torque = bodies[local[side]].external + 3;
            if (c->model >= PINCH_CONTACT_SOFT) pinch_v3_add_scaled(torque, sign * c->force[3], c->normal);
            if (c->model == PINCH_CONTACT_ROLLING) pinch_v3_add_scaled(torque, sign, out->rolling_moment);
        }
        p->stats.depth_max = larger(p->stats.depth_max, c->depth);
    }
    p->stats.contacts_solved += island->contact_count;
    give_forces(p, island);
}

/* The last resort for one island and one step: its manifold points as ODE contact joints of the same stiffness. */
static void leave_island(pinch_ode *p, const pinch_island *island, double h)
{
    p->stats.fallback_islands++;
    for (int k = 0; k < island->contact_count; k++) {
        int place = island->first_contact + k;
        const pinch_contact *c = &p->core_contacts.items[place];
        pinch_ode_contact *out = &p->contacts.items[p->point_of.items[place]];
        if (p->handed.count > 0) continue; /* the program's own joints stay enabled */
        dContact contact;
        memset(&contact, 0, sizeof contact);
        double g = h * c->stiffness[0] + c->damping[0];
        contact.surface.mode = dContactSoftERP | dContactSoftCFM;
        bool limited = c->friction_limit[0] > 0;
        if (!limited) contact.surface.mode |= dContactApprox1;
        contact.surface.mu = c->model == PINCH_CONTACT_FRICTIONLESS ? 0
                             : limited                              ? c->friction_limit[0]
                                                                    : c->friction[0];
        contact.surface.soft_erp = h * c->stiffness[0] / g;
        contact.surface.soft_cfm = 1 / g;
        contact.geom.depth = c->depth;
        pinch_v3_copy(contact.geom.pos, c->position);
        pinch_v3_copy(contact.geom.normal, c->normal);
        dJointID joint = dJointCreateContact(p->world, p->left, &contact);
        dJointAttach(joint, out->body1, out->body2);
        pinch_left_contact *left = &p->left_contacts.items[p->left_contacts.count++];
        left->contact = p->point_of.items[place];
        left->sign = out->body1 ? 1 : -1; /* attached as (0, body), ODE writes the force on the body first */
        dJointSetFeedback(joint, &left->feedback);
        pinch_v3_copy(out->position, c->position);
        pinch_v3_copy(out->normal, c->normal);
        out->depth = c->depth;
    }
    p->stats.contacts_left += island->contact_count;
    p->stats.contacts_left_unsolved += island->contact_count;
    for (int k = 0; k < island->body_count; k++)
        for (int i = 0; i < 6; i++) p->core_bodies.items[island->first_body + k].velocity_end[i] = NAN;
}

/* The forces that ODE found for contacts that were left to it. Its contacts do not give sideways: no elastic state. */
static void read_left_contacts(pinch_ode *p)
{
    for (int k = 0; k < p->left_contacts.count; k++) {
        const pinch_left_contact *left = &p->left_contacts.items[k];
        pinch_ode_contact *out = &p->contacts.items[left->contact];
        for (int i = 0; i < 3; i++) out->force[i] = left->sign * left->feedback.f1[i];
        out->normal_force = pinch_v3_dot(out->force, out->normal);
        pinch_v3_copy(out->tangential, out->force);
        pinch_v3_add_scaled(out->tangential, -out->normal_force, out->normal);
        out->state = out->normal_force > 0 ? PINCH_CONTACT_STICK : PINCH_CONTACT_OPEN;
    }
}

/* Names and zeroes before the solves. */
static void start_read_out(pinch_ode *p)
{
    for (int i = 0; i < p->pairs.count; i++) {
        const pinch_pair *pair = &p->pairs.items[i];
        for (int k = 0; k < pair->manifold.count; k++) {
            pinch_ode_contact *out = &p->contacts.items[pair->first_contact + k];
            memset(out, 0, sizeof *out);
            out->geom1 = p->geoms.items[pair->geom[0]].geom;
            out->geom2 = p->geoms.items[pair->geom[1]].geom;
            out->body1 = pair->body[0];
            out->body2 = pair->body[1];
        }
    }
}

/* A step that does not come to be: contacts that were left to ODE, and those handed over, are for no other. */
static pinch_status abandon(pinch_ode *p, pinch_status status)
{
    dJointGroupEmpty(p->left);
    for (int i = 0; i < p->pairs.count; i++) p->pairs.items[i].handed_over = -1;
    p->pool.count = p->surfaces.count = p->handed.count = 0;
    return status;
}

/*
 * ODE wakes a disabled body that a joint ties to an enabled one, and lets bodies go to sleep only together. Contacts
 * that it does not see any more must tie them all the same: joints without rows, where anything sleeps or may.
 */
static void link_sleepers(pinch_ode *p)
{
    for (int i = 0; i < p->pairs.count; i++) {
        const pinch_pair *pair = &p->pairs.items[i];
        if (pair->manifold.count == 0 || !pair->body[0] || !pair->body[1]) continue;
        const pinch_island *island = &p->islands.items[pair->island];
        if (!island->may_sleep || !island->solved) continue;
        dJointAttach(dJointCreateNull(p->world, p->left), pair->body[0], pair->body[1]);
    }
}

pinch_status pinch_ode_solve(pinch_ode *p, double h)
{
    if (!p || !(h > 0) || !isfinite(h) || p->solved) return PINCH_INVALID_ARGUMENT;
    if (!pinch_pairs_update(p) || !pinch_gather(p, h)) return abandon(p, PINCH_OUT_OF_MEMORY);
    start_read_out(p);
    p->left_contacts.count = 0; /* room for all: ODE keeps pointers into the list */
    if (!PINCH_RESERVE(p->left_contacts, p->contacts.count)) return abandon(p, PINCH_OUT_OF_MEMORY);

    bool all_first = true;
    for (int k = 0; k < p->islands.count; k++) {
        pinch_island *island = &p->islands.items[k];
        if (!island->awake) {
            p->stats.contacts_asleep += island->contact_count;
            continue;
        }
        if (p->settings.ode_solves) {
            leave_island(p, island, h);
            continue;
        }
        pinch_problem problem = pinch_island_problem(p, island, h);
        bool first_try = false, solved = false;
        pinch_status status = solve_island(p, &problem, &first_try, &solved);
        if (status == PINCH_OUT_OF_MEMORY || status == PINCH_INVALID_ARGUMENT) return abandon(p, status);
        island->solved = status == PINCH_OK && solved;
        if (island->solved)
            hand_over(p, island);
        else
            leave_island(p, island, h);
        all_first = all_first && first_try;
    }
    p->stats.unconverged_steps += !all_first;
    link_sleepers(p);
    pinch_handed_disable(p);
    if (p->contacts.count > p->stats.points_high_water) p->stats.points_high_water = p->contacts.count;
    p->solved = true;
    p->solved_h = h;
    return PINCH_OK;
}

pinch_status pinch_ode_advance(pinch_ode *p, double h)
{
    if (!p || !(h > 0) || !isfinite(h) || !p->solved) return PINCH_INVALID_ARGUMENT;
    int stepped = p->settings.stepper == PINCH_ODE_QUICKSTEP ? dWorldQuickStep(p->world, h) : dWorldStep(p->world, h);
    for (int i = 0; i < p->drives.count; i++) { /* back to the motion its owner prescribed */
        pinch_drive *drive = &p->drives.items[i];
        if (pinch_key_map_get(&p->body_index, (uint64_t)(uintptr_t)drive->body) < 0) continue;
        const double *v = dBodyGetLinearVel(drive->body), s = drive->speed;
        dBodySetLinearVel(drive->body, v[0] - s * drive->axis[0], v[1] - s * drive->axis[1], v[2] - s * drive->axis[2]);
    }
    pinch_handed_enable(p);
    pinch_quiet_sleepers(p);
    read_left_contacts(p);
    pinch_measure_mismatch(p);
    pinch_carry_history(p, h);
    dJointGroupEmpty(p->left);
    p->pool.count = p->surfaces.count = 0;
    p->solved = false;
    p->step++;
    p->last_h = h;
    p->stats.steps++;
    return stepped ? PINCH_OK : PINCH_OUT_OF_MEMORY;
}

pinch_status pinch_ode_step(pinch_ode *p, double h)
{
    pinch_status status = pinch_ode_solve(p, h);
    return status == PINCH_OK ? pinch_ode_advance(p, h) : status;
}
