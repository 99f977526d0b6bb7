#include "contact_points.h"

#include "collision/penetration/penetration.h"
#include "support/vec3.h"

#include <math.h>

/* Two pieces that share an edge give the same point twice. */
static void drop_doubles(double size, pinch_body_contacts *contacts)
{
    int kept = 0;
    for (int k = 0; k < contacts->count; k++) {
        const pinch_body_contact *t = &contacts->item[k];
        bool twice = false;
        for (int i = 0; i < kept && !twice; i++) {
            double d[3];
            const pinch_body_contact *other = &contacts->item[i];
            pinch_v3_sub(t->position, other->position, d);
            twice = pinch_v3_norm(d) < 1e-6 * size && pinch_v3_dot(t->normal, other->normal) > 1 - 1e-6;
        }
        if (!twice) contacts->item[kept++] = *t;
    }
    contacts->count = kept;
}

/*
 * Where convex pieces of one body join, each piece has faces and edges that the body does not have. A contact is the
 * body's own only if its point on the piece does not belong to another piece into which the other body is pressed
 * deeper. Other contacts are ghosts.
 */
void pinch_drop_internal_edges(const pinch_posed_body *body, int which, pinch_body_contacts *contacts)
{
    bool ghost[PINCH_MAX_CONTACT_POINTS];
    double size = 0;
    for (int k = 0; k < contacts->count; k++) size = fmax(size, body->shapes[contacts->item[k].piece[which]].bound);
    for (int k = 0; k < contacts->count; k++) {
        const pinch_body_contact *t = &contacts->item[k];
        double witness[3], normal[3];
        pinch_v3_copy(witness, t->position);
        pinch_v3_add_scaled(witness, which ? 0.5 * t->depth : -0.5 * t->depth, t->normal);
        ghost[k] = false;
        for (int i = 0; i < contacts->count && !ghost[k]; i++) {
            const pinch_body_contact *other = &contacts->item[i];
            if (other->piece[which] == t->piece[which] || pinch_v3_dot(other->normal, t->normal) > 1 - 1e-9) continue;
            if (other->depth < t->depth * (1 - 1e-9)) continue;
            ghost[k] = pinch_signed_distance(body, other->piece[which], witness, normal) < 1e-7 * size;
        }
    }
    int kept = 0;
    for (int k = 0; k < contacts->count; k++)
        if (!ghost[k]) contacts->item[kept++] = contacts->item[k];
    contacts->count = kept;
    drop_doubles(size, contacts);
}
