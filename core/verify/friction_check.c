/* The laws of rigid contact with friction as one projection: de Saxce and Feng, "The bipotential method", 1998. */
#include "verify/step_check.h"

#include <math.h>
#include <string.h>

/* Projects x = (normal, tangents) onto the cone |x_t| <= mu x_n. */
static void project(double mu, double x[3])
{
    double tangential = hypot(x[1], x[2]);
    if (tangential <= mu * x[0]) return;
    if (mu * tangential <= -x[0]) {
        memset(x, 0, 3 * sizeof *x);
        return;
    }
    /* onto the ray along (1, mu) in the plane of normal and tangent */
    double along = (x[0] + mu * tangential) / (1 + mu * mu);
    x[1] *= along * mu / tangential;
    x[2] *= along * mu / tangential;
    x[0] = along;
}

static void write_velocities(pinch_friction_problem *p, const int *first, double *x)
{
    memset(x, 0, sizeof *x * (size_t)first[p->body_count]);
    for (int c = 0; c < p->contact_count; c++) {
        const pinch_friction_contact *k = &p->contacts[c];
        for (int s = 0; s < 2; s++) {
            int size = k->body[s] < 0 ? 0 : p->freedoms[k->body[s]];
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < size; j++) x[first[k->body[s]] + j] += k->g[s][i * size + j] * k->impulse[i];
        }
    }
    for (int c = 0; c < p->contact_count; c++) {
        pinch_friction_contact *k = &p->contacts[c];
        memcpy(k->velocity, k->free, sizeof k->velocity);
        for (int s = 0; s < 2; s++) {
            int size = k->body[s] < 0 ? 0 : p->freedoms[k->body[s]];
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < size; j++) k->velocity[i] += k->g[s][i * size + j] * x[first[k->body[s]] + j];
        }
    }
}

double pinch_friction_missed(const pinch_friction_contact *contacts, int count)
{
    double missed = 0, free = 0;
    for (int c = 0; c < count; c++) {
        const pinch_friction_contact *k = &contacts[c];
        const double *u = k->velocity, *r = k->impulse;
        double z[3] = {r[0] - u[0] - k->friction * hypot(u[1], u[2]), r[1] - u[1], r[2] - u[2]};
        project(k->friction, z);
        for (int i = 0; i < 3; i++) {
            missed += (r[i] - z[i]) * (r[i] - z[i]);
            free += k->free[i] * k->free[i];
        }
    }
    double error = free > 0 ? sqrt(missed) / sqrt(free) : sqrt(missed);
    return isfinite(error) ? error : INFINITY;
}

double pinch_friction_error(pinch_friction_problem *p, const int *first, double *x)
{
    write_velocities(p, first, x);
    return pinch_friction_missed(p->contacts, p->contact_count);
}
