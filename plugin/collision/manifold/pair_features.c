#include "pair_features.h"

#include "support/vec3.h"

static void to_a(const pinch_shape_pair *pair, pinch_feature *part)
{
    for (int k = 0; k < part->count; k++) pinch_pair_point_to_a(pair, part->x[k], part->x[k]);
    if (part->face) pinch_pair_point_to_a(pair, part->centre, part->centre);
}

void pinch_outward_direction(const pinch_shape_pair *pair, int which, const double n[3], double d[3])
{
    if (which)
        pinch_pair_rotate_back(pair, n, d);
    else
        for (int i = 0; i < 3; i++) d[i] = -n[i];
}

void pinch_pair_nearest_feature(const pinch_shape_pair *pair, int which, const double n[3], const pinch_feature *exact,
                                pinch_feature *part)
{
    double d[3];
    pinch_outward_direction(pair, which, n, d);
    pinch_nearest_feature(which ? pair->b : pair->a, d, exact, part);
    part->disc = false;
    if (which) to_a(pair, part);
}

/* Fills in the corners of a cap. */
static void rim_at(const pinch_shape_pair *pair, int which, const double *d, const double *centre, pinch_feature *part)
{
    const double *R = pair->R;
    pinch_cap cap = {{1, 0, 0}, {0, 1, 0}, {centre[0], centre[1], centre[2]}, pair->a->radius};
    if (which) {
        for (int i = 0; i < 3; i++) {
            cap.x[i] = R[3 * i];
            cap.y[i] = R[3 * i + 1];
        }
        cap.radius = pair->b->radius;
    }
    pinch_rim_polygon(&cap, d, part);
}

void pinch_pair_face_corners(const pinch_shape_pair *pair, int which, const double n[3], const pinch_feature *known,
                             pinch_feature *part)
{
    const pinch_shape *shape = which ? pair->b : pair->a;
    double d[3];
    pinch_outward_direction(pair, which, n, d);
    part->disc = pinch_is_round(shape);
    if (part->disc) {
        rim_at(pair, which, d, known->x[0], part);
    } else {
        pinch_face_corners(shape, d, known, part);
        if (which) to_a(pair, part);
    }
}

void pinch_pair_exact_feature(const pinch_shape_pair *pair, int which, const double n[3],
                              const pinch_least_face faces[2], pinch_feature *part)
{
    const pinch_shape *shape = which ? pair->b : pair->a;
    bool hull = shape->kind == PINCH_SHAPE_HULL;
    double d[3];
    pinch_outward_direction(pair, which, n, d);
    if (pinch_exact_cap(shape, d, part->centre)) {
        part->face = true;
        part->count = 1;
        part->radius = shape->radius;
        part->across2 = 4 * shape->radius * shape->radius;
        pinch_v3_copy(part->x[0], part->centre);
    } else if (hull && pinch_face_gives_normal(&faces[which], n)) {
        pinch_hull_face_feature(shape->hull, faces[which].face, part);
    } else if (hull && pinch_face_gives_normal(&faces[!which], n)) {
        pinch_exact_feature_at_vertex(shape, d, faces[!which].corner, part);
    } else if (hull && faces[which].edge >= 0) {
        pinch_exact_feature_at_vertex(shape, d, shape->hull->edges[faces[which].edge].corner[0], part);
    } else {
        pinch_feature_at(shape, d, true, part);
    }
    part->disc = false;
    if (which) to_a(pair, part);
}

void pinch_contact_point_at(const pinch_shape_pair *pair, int which, const double x[3], const double n[3], double depth,
                            pinch_contact_point *point)
{
    double margin = which ? pair->b->margin : -pair->a->margin, half = which ? -0.5 * depth : 0.5 * depth;
    for (int i = 0; i < 3; i++) point->position[i] = x[i] + (margin + half) * n[i];
    point->depth = depth;
}
