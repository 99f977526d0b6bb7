#ifndef PINCH_COLLISION_TIP_DATA_H
#define PINCH_COLLISION_TIP_DATA_H

#include "convex_shape.h"

/* The data of a tip. Its geom owns them. */
typedef struct pinch_tip_data {
    pinch_tip tip;
    pinch_shape *shapes;
    pinch_hull *hulls;
    pinch_convex *pieces;
} pinch_tip_data;

/* The tip must be legal. Returns NULL when memory runs out. */
bool pinch_tip_legal(const pinch_tip *tip);
pinch_tip_data *pinch_tip_data_create(const pinch_tip *tip);
void pinch_tip_data_free(pinch_tip_data *data);

/* The number that dCreateGeomClass returned, or -1 for none. */
void pinch_set_tip_class(int class);
/* Returns the data of a geom of the class. */
pinch_tip_data *pinch_tip_data_of(dGeomID geom);

/* Returns the shape of one of ODE's convex geoms, or NULL if it has not been made known. */
const pinch_shape *pinch_known_convex(dGeomID geom);
void pinch_forget_convexes(void);

#endif
