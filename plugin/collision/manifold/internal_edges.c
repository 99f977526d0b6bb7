#include "contact_points.h"

#include "collision/penetration/penetration.h"
#include "support/vec3.h"

#include <math.h>

/* The same point twice, from two pieces that share an edge. */
static void drop_doubles(double size, pinch_tip_touches *touches)
{
    int kept = 0;
    for (int k = 0; k < touches->count; k++) {
        const pinch_tip_touch *t = &touches->item[k];
        bool twice = false;
        for (int i = 0; i < kept && !twice; i++) {
            double d[3];
            const pinch_tip_touch *other = &touches->item[i];
            pinch_v3_sub(t->position, other->position, d);
            twice = pinch_v3_norm(d) < 1e-6 * size && pinch_v3_dot(t->normal, other->normal) > 1 - 1e-6;
        }
        if (!twice) touches->item[kept++] = *t;
    }
    touches->count = kept;
}

/*
 * Where convex pieces of one body meet, each piece has faces and edges that the body has not. A contact is the body's
 * own only if its point on the piece is not part of another piece that the other body is pressed into deeper.
 */
void pinch_drop_seams(const pinch_tip_body *body, int which, pinch_tip_touches *touches)
{
    bool ghost[PINCH_TOUCHES];
    double size = 0;
    for (int k = 0; k < touches->count; k++) size = fmax(size, body->cores[touches->item[k].piece[which]].bound);
    for (int k = 0; k < touches->count; k++) {
        const pinch_tip_touch *t = &touches->item[k];
        double witness[3], normal[3];
        pinch_v3_copy(witness, t->position);
        pinch_v3_add_scaled(witness, which ? 0.5 * t->depth : -0.5 * t->depth, t->normal);
        ghost[k] = false;
        for (int i = 0; i < touches->count && !ghost[k]; i++) {
            const pinch_tip_touch *other = &touches->item[i];
            if (other->piece[which] == t->piece[which] || pinch_v3_dot(other->normal, t->normal) > 1 - 1e-9) continue;
            if (other->depth < t->depth * (1 - 1e-9)) continue;
            ghost[k] = pinch_body_distance(body, other->piece[which], witness, normal) < 1e-7 * size;
        }
    }
    int kept = 0;
    for (int k = 0; k < touches->count; k++)
        if (!ghost[k]) touches->item[kept++] = touches->item[k];
    touches->count = kept;
    drop_doubles(size, touches);
}
