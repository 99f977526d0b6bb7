/* The surface parameters of an ODE contact as the material of a contact point. */
#ifndef PINCH_PLUGIN_SURFACE_H
#define PINCH_PLUGIN_SURFACE_H

#include <ode/ode.h>
#include <pinch/problem.h>

/* In the pair's canonical order. NaN: the world's value, which may change from step to step. */
typedef struct pinch_surface {
    double friction[5];  /* along tangent1, tangent2, about the normal, tangent1, tangent2; 0 for none */
    bool coefficient[5]; /* of the normal force (m where rotational); otherwise a limit in N, N m */
    bool rolls;
    double erp, cfm;
    double bounce, bounce_velocity; /* bounce 0: none */
    double motion[3];               /* m/s, normal, tangent1, tangent2: the relative velocity that is aimed at */
    double slip[2];                 /* (m/s)/N, 0 for none */
} pinch_surface;

/* swapped: the pair's first geom is the contact's second. False: parameters that Pinch has no law for. */
bool pinch_surface_of(const dContact *contact, bool swapped, pinch_surface *surface);

/* The first friction direction, unit, world. False where the program gave none that could be one: it is then ODE's own
 * for the normal, pinch_surface_tangent. */
bool pinch_surface_direction(const dContact *contact, double *tangent);
void pinch_surface_tangent(const double *normal, double *tangent);

/*
 * What of `surface` a point's contact law takes, given the contact's geometry (position, normal, depth), the first
 * friction direction and a step of h: frame, stiffness, damping, friction, target velocities. mobility: sum of the
 * bodies' inverse masses, 1/kg; size: of the smaller geom, m; approach: velocity along the normal now, m/s, negative
 * when approaching. pressed: it had a normal force in the last step.
 */
void pinch_surface_apply(const pinch_surface *surface, const double *tangent1, dWorldID world, double h,
                         double tangential_ratio, double mobility, double size, double approach, bool pressed,
                         pinch_contact *contact);

#endif
