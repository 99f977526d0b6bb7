/* A tip keeps its own copy of its shape, and ODE's geom class keeps the tip. */
#include "tip_data.h"

#include "convex_shape.h"
#include "hull.h"
#include "support/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

pinch_tip pinch_default_tip(pinch_tip_type type)
{
    pinch_tip tip;
    memset(&tip, 0, sizeof tip);
    tip.type = type;
    tip.exponent[0] = tip.exponent[1] = 1;
    return tip;
}

static bool positive(const double *values, int count)
{
    for (int i = 0; i < count; i++)
        if (!(values[i] > 0) || !isfinite(values[i])) return false;
    return true;
}

static bool polygons_legal(const pinch_convex *convex)
{
    const unsigned *polygon = convex->polygons;
    for (unsigned f = 0; f < convex->plane_count; f++, polygon += 1 + polygon[0]) {
        if (polygon[0] < 3) return false;
        for (unsigned k = 1; k <= polygon[0]; k++)
            if (polygon[k] >= convex->point_count) return false;
    }
    return true;
}

static bool pieces_legal(const pinch_tip *tip)
{
    if (!tip->pieces || tip->piece_count < 1) return false;
    for (int k = 0; k < tip->piece_count; k++) {
        const pinch_convex *c = &tip->pieces[k];
        if (!c->planes || !c->points || !c->polygons || c->plane_count < 4 || c->point_count < 4) return false;
        if (!polygons_legal(c)) return false;
    }
    return true;
}

bool pinch_tip_legal(const pinch_tip *tip)
{
    static const int SIZES[] = {1, 2, 2, 3, 2, 3, 3, 0};
    if (!tip || (unsigned)tip->type >= PINCH_TIP_COUNT) return false;
    if (!positive(tip->size, SIZES[tip->type]) || !(tip->skin >= 0) || !isfinite(tip->skin)) return false;
    const double *s = tip->size;
    switch (tip->type) {
    case PINCH_TIP_BOX:
        return tip->skin < 0.5 * fmin(s[0], fmin(s[1], s[2]));
    case PINCH_TIP_CYLINDER:
        return tip->skin < fmin(s[0], 0.5 * s[1]);
    case PINCH_TIP_SUPERELLIPSOID:
        for (int i = 0; i < 2; i++)
            if (!(tip->exponent[i] >= 0.25 && tip->exponent[i] <= 1.6)) return false;
        return true;
    case PINCH_TIP_CONVEX:
        return pieces_legal(tip);
    default:
        return true;
    }
}

static size_t polygons_length(const pinch_convex *convex)
{
    size_t length = 0;
    for (unsigned f = 0; f < convex->plane_count; f++) length += 1 + convex->polygons[length];
    return length;
}

static void *copy_of(const void *from, size_t size)
{
    void *copy = malloc(size);
    if (copy) memcpy(copy, from, size);
    return copy;
}

static bool copy_piece(const pinch_convex *from, pinch_convex *to)
{
    *to = *from;
    to->planes = copy_of(from->planes, 4 * from->plane_count * sizeof(double));
    to->points = copy_of(from->points, 3 * from->point_count * sizeof(double));
    to->polygons = copy_of(from->polygons, polygons_length(from) * sizeof(unsigned));
    return to->planes && to->points && to->polygons;
}

void pinch_tip_data_free(pinch_tip_data *data)
{
    if (!data) return;
    for (int k = 0; data->pieces && k < data->tip.piece_count; k++) {
        free((void *)data->pieces[k].planes);
        free((void *)data->pieces[k].points);
        free((void *)data->pieces[k].polygons);
        if (data->hulls) pinch_hull_free(&data->hulls[k]);
    }
    free(data->pieces);
    free(data->hulls);
    free(data->shapes);
    free(data);
}

static bool copy_pieces(pinch_tip_data *data, const pinch_tip *tip)
{
    size_t count = (size_t)tip->piece_count;
    data->pieces = calloc(count, sizeof *data->pieces);
    data->hulls = calloc(count, sizeof *data->hulls);
    if (!data->pieces || !data->hulls) return false;
    for (size_t k = 0; k < count; k++) {
        if (!copy_piece(&tip->pieces[k], &data->pieces[k])) return false;
        if (!pinch_hull_of_convex(&data->pieces[k], &data->hulls[k])) return false;
    }
    data->tip.pieces = data->pieces;
    return true;
}

pinch_tip_data *pinch_tip_data_create(const pinch_tip *tip)
{
    pinch_tip_data *data = calloc(1, sizeof *data);
    if (!data) return NULL;
    bool convex = tip->type == PINCH_TIP_CONVEX;
    size_t shapes = convex ? (size_t)tip->piece_count : 1;
    data->tip = *tip;
    data->shapes = calloc(shapes, sizeof *data->shapes);
    if (!data->shapes || (convex && !copy_pieces(data, tip))) {
        pinch_tip_data_free(data);
        return NULL;
    }
    for (size_t k = 0; k < shapes; k++) data->shapes[k] = pinch_shape_of_tip(tip, convex ? &data->hulls[k] : NULL);
    return data;
}

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
