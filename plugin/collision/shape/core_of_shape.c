#include "core_of_shape.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

pinch_core pinch_core_of_triangle(const double corners[9])
{
    pinch_core core;
    memset(&core, 0, sizeof core);
    core.kind = PINCH_CORE_TRIANGLE;
    memcpy(core.corner, corners, sizeof core.corner);
    for (int k = 0; k < 3; k++) core.bound = fmax(core.bound, pinch_v3_norm(corners + 3 * k));
    return core;
}

/* Half ball (height of its centre of mass 3 r/8 over its flat side) on a cylinder: where the cylinder's middle lies,
 * seen from the centre of mass of both. */
static double flat_capsule_middle(double r, double l)
{
    double tube = l, dome = 2.0 / 3.0 * r; /* volumes over pi r^2 */
    return -dome * (0.5 * l + 0.375 * r) / (tube + dome);
}

static void hull_core(pinch_core *core, const pinch_core_hull *hull)
{
    core->kind = PINCH_CORE_HULL;
    core->hull = hull;
    core->bound = hull->outer + core->skin;
}

pinch_core pinch_core_of_tip(const pinch_tip *tip, const pinch_core_hull *hull)
{
    pinch_core core;
    const double *s = tip->size;
    memset(&core, 0, sizeof core);
    switch (tip->type) {
    case PINCH_TIP_SPHERE:
        core.skin = core.bound = s[0];
        break;
    case PINCH_TIP_CAPSULE:
        core.kind = PINCH_CORE_SEGMENT;
        core.half[2] = 0.5 * s[1];
        core.skin = s[0];
        core.bound = core.half[2] + s[0];
        break;
    case PINCH_TIP_FLAT_CAPSULE:
        core.kind = PINCH_CORE_FLAT_CAPSULE;
        core.radius = s[0];
        core.half[2] = 0.5 * s[1];
        core.middle = flat_capsule_middle(s[0], s[1]);
        core.bound = fmax(core.middle + core.half[2] + s[0], hypot(s[0], core.half[2] - core.middle));
        break;
    case PINCH_TIP_BOX:
        core.kind = PINCH_CORE_BOX;
        core.skin = tip->skin;
        for (int i = 0; i < 3; i++) core.half[i] = 0.5 * s[i] - tip->skin;
        core.bound = pinch_v3_norm(core.half) + tip->skin;
        break;
    case PINCH_TIP_CYLINDER:
        core.kind = PINCH_CORE_CYLINDER;
        core.skin = tip->skin;
        core.radius = s[0] - tip->skin;
        core.half[2] = 0.5 * s[1] - tip->skin;
        core.bound = hypot(core.radius, core.half[2]) + tip->skin;
        break;
    case PINCH_TIP_ELLIPSOID: {
        double least = fmin(s[0], fmin(s[1], s[2])), most = fmax(s[0], fmax(s[1], s[2]));
        core.kind = PINCH_CORE_ELLIPSOID;
        pinch_v3_copy(core.half, s);
        core.bound = most;
        core.erosion = 0.999 * least * least / most;
        break;
    }
    case PINCH_TIP_SUPERELLIPSOID:
        core.kind = PINCH_CORE_SUPERELLIPSOID;
        pinch_v3_copy(core.half, s);
        core.bound = pinch_v3_norm(s);
        for (int i = 0; i < 2; i++) core.power[i] = 2 / (2 - tip->exponent[i]); /* 1/p + 1/q = 1 with p = 2/e */
        break;
    default:
        core.skin = tip->skin;
        hull_core(&core, hull);
    }
    return core;
}
