/* The energy of a body with inertia, and what a step of it loses. */
#include "world.h"

#include "common/vector.h"

#include <string.h>

void body_world_inertia(dBodyID body, double inertia[9])
{
    dMass mass;
    dMatrix3 turned, I;
    dBodyGetMass(body, &mass);
    dMultiply2_333(turned, mass.I, dBodyGetRotation(body));
    dMultiply0_333(I, dBodyGetRotation(body), turned);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) inertia[3 * i + j] = I[4 * i + j];
}

/* a . I b */
static double product(const double inertia[9], const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) sum += a[i] * inertia[3 * i + j] * b[j];
    return sum;
}

double body_kinetic_energy(dBodyID body)
{
    dMass mass;
    double inertia[9];
    dBodyGetMass(body, &mass);
    body_world_inertia(body, inertia);
    const double *v = dBodyGetLinearVel(body), *w = dBodyGetAngularVel(body);
    return 0.5 * (mass.mass * dCalcVectorDot3(v, v) + product(inertia, w, w));
}

void energy_body_begin(energy_body *b, bool first)
{
    memcpy(b->velocity, dBodyGetLinearVel(b->body), 3 * sizeof(double));
    memcpy(b->velocity + 3, dBodyGetAngularVel(b->body), 3 * sizeof(double));
    body_world_inertia(b->body, b->inertia);
    b->kinetic = body_kinetic_energy(b->body);
    if (first) b->kinetic_start = b->kinetic;
}

/* The impulse of ODE's gyroscopic torque in a step of length h: I y - L with (I - h [L]x) y = L and L = I w. */
static void gyroscopic_impulse(const double inertia[9], const double *w, double h, double impulse[3])
{
    double L[3], a[3][4];
    for (int i = 0; i < 3; i++) L[i] = inertia[3 * i] * w[0] + inertia[3 * i + 1] * w[1] + inertia[3 * i + 2] * w[2];
    const double skew[3][3] = {{0, -L[2], L[1]}, {L[2], 0, -L[0]}, {-L[1], L[0], 0}};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) a[i][j] = inertia[3 * i + j] - h * skew[i][j];
        a[i][3] = L[i];
    }
    for (int k = 0; k < 3; k++) /* Gauss-Jordan without pivoting: the matrix is nearly an inertia */
        for (int i = 0; i < 3; i++) {
            if (i == k) continue;
            double factor = a[i][k] / a[k][k];
            for (int j = k; j < 4; j++) a[i][j] -= factor * a[k][j];
        }
    for (int i = 0; i < 3; i++) {
        impulse[i] = -L[i];
        for (int j = 0; j < 3; j++) impulse[i] += inertia[3 * i + j] * a[j][3] / a[j][j];
    }
}

/* With M (v+ - v) = h f, the work of the forces along the step's motion is h f.v+ = change of 1/2 v.M v + 1/2 dv.M dv.
 * The second term is lost to the time step. So is the difference between what the rotation of the inertia and the
 * gyroscopic torque do to the kinetic energy. */
double energy_body_integrator(const energy_body *b, double h)
{
    dMass mass;
    double inertia[9], change[6], impulse[3];
    dBodyGetMass(b->body, &mass);
    body_world_inertia(b->body, inertia);
    const double *v = dBodyGetLinearVel(b->body), *w = dBodyGetAngularVel(b->body);
    for (int i = 0; i < 3; i++) {
        change[i] = v[i] - b->velocity[i];
        change[3 + i] = w[i] - b->velocity[3 + i];
    }
    gyroscopic_impulse(b->inertia, b->velocity + 3, h, impulse);
    double turned = 0.5 * (product(inertia, w, w) - product(b->inertia, w, w));
    return 0.5 * (mass.mass * dCalcVectorDot3(change, change) + product(b->inertia, change + 3, change + 3)) -
           dCalcVectorDot3(impulse, w) - turned;
}

/* Adds `work` to a line of the ledger, and its size to the measure. */
void ledger_add(energy_ledger *l, double *line, double work)
{
    *line += work;
    l->work_size += fabs(work);
}
