/* Boxes that ODE's collider loses by rounding have their contacts under the layer, too. */
#define PINCH_DROPIN_NO_MACROS

#include "dropin/state.h"

#include <pinch/fingertip.h>

#include <stdatomic.h>

/* A program that has a collider of its own for boxes, as one that lets some of them through, gets what that returns. */
static atomic_bool boxes_are_the_programs;

void pinch_layer_set_collider_override(int class1, int class2, dColliderFn *collider)
{
    if (class1 == dBoxClass && class2 == dBoxClass) atomic_store(&boxes_are_the_programs, true);
    pinch_layer_own()->ode_set_collider_override(class1, class2, collider);
}

int pinch_layer_collide(dGeomID g1, dGeomID g2, int flags, dContactGeom *contacts, int skip)
{
    int count = pinch_layer_own()->ode_collide(g1, g2, flags, contacts, skip);
    if (atomic_load_explicit(&boxes_are_the_programs, memory_order_relaxed)) return count;
    return pinch_tip_mend_boxes(g1, g2, flags, contacts, skip, count);
}
