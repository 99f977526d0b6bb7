#ifndef PINCH_STATICS_MODEL_H
#define PINCH_STATICS_MODEL_H

#include "support/double_double.h"

#include <pinch/statics.h>

/*
 * The grasp as the solvers see it is non-dimensional (forces over `force`, stiffnesses over `stiffness`, lengths over
 * `length`, so displacements over force/stiffness), reduced to the freedoms the object has (x, y, z and rotations; x, y
 * and the rotation about z in the plane), and with factors that the load path and the searches for limits vary.
 */
typedef struct pinch_static_contact {
    int rows;        /* 1, 3 or 4: normal, tangents, torsion */
    double w[4][6];  /* columns of the grasp matrix: W_n, W_t1, W_t2, W_tau */
    double k[4];     /* kn, kt, kt, ktau */
    double axis[3];  /* semi-axes of the limit surface per unit of r_n: mu, mu, mu_tau */
    bool controlled; /* r_n = normal_force, at most max_force */
    double normal_force;
    double closing;   /* d */
    double max_force; /* INFINITY for none */
    double rest[3];   /* slip so far: the tangential springs pull towards it */
    double saved[3];  /* rest as it was when the load step began */
    bool open;        /* was it out of contact at the last commit? */
    bool coarse_open;
    double coarse[3]; /* rest after the load step taken at once, to compare with two halves */
    /* at the start, then in the middle of the load step: has it stuck so far, how far is it open (as a force), friction
     */
    bool stuck;
    double gap, onset[3];
} pinch_static_contact;

typedef struct pinch_static_model {
    int count, freedoms;
    pinch_static_contact *contacts;
    double wrench[6];
    int faces;      /* 0: the exact limit surface; otherwise the polytope's facets */
    double apothem; /* of the polytope's polygon per unit of mu r_n */
    double torsion; /* of its height per unit of mu_tau r_n */
    double closing_factor, wrench_factor, friction_factor;
    double force, stiffness, length; /* units, N, N/m, m */
    double origin[3];                /* where moments and displacements are taken, relative to the centre of mass (m) */
    /* the flow's term: alpha reference (u - anchor) is added to the equilibrium; alpha = 0: none. `inertial`: the unit
     * matrix instead of the reference, a body whose mass is spread as far out as its radius */
    double alpha, reference[36], anchor[6];
    bool inertial;
    bool has_reference; /* built when first needed */
    long work_left;     /* iterations of Newton's and Kaczmarz' method before everything is given up as undecided */
    /* what the Newton solver works on */
    double tangent[36], lu[36], v[36], scratch[6];
    int pivot[6];
    pinch_row_segment segments[6];
} pinch_static_model;

/* contacts: finger_count of them. `raw`: all units 1. */
void pinch_static_model_build(pinch_static_model *model, pinch_static_contact *contacts, const pinch_grasp *grasp,
                              const pinch_statics_settings *settings, bool raw);

/* Fills in the reference stiffness, once. */
void pinch_static_build_reference(pinch_static_model *model);

/* w = W^T u of one contact, all four rows */
void pinch_static_displacement(const pinch_static_model *model, const pinch_static_contact *contact, const double *u,
                               double w[4]);

/* Writes the trial forces k (rest - w) of one contact. In twice the precision w keeps the digits that the difference
 * cancels. */
void pinch_static_trial(const pinch_static_model *model, const pinch_static_contact *contact, const double *u,
                        double s[4]);
void pinch_static_trial_extended(const pinch_static_model *model, const pinch_static_contact *contact,
                                 const pinch_double_double *u, double s[4]);

/* The normal force of a contact under force control. On the way of the closing it grows until the tip yields. */
double pinch_static_controlled_force(const pinch_static_model *model, const pinch_static_contact *contact);

/* Writes the contact forces r[4] at the trial s[4] and, unless NULL, d[16] = -dr/dw. */
pinch_contact_state pinch_static_law(const pinch_static_model *model, const pinch_static_contact *contact,
                                     const double s[4], double r[4], double d[16]);

/* R = sum W r + wrench, without the flow's term. */
void pinch_static_equilibrium(const pinch_static_model *model, const double *u, double *equilibrium);

/* F(u) = R(u) - alpha reference (u - anchor) as a non-smooth system of `freedoms` unknowns; borrows the model. */
pinch_system pinch_static_system(pinch_static_model *model);

/* Steps of pinch_static_refine that an answer gets. */
enum { PINCH_STATIC_REFINEMENTS = 4 };

/* Takes up to `steps` Newton steps on R with u and the springs' elongations in twice the precision. Returns ||R||. */
double pinch_static_refine(pinch_static_model *model, pinch_double_double *u, int steps);

/* Takes the slip of the state at u into the contacts' rest: the elastic state that the next load step starts from. */
void pinch_static_commit(pinch_static_model *model, const double *u);

#endif
