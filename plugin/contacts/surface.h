/* The surface parameters of an ODE contact, and the contact law that they stand for. */
#ifndef PINCH_CONTACTS_SURFACE_H
#define PINCH_CONTACTS_SURFACE_H

#include "step_context.h"

/* In the order of the pair's geoms. NaN stands for the world's value, which may change from step to step. */
typedef struct pinch_surface {
    double friction[5];  /* along tangent1, tangent2, about the normal, tangent1, tangent2; 0 for none */
    bool coefficient[5]; /* of the normal force (m where rotational); otherwise a limit in N, N m */
    bool rolls;
    double erp, cfm;
    double bounce, bounce_velocity; /* bounce 0: none */
    double motion[3];               /* m/s, normal, tangent1, tangent2: the relative velocity that is aimed at */
    double slip[2];                 /* (m/s)/N, 0 for none */
} pinch_surface;

/* What the law of a contact depends on besides its surface and its geometry. */
typedef struct pinch_surface_conditions {
    const double *tangent1; /* the first friction direction, unit, world */
    double mobility;        /* sum of the bodies' inverse masses, 1/kg */
    double size;            /* of the smaller geom, m */
    double stands_for;      /* how many such contacts the contact stands for, */
    double part;            /* and this over the largest of its pair; 0: the pair has few contacts */
    double bears;           /* N, each that is stood for, in the mean, in the last step */
    double approach;        /* velocity along the normal now, m/s, negative when approaching */
    double recent_approach; /* by how much bodies have come in of late by their own motion, m; out: with this step */
    double approach_depth;  /* how deep they have come in by it at a time, m; out: with this step */
    double paced_step;      /* s, the longest step of late */
    double pose_speed; /* at which the program moves the bodies into each other by their poses, m/s, >= 0; out: 0 where
                        * the overlap that this makes is parted at its own pace soon enough */
    double force;      /* of the contact along the normal in the last step, N */
    double gives_way;  /* how fast its compliance let it come in under that force, m/s */
    double yields;     /* out: the inverse of the stiffness that the surface prescribes, m/N */
    double eased;      /* out: by how much more slowly than at its ERP the contact parts, m/s */
} pinch_surface_conditions;

/* Reads a contact's surface parameters. swapped: the pair's first geom is the contact's second. Returns false for
 * parameters that Pinch has no law for. */
bool pinch_surface_of(const dContact *contact, bool swapped, pinch_surface *surface);

/* Do two contacts have the same surface parameters? Those that the mode does not name, and the gaps between them, have
 * whatever was in memory, and are not read. */
bool pinch_surface_is_given_again(const dSurfaceParameters *a, const dSurfaceParameters *b);

/* Reads the first friction direction, unit, world. Returns false where the program gave none that could be one: it is
 * then ODE's own for the normal, pinch_surface_tangent. */
bool pinch_surface_direction(const dContact *contact, double *tangent);
void pinch_surface_tangent(const double *normal, double *tangent);

/* Returns the part of an overlap that ODE takes back in a step. */
double pinch_surface_erp(const pinch_step_context *context, const pinch_surface *surface);

/* Fills in frame, stiffness, damping, friction and target velocities of a contact whose position, normal and depth are
 * known. Returns how much of the target velocity along the normal is a bounce (m/s). */
double pinch_surface_apply(const pinch_step_context *context, const pinch_surface *surface,
                           pinch_surface_conditions *conditions, pinch_contact *contact);

/* Tells whether friction has a limit that is a force or a moment, whatever the normal force. */
bool pinch_surface_has_forces(const pinch_surface *surface);

/* Limits friction that the surface leaves without a limit, where bodies are in each other. size: of the smaller geom, m
 */
void pinch_surface_limit_friction(const pinch_surface *surface, double size, pinch_contact *contact);

#endif
