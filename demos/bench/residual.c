/* How far the forces of a step are from the contact law, measured on the bodies after the step. */
#include "world.h"

#include <math.h>

/* Adds the velocity of the point of a body that was at `position` when the step began. ODE moves bodies by their new
 * velocities. */
static void add_velocity(dBodyID body, double h, const double *position, double sign, double velocity[3])
{
    if (!body) return;
    const double *v = dBodyGetLinearVel(body), *omega = dBodyGetAngularVel(body), *x = dBodyGetPosition(body);
    double arm[3];
    for (int i = 0; i < 3; i++) arm[i] = position[i] - (x[i] - h * v[i]);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        velocity[i] += sign * (v[i] + omega[j] * arm[k] - omega[k] * arm[j]);
    }
}

typedef struct point {
    const double *position, *normal; /* into body 1 */
    dBodyID body[2];
    double depth;
    double erp, cfm;      /* of ODE's soft constraint */
    double normal_force;  /* N */
    double tangential[3]; /* N */
} point;

/* n' M^-1 n in 1/kg says how easily the contact's normal velocity changes. The bodies count as spheres of their mean
 * inertia. */
static double mobility(const bench_world *w, const point *p)
{
    double sum = 0;
    for (int side = 0; side < 2; side++) {
        dMass mass;
        if (!p->body[side] || dBodyIsKinematic(p->body[side])) continue;
        const double *v = dBodyGetLinearVel(p->body[side]), *x = dBodyGetPosition(p->body[side]);
        double arm[3], lever = 0;
        dBodyGetMass(p->body[side], &mass);
        for (int i = 0; i < 3; i++) arm[i] = p->position[i] - (x[i] - w->step * v[i]);
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            lever = hypot(lever, arm[j] * p->normal[k] - arm[k] * p->normal[j]);
        }
        sum += 1 / mass.mass + 3 * lever * lever / (mass.I[0] + mass.I[5] + mass.I[10]);
    }
    return sum;
}

static double residual_of(const bench_world *w, const point *p)
{
    double velocity[3] = {0, 0, 0}, opening = 0, friction = 0;
    for (int side = 0; side < 2; side++) add_velocity(p->body[side], w->step, p->position, side ? -1 : 1, velocity);
    for (int i = 0; i < 3; i++) opening += velocity[i] * p->normal[i];
    for (int i = 0; i < 3; i++) friction = hypot(friction, p->tangential[i]);
    double law = fmax(0, (p->erp * p->depth / w->step - opening) / p->cfm);
    double mends = p->cfm / (p->cfm + w->step * mobility(w, p));
    return fmax(mends * fabs(p->normal_force - law), friction - w->material.friction * p->normal_force);
}

static double pinch_residual(const bench_world *w)
{
    const pinch_ode_contact *list;
    int count;
    double worst = 0;
    if (pinch_ode_contacts(w->pinch, &list, &count) != PINCH_OK) return NAN;
    for (int i = 0; i < count; i++) {
        const pinch_ode_contact *c = &list[i];
        point p = {c->position, c->normal, {c->body1, c->body2}, c->depth, 0, 0, c->normal_force, {0, 0, 0}};
        bool tip = dGeomGetData(c->geom1) || dGeomGetData(c->geom2);
        double share = c->stiffness[0] / w->material.stiffness[0];
        double g = share * (w->step * w->material.stiffness[0] + w->material.damping[0]);
        p.erp = tip ? w->step * c->stiffness[0] / g : dWorldGetERP(w->ode);
        p.cfm = tip ? 1 / g : dWorldGetCFM(w->ode);
        for (int k = 0; k < 3; k++) p.tangential[k] = c->tangential[k];
        worst = fmax(worst, residual_of(w, &p));
    }
    return worst;
}

static double ode_residual(const bench_world *w)
{
    double worst = 0;
    for (int i = 0; i < w->contact_count; i++) {
        const bench_contact *c = &w->contacts[i];
        const dContactGeom *g = &c->contact.geom;
        bool tip = c->contact.surface.mode & dContactSoftCFM;
        /* Where the contact is attached as (0, body), ODE writes the force on the body into f1. */
        double sign = c->body[0] ? 1 : -1;
        point p = {g->pos, g->normal, {c->body[0], c->body[1]}, g->depth, 0, 0, 0, {0, 0, 0}};
        p.erp = tip ? c->contact.surface.soft_erp : dWorldGetERP(w->ode);
        p.cfm = tip ? c->contact.surface.soft_cfm : dWorldGetCFM(w->ode);
        for (int k = 0; k < 3; k++) p.normal_force += sign * c->feedback.f1[k] * g->normal[k];
        for (int k = 0; k < 3; k++) p.tangential[k] = sign * c->feedback.f1[k] - p.normal_force * g->normal[k];
        worst = fmax(worst, residual_of(w, &p));
    }
    return worst;
}

double bench_residual(const bench_world *w)
{
    return w->pinch ? pinch_residual(w) : ode_residual(w);
}
