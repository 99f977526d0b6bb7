/* The bodies of an island: as the core wants them, with masses and the velocities that all but contacts and joints lead
 * to; and what they are given. */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static void world_inertia(const dMass *mass, const double *R, double *inertia)
{
    double left[9]; /* R I */
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            left[3 * i + j] = R[4 * i] * mass->I[j] + R[4 * i + 1] * mass->I[4 + j] + R[4 * i + 2] * mass->I[8 + j];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j <= i; j++) {
            double sum = left[3 * i] * R[4 * j] + left[3 * i + 1] * R[4 * j + 1] + left[3 * i + 2] * R[4 * j + 2];
            inertia[3 * i + j] = inertia[3 * j + i] = sum;
        }
}

/* Solves the 3 x 3 system by Cramer's rule: well conditioned here, an inertia plus a small skew part. */
static void solve3(const double *a, const double *b, double *x)
{
    double c0[3] = {a[0], a[3], a[6]}, c1[3] = {a[1], a[4], a[7]}, c2[3] = {a[2], a[5], a[8]}, t[3];
    pinch_v3_cross(c1, c2, t);
    double determinant = pinch_v3_dot(c0, t);
    x[0] = pinch_v3_dot(b, t) / determinant;
    pinch_v3_cross(c2, c0, t);
    x[1] = pinch_v3_dot(b, t) / determinant;
    pinch_v3_cross(c0, c1, t);
    x[2] = pinch_v3_dot(b, t) / determinant;
}

/*
 * ODE's gyroscopic torque, implicit in the angular momentum L = I w:   tau = (I y - L)/h   with   (I - h [L]x) y = L
 * (Lacoursiere, "Stabilizing gyroscopic forces in rigid multibody simulations", 2006).
 */
static void gyroscopic_torque(const double *inertia, const double *w, double h, double *torque)
{
    double L[3], matrix[9], y[3];
    for (int i = 0; i < 3; i++) L[i] = pinch_v3_dot(inertia + 3 * i, w);
    if (L[0] == 0 && L[1] == 0 && L[2] == 0) return;
    memcpy(matrix, inertia, sizeof matrix);
    matrix[1] += h * L[2];
    matrix[2] -= h * L[1];
    matrix[3] -= h * L[2];
    matrix[5] += h * L[0];
    matrix[6] += h * L[1];
    matrix[7] -= h * L[0];
    solve3(matrix, L, y);
    for (int i = 0; i < 3; i++) torque[i] += (pinch_v3_dot(inertia + 3 * i, y) - L[i]) / h;
}

/* One core body: mass and inertia, and the velocity that gravity, applied forces and gyroscopic torque lead to. */
static void fill_body(pinch_ode *p, const pinch_step_body *from, double h, pinch_body *b)
{
    memset(b, 0, sizeof *b);
    pinch_v3_copy(b->position, dBodyGetPosition(from->body));
    b->radius = 1;
    if (from->drive >= 0) {
        const pinch_drive *drive = &p->drives.items[from->drive];
        pinch_v3_copy(b->drive_axis, drive->axis);
        b->drive_force = drive->force;
        pinch_v3_add_scaled(b->velocity, drive->speed, drive->axis);
        return;
    }
    dMass mass;
    dBodyGetMass(from->body, &mass);
    b->mass = mass.mass;
    world_inertia(&mass, dBodyGetRotation(from->body), b->inertia);
    /* the radius of the homogeneous ball with the same trace of inertia */
    b->radius = sqrt(2.5 * (b->inertia[0] + b->inertia[4] + b->inertia[8]) / (3 * mass.mass));

    pinch_v3_copy(b->velocity, dBodyGetLinearVel(from->body));
    pinch_v3_copy(b->velocity + 3, dBodyGetAngularVel(from->body));
    pinch_v3_copy(b->external, dBodyGetForce(from->body));
    pinch_v3_copy(b->external + 3, dBodyGetTorque(from->body));
    if (dBodyGetGravityMode(from->body)) {
        dVector3 gravity;
        dWorldGetGravity(p->world, gravity);
        pinch_v3_add_scaled(b->external, mass.mass, gravity);
    }
    if (dBodyGetGyroscopicMode(from->body)) gyroscopic_torque(b->inertia, b->velocity + 3, h, b->external + 3);
}

static void apply_external(pinch_body *b, double h)
{
    double spin[3];
    if (b->mass == 0) return;
    pinch_v3_add_scaled(b->velocity, h / b->mass, b->external);
    solve3(b->inertia, b->external + 3, spin);
    pinch_v3_add_scaled(b->velocity + 3, h, spin);
}

void pinch_fill_bodies(pinch_ode *p, const pinch_island *island, double h, pinch_body *bodies)
{
    const int *body_of = p->body_of.items + island->first_body;
    for (int k = 0; k < island->body_count; k++) fill_body(p, &p->bodies.items[body_of[k]], h, &bodies[k]);
}

void pinch_apply_external(pinch_body *bodies, int count, double h)
{
    for (int k = 0; k < count; k++) apply_external(&bodies[k], h);
}

void pinch_give_forces(pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->body_count; k++) {
        pinch_step_body *b = pinch_island_body(p, island, k);
        if (b->drive < 0) {
            double f[6];
            memcpy(f, b->wrench, sizeof f);
            pinch_v3_copy(b->wrench, dBodyGetForce(b->body));
            pinch_v3_copy(b->wrench + 3, dBodyGetTorque(b->body));
            dBodyAddForce(b->body, f[0], f[1], f[2]);
            dBodyAddTorque(b->body, f[3], f[4], f[5]);
            continue;
        }
        pinch_drive *drive = &p->drives.items[b->drive];
        drive->speed = pinch_v3_dot(b->velocity, drive->axis);
        const double *v = dBodyGetLinearVel(b->body);
        dBodySetLinearVel(b->body, v[0] + drive->speed * drive->axis[0], v[1] + drive->speed * drive->axis[1],
                          v[2] + drive->speed * drive->axis[2]);
    }
}

static void stop_drive(const pinch_drive *drive)
{
    const double *v = dBodyGetLinearVel(drive->body), s = drive->speed;
    dBodySetLinearVel(drive->body, v[0] - s * drive->axis[0], v[1] - s * drive->axis[1], v[2] - s * drive->axis[2]);
}

void pinch_restore_forces(const pinch_step_body *b)
{
    dBodySetForce(b->body, b->wrench[0], b->wrench[1], b->wrench[2]);
    dBodySetTorque(b->body, b->wrench[3], b->wrench[4], b->wrench[5]);
}

void pinch_take_back_forces(pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->body_count && island->solved; k++) {
        const pinch_step_body *b = pinch_island_body(p, island, k);
        if (b->drive >= 0)
            stop_drive(&p->drives.items[b->drive]);
        else
            pinch_restore_forces(b);
    }
}

void pinch_stop_drives(pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->body_count && island->solved && p->drives.count > 0; k++) {
        const pinch_step_body *b = pinch_island_body(p, island, k);
        if (b->drive >= 0) stop_drive(&p->drives.items[b->drive]);
    }
}
