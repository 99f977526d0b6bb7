#ifndef PINCH_COLLISION_TIP_DATA_H
#define PINCH_COLLISION_TIP_DATA_H

#include "convex_shape.h"

/* A tip's data, owned by its geom. */
typedef struct pinch_tip_data {
    pinch_tip tip;
    pinch_shape *shapes;
    pinch_hull *hulls;
    pinch_convex *pieces;
} pinch_tip_data;

/* NULL without memory; the shape must be legal. */
bool pinch_tip_legal(const pinch_tip *tip);
pinch_tip_data *pinch_tip_data_create(const pinch_tip *tip);
void pinch_tip_data_free(pinch_tip_data *data);

/* What dCreateGeomClass returned; -1: none. */
void pinch_set_tip_class(int class);
/* Of a geom of the class. */
pinch_tip_data *pinch_tip_data_of(dGeomID geom);

/* NULL: the geom is not known. */
const pinch_shape *pinch_known_convex(dGeomID geom);
void pinch_forget_convexes(void);

#endif
