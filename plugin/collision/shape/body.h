/* A geom as this geometry sees it: cores with a pose. */
#ifndef PINCH_FINGERTIP_BODY_H
#define PINCH_FINGERTIP_BODY_H

#include "shape_pair.h"

typedef struct pinch_tip_body {
    dGeomID geom; /* named in contacts: a transform that asks for it stands for what it holds */
    const pinch_core *cores;
    int core_count;
    pinch_core own; /* of ODE's geoms, made on the spot */
    double position[3], R[9];
} pinch_tip_body;

/* False where this geometry does not know the geom's class. `body` must not be copied. */
bool pinch_body_of_geom(dGeomID geom, pinch_tip_body *body);

/* Sets the pair up with the pose of b in a's axes. */
void pinch_pair_of(const pinch_tip_body *a, const pinch_core *core_a, const pinch_tip_body *b, const pinch_core *core_b,
                   pinch_core_pair *pair);

#endif
