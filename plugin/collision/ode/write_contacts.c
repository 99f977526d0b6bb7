#include "write_contacts.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

/* Of points that are equally good to rounding the first one stays, so that moving the pair does not change what is
 * kept. */
static const double TIE = 1e-9;

static double extent_of(const pinch_contact_point *list, int count)
{
    double most = 0, d[3];
    for (int k = 1; k < count; k++) {
        pinch_v3_sub(list[k].position, list[0].position, d);
        double apart2 = pinch_v3_dot(d, d);
        most = apart2 > most ? apart2 : most;
    }
    return sqrt(most);
}

static int deepest_of(const pinch_contact_point *list, int count)
{
    double tie = TIE * extent_of(list, count);
    int best = 0;
    for (int k = 1; k < count; k++)
        if (list[k].depth > list[best].depth + tie) best = k;
    return best;
}

/* Chooses the deepest point, then always the one farthest from those already chosen. */
int pinch_choose_contact_points(const pinch_contact_point *list, int count, int room,
                                int chosen[PINCH_MAX_CONTACT_POINTS])
{
    double far[PINCH_MAX_CONTACT_POINTS];
    if (count <= room) {
        for (int k = 0; k < count; k++) chosen[k] = k;
        return count;
    }
    for (int k = 0; k < count; k++) far[k] = DBL_MAX;
    for (int n = 0, next = deepest_of(list, count); n < room; n++) {
        const double *from = list[next].position;
        double most = -1;
        chosen[n] = next;
        far[next] = -1;
        for (int k = 0; k < count; k++) {
            double d[3];
            pinch_v3_sub(list[k].position, from, d);
            double apart = pinch_v3_dot(d, d);
            far[k] = apart < far[k] ? apart : far[k];
            if (!(far[k] > most + TIE * fabs(most))) continue;
            next = k;
            most = far[k];
        }
    }
    return room;
}

int pinch_write_contacts(const pinch_body_contacts *list, dGeomID g1, dGeomID g2, int room, dContactGeom *contacts,
                         int skip)
{
    pinch_contact_point points[PINCH_MAX_CONTACT_POINTS];
    int chosen[PINCH_MAX_CONTACT_POINTS], count = list->count;
    bool all = count <= room;
    for (int k = 0; k < count && !all; k++) {
        pinch_v3_copy(points[k].position, list->item[k].position);
        points[k].depth = list->item[k].depth;
    }
    if (!all) count = pinch_choose_contact_points(points, count, room, chosen);
    for (int k = 0; k < count; k++) {
        const pinch_body_contact *t = &list->item[all ? k : chosen[k]];
        pinch_write_contact(t->position, t->normal, t->depth, g1, g2, pinch_contact_at(contacts, k, skip));
    }
    return count;
}
