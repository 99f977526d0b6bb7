#ifndef PINCH_FINGERTIP_TIP_DATA_H
#define PINCH_FINGERTIP_TIP_DATA_H

#include "convex_shape.h"

/* A tip's data, owned by its geom. */
typedef struct pinch_tip_data {
    pinch_tip tip;
    pinch_core *cores;
    pinch_core_hull *hulls;
    pinch_convex *pieces;
} pinch_tip_data;

/* NULL without memory; the shape must be legal. */
bool pinch_tip_legal(const pinch_tip *tip);
pinch_tip_data *pinch_tip_data_create(const pinch_tip *tip);
void pinch_tip_data_free(pinch_tip_data *data);
#endif
