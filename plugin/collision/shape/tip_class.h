#ifndef PINCH_FINGERTIP_TIP_CLASS_H
#define PINCH_FINGERTIP_TIP_CLASS_H

#include "tip_data.h"

/* What dCreateGeomClass returned; -1: none. */
void pinch_set_tip_class(int class);
/* Of a geom of the class. */
pinch_tip_data *pinch_tip_data_of(dGeomID geom);

#endif
