#ifndef PINCH_STATICS_ASSEMBLY_H
#define PINCH_STATICS_ASSEMBLY_H

#include "statics/model.h"

/* Where the unknowns of the mixed problem are: r_n, lambda, s, u in this order. */
typedef struct pinch_static_layout {
    int normals, facets, limits, freedoms;
    int size; /* of the mixed problem */
} pinch_static_layout;

pinch_static_layout pinch_static_lay_out(const pinch_static_model *model);

/* Outward normal of facet k of a contact's polytope in (t1, t2, tau), and its distance per newton of normal force. */
int pinch_static_facet_count(const pinch_static_model *model, const pinch_static_contact *contact);
double pinch_static_facet(const pinch_static_model *model, const pinch_static_contact *contact, int k,
                          double normal[3]);

/*
 * The mixed problem: m[size^2], q[size], free[size]. `spring` (freedoms^2, may be NULL) is added to W_t K_t W_t^T: one
 * more spring that holds the object at u = 0, M/h^2 of a step.
 */
void pinch_static_assemble(const pinch_static_model *model, const pinch_static_layout *layout, const double *spring,
                           double *m, double *q, bool *free);

/*
 * The other forms from the mixed one. condense: eliminates u in place of (mixed, mixed_q) into out (size - freedoms);
 * scratch: freedoms * (size + 1). False where W_t K_t W_t^T is singular to working precision. `back` receives u as an
 * affine function of the other unknowns: freedoms x (size - freedoms + 1), constant last.
 */
bool pinch_static_condense(const pinch_static_layout *layout, const double *mixed, const double *mixed_q, double *m,
                           double *q, double *back);
void pinch_static_split(const pinch_static_layout *layout, const double *mixed, const double *mixed_q, double *m,
                        double *q);

/*
 * Forces and slips from the mixed problem's z: r[4] and slip[3] of contact `index`, model units.
 */
void pinch_static_read(const pinch_static_model *model, const pinch_static_layout *layout, const double *z, int index,
                       double r[4], double slip[3]);

#endif
