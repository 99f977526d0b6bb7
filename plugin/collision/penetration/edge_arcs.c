#include "edge_arcs.h"

#include "support/vec3.h"

#include <string.h>

static int box_arcs(const pinch_core *core, pinch_edge_arc *arcs)
{
    int count = 0;
    for (int i = 0; i < 3; i++)
        for (int corner = 0; corner < 4; corner++) {
            pinch_edge_arc *arc = &arcs[count++];
            int j = (i + 1) % 3, k = (i + 2) % 3;
            double sj = corner & 1 ? 1 : -1, sk = corner & 2 ? 1 : -1;
            memset(arc, 0, sizeof *arc);
            arc->v[i] = -core->half[i];
            arc->v[j] = sj * core->half[j];
            arc->v[k] = sk * core->half[k];
            arc->u[i] = 1;
            arc->n1[j] = sj;
            arc->n2[k] = sk;
        }
    return count;
}

/* A triangle's edge has the half circle from one side to the other, through the direction that leads outward. */
static int triangle_arcs(const pinch_core *core, pinch_edge_arc *arcs)
{
    double axes[3][3];
    int count = 0;
    if (!pinch_core_axes(core, axes)) return 0;
    for (int k = 0; k < 3; k++) {
        const double *from = core->corner + 3 * k, *to = core->corner + 3 * ((k + 1) % 3);
        double u[3], out[3];
        pinch_v3_sub(to, from, u);
        pinch_v3_scale(u, 1 / pinch_v3_norm(u));
        pinch_v3_cross(u, axes[0], out);
        for (int side = 0; side < 2; side++) {
            pinch_edge_arc *arc = &arcs[count++];
            pinch_v3_copy(arc->v, from);
            pinch_v3_copy(arc->u, u);
            pinch_v3_copy(arc->n1, out);
            for (int i = 0; i < 3; i++) arc->n2[i] = side ? -axes[0][i] : axes[0][i];
        }
    }
    return count;
}

/* A segment has the whole circle, in four quarters. */
static int segment_arcs(const pinch_core *core, pinch_edge_arc *arcs)
{
    for (int k = 0; k < 4; k++) {
        memset(&arcs[k], 0, sizeof arcs[k]);
        arcs[k].v[2] = -core->half[2];
        arcs[k].u[2] = 1;
        arcs[k].n1[k % 2] = k < 2 ? 1 : -1;
        arcs[k].n2[(k + 1) % 2] = k == 0 || k == 3 ? 1 : -1;
    }
    return 4;
}

int pinch_edge_arcs(const pinch_core *core, pinch_edge_arc arcs[PINCH_MAX_EDGES])
{
    switch (core->kind) {
    case PINCH_CORE_SEGMENT:
        return segment_arcs(core, arcs);
    case PINCH_CORE_TRIANGLE:
        return triangle_arcs(core, arcs);
    case PINCH_CORE_BOX:
        return box_arcs(core, arcs);
    case PINCH_CORE_HULL:
        if (core->hull->edge_count > PINCH_MAX_EDGES) return -1;
        memcpy(arcs, core->hull->arcs, (size_t)core->hull->edge_count * sizeof *arcs);
        return core->hull->edge_count;
    default:
        return 0;
    }
}
