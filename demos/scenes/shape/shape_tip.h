#ifndef PINCH_SCENE_SHAPE_TIP_H
#define PINCH_SCENE_SHAPE_TIP_H

#include "scenes/scene.h"

#include <pinch/fingertip.h>

/* The shape as fingertip geometry has it; false for shapes with vertices, whose hulls are needed as well. */
bool scene_shape_tip(const scene_shape *shape, pinch_tip *tip);

#endif
