#include "pair_features.h"

#include "support/vec3.h"

static void point_to_a(const pinch_core_pair *pair, double *x)
{
    double turned[3];
    pinch_pair_turn(pair, x, turned);
    for (int i = 0; i < 3; i++) x[i] = turned[i] + pair->p[i];
}

static void to_a(const pinch_core_pair *pair, pinch_core_part *part)
{
    for (int k = 0; k < part->count; k++) point_to_a(pair, part->x[k]);
    if (part->face) point_to_a(pair, part->centre);
}

void pinch_outward(const pinch_core_pair *pair, int which, const double n[3], double d[3])
{
    if (which)
        pinch_pair_turn_back(pair, n, d);
    else
        for (int i = 0; i < 3; i++) d[i] = -n[i];
}

void pinch_nearest_part(const pinch_core_pair *pair, int which, const double n[3], const pinch_core_part *exact,
                        pinch_core_part *part)
{
    double d[3];
    pinch_outward(pair, which, n, d);
    pinch_core_nearest_part(which ? pair->b : pair->a, d, exact, part);
    part->disc = false;
    if (which) to_a(pair, part);
}

/* A cap's corners. */
static void rim_at(const pinch_core_pair *pair, int which, const double *d, const double *centre, pinch_core_part *part)
{
    const double *R = pair->R;
    pinch_core_cap cap = {{1, 0, 0}, {0, 1, 0}, {centre[0], centre[1], centre[2]}, pair->a->radius};
    if (which) {
        for (int i = 0; i < 3; i++) {
            cap.x[i] = R[3 * i];
            cap.y[i] = R[3 * i + 1];
        }
        cap.radius = pair->b->radius;
    }
    pinch_core_rim(&cap, d, part);
}

void pinch_all_corners(const pinch_core_pair *pair, int which, const double n[3], const pinch_core_part *known,
                       pinch_core_part *part)
{
    const pinch_core *core = which ? pair->b : pair->a;
    double d[3];
    pinch_outward(pair, which, n, d);
    part->disc = pinch_core_is_round(core);
    if (part->disc) {
        rim_at(pair, which, d, known->x[0], part);
    } else {
        pinch_core_face_corners(core, d, known, part);
        if (which) to_a(pair, part);
    }
}

void pinch_exact_part(const pinch_core_pair *pair, int which, const double n[3], const pinch_least_face faces[2],
                      pinch_core_part *part)
{
    const pinch_core *core = which ? pair->b : pair->a;
    bool hull = core->kind == PINCH_CORE_HULL;
    double d[3];
    pinch_outward(pair, which, n, d);
    if (pinch_core_cap_at(core, d, part->centre)) {
        part->face = true;
        part->count = 1;
        part->radius = core->radius;
        part->across2 = 4 * core->radius * core->radius;
        pinch_v3_copy(part->x[0], part->centre);
    } else if (hull && pinch_gives_normal(&faces[which], n)) {
        pinch_core_face_known(core->hull, faces[which].face, part);
    } else if (hull && pinch_gives_normal(&faces[!which], n)) {
        pinch_core_part_at_corner(core, d, faces[!which].corner, part);
    } else if (hull && faces[which].edge >= 0) {
        pinch_core_part_at_corner(core, d, core->hull->edges[faces[which].edge].corner[0], part);
    } else {
        pinch_core_part_at(core, d, true, part);
    }
    part->disc = false;
    if (which) to_a(pair, part);
}

void pinch_touch_at(const pinch_core_pair *pair, int which, const double x[3], const double n[3], double depth,
                    pinch_touch *touch)
{
    double skin = which ? pair->b->skin : -pair->a->skin, half = which ? -0.5 * depth : 0.5 * depth;
    for (int i = 0; i < 3; i++) touch->position[i] = x[i] + (skin + half) * n[i];
    touch->depth = depth;
}
