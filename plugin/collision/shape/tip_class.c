#include "tip_class.h"

#include <string.h>

/* ODE's geom classes belong to the process. */
static int tip_class = -1;

void pinch_set_tip_class(int class)
{
    tip_class = class;
}

int pinch_tip_class(void)
{
    return tip_class;
}

pinch_tip_data *pinch_tip_data_of(dGeomID geom)
{
    pinch_tip_data *data;
    memcpy(&data, dGeomGetClassData(geom), sizeof data);
    return data;
}

const pinch_tip *pinch_tip_of(dGeomID geom)
{
    return geom && tip_class >= 0 && dGeomGetClass(geom) == tip_class ? &pinch_tip_data_of(geom)->tip : NULL;
}
