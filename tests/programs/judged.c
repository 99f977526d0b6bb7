/*
 * Runs a program of this folder under the drop-in layer, and looks once more at every answer that its solves have come
 * to: by core/verify, from the recorded data and outputs alone, and by the balance of momentum and the law of joint
 * rows as they are written out here. After the program's own line it prints a second one:
 *
 *     solves        solves that ended with an answer; those that did not are in `failed`, and give nothing to ODE unless
 *                   they were swept
 *     contacts      in them, and `rows` of joints
 *     contradicted  rows among these that others contradict: they miss more than 1e-9 of what they ask for, and say so
 *     unverified    answers that core/verify does not hold for such
 *     unbalanced    bodies whose change of momentum is not that of the forces on them
 *     bad_rows      rows that miss what they ask for though their force is free to correct it, or is out of its bounds
 *     pulling       contacts whose normal force is negative or no number
 *     mismatch      m/s: the largest by which ODE's step did not do what was solved
 *     left          contacts and joints that ODE solved
 */
#include <ode/ode.h>

#include <pinch/ode_dropin.h>

#include "support/arithmetic.h"
#include "verify/step_check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

int program_main(int argc, char **argv);

enum { MOST_BODIES = 512 };

static struct {
    long solves, failed, contacts, rows, contradicted;
    long unverified, unbalanced, bad_rows, pulling;
} sums;

/* Returns rhs - violation - j1 v1 - j2 v2 - cfm force of a row, and the sum of the sizes of its parts. */
static double missed(const pinch_problem *p, const pinch_joint_row *row, double *size)
{
    double left = row->rhs - row->violation - row->cfm * row->force;
    *size = fabs(row->rhs) + fabs(row->cfm * row->force);
    for (int side = 0; side < 2; side++) {
        int body = side ? row->body2 : row->body1;
        const double *j = side ? row->j2 : row->j1;
        for (int i = 0; i < 6 && body >= 0; i++) {
            double part = j[i] * p->bodies[body].velocity_end[i];
            left -= part;
            *size += fabs(part);
        }
    }
    return left;
}

/* A row may miss what it asks for only where its force is at the bound that it would have to leave. 1e-8 m/s or rad/s,
 * and of what its parts sum up to where that is more. Rounding of the forces is not allowed for, as it is in
 * core/verify, although rows that contradict each other have large ones that cancel. */
static bool row_holds(const pinch_problem *p, const pinch_joint_row *row)
{
    double size, left = missed(p, row, &size), most = 1e-8 * fmax(size, 1), beyond = 1e-9 * fmax(fabs(row->force), 1);
    if (!(row->force >= row->low - beyond && row->force <= row->high + beyond)) return false;
    return (left <= most || row->force >= row->high - beyond) && (left >= -most || row->force <= row->low + beyond);
}

/* Adds a wrench to what acts on a body, and its size to what rounding is measured by. */
static void add(double total[7], const double force[3], const double torque[3], double sign, double radius)
{
    double sum[2] = {0, 0};
    for (int i = 0; i < 3; i++) {
        total[i] += sign * force[i];
        total[3 + i] += sign * torque[i];
        sum[0] += force[i] * force[i];
        sum[1] += torque[i] * torque[i];
    }
    total[6] += sqrt(sum[0]) + sqrt(sum[1]) / radius;
}

static void add_contact(const pinch_problem *p, const pinch_contact *c, double (*total)[7])
{
    double t2[3], force[3], moment[3], torque[3], arm[3];
    cross(c->normal, c->tangent1, t2);
    bool rolls = c->model == PINCH_CONTACT_ROLLING, spins = rolls || c->model == PINCH_CONTACT_SOFT;
    for (int i = 0; i < 3; i++) {
        force[i] = c->force[0] * c->normal[i] + c->force[1] * c->tangent1[i] + c->force[2] * t2[i];
        moment[i] = spins ? c->force[3] * c->normal[i] : 0;
        if (rolls) moment[i] += c->rolling_moment[0] * c->tangent1[i] + c->rolling_moment[1] * t2[i];
    }
    for (int side = 0; side < 2; side++) {
        int body = side ? c->body2 : c->body1;
        if (body < 0) continue;
        for (int i = 0; i < 3; i++) arm[i] = c->position[i] - p->bodies[body].position[i];
        cross(arm, force, torque);
        for (int i = 0; i < 3; i++) torque[i] += moment[i];
        add(total[body], force, torque, side ? -1 : 1, p->bodies[body].radius);
    }
}

/* The forces must balance the change of momentum to 1e-8 of their sizes, those that cancel each other included. */
static bool balanced(const pinch_problem *p, const pinch_body *b, double total[7])
{
    double force[3], torque[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        force[i] = b->mass * (b->velocity_end[i] - b->velocity[i]) / p->step;
        for (int j = 0; j < 3; j++)
            torque[i] += b->inertia[3 * i + j] * (b->velocity_end[3 + j] - b->velocity[3 + j]) / p->step;
    }
    add(total, force, torque, -1, b->radius);
    return length(total) + length(total + 3) / b->radius <= 1e-8 * (total[6] + b->mass);
}

static void judge_balance(const pinch_problem *p)
{
    static double total[MOST_BODIES][7];
    memset(total, 0, sizeof total);
    for (int k = 0; k < p->contact_count; k++) add_contact(p, &p->contacts[k], total);
    for (int k = 0; k < p->row_count; k++) {
        const pinch_joint_row *row = &p->rows[k];
        for (int side = 0; side < 2; side++) {
            int body = side ? row->body2 : row->body1;
            const double *j = side ? row->j2 : row->j1;
            double force[3], torque[3];
            for (int i = 0; i < 3 && body >= 0; i++) force[i] = row->force * j[i], torque[i] = row->force * j[3 + i];
            if (body >= 0) add(total[body], force, torque, 1, p->bodies[body].radius);
        }
    }
    for (int b = 0; b < p->body_count; b++) sums.unbalanced += !balanced(p, &p->bodies[b], total[b]);
}

static void judge(void *context, const pinch_ode_recording *r)
{
    static double scratch[11 * MOST_BODIES];
    const pinch_problem *p = r->ended;
    pinch_step_result result = *r->result;
    (void)context;
    if (r->result->solve.status != PINCH_SOLVE_CONVERGED || p->body_count > MOST_BODIES) {
        sums.failed++;
        return;
    }
    sums.solves++;
    sums.contacts += p->contact_count;
    sums.rows += p->row_count;
    sums.unverified += !pinch_step_verify(p, r->settings->tolerance, scratch, &result);
    judge_balance(p);
    for (int k = 0; k < p->contact_count; k++) sums.pulling += !(p->contacts[k].force[0] >= 0);
    for (int k = 0; k < p->row_count; k++) {
        sums.contradicted += fabs(p->rows[k].violation) > 1e-9;
        sums.bad_rows += !row_holds(p, &p->rows[k]);
    }
}

int main(int argc, char **argv)
{
    pinch_ode_settings settings = pinch_dropin_settings();
    settings.recorder = judge;
    settings.record_all = true;
    if (pinch_dropin_set_settings(&settings) != PINCH_OK) return 3;
    int status = program_main(argc, argv);
    pinch_dropin_stats stats = pinch_dropin_statistics();
    printf("{\"solves\": %ld, \"failed\": %ld, \"contacts\": %ld, \"rows\": %ld, \"contradicted\": %ld", sums.solves,
           sums.failed, sums.contacts, sums.rows, sums.contradicted);
    printf(", \"unverified\": %ld, \"unbalanced\": %ld, \"bad_rows\": %ld, \"pulling\": %ld", sums.unverified,
           sums.unbalanced, sums.bad_rows, sums.pulling);
    printf(", \"mismatch\": %.3g, \"left\": %ld}\n", stats.ode.step_mismatch,
           stats.ode.contacts_left + stats.ode.joints_left);
    return status;
}
