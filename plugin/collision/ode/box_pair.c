/*
 * Two boxes by ODE's collider, where edges of theirs are parallel but for rounding.
 *
 * ODE's dBoxBox tests fifteen axes, nine of them perpendicular to an edge of either box. Of edges that are parallel
 * their product is rounding, and so is what the test compares: one time in a hundred it finds the boxes apart there,
 * however deep they are in each other, or it takes that axis for the shortest way out and returns a single point at a
 * depth that is no overlap at all. A pad that tilts about one of its edges loses its contact for a step, or half of
 * its force. Whether it does depends on the last bits of the poses, and so on how the scene lies in the world.
 *
 * Such axes separate nothing that the faces do not: boxes with a parallel edge are prisms. There the exact geometry
 * answers in ODE's place. Everything else stays as ODE has returned it.
 */
#include "collide.h"

#include "support/vec3.h"
#include "write_contacts.h"

#include <pinch/fingertip.h>

#include <math.h>
#include <stdbool.h>

/* The sine of the angle below which edges are parallel. Above it rounding is less than 1e-8 of what dBoxBox compares.
 */
static const double PARALLEL = 1e-7;
/* An overlap of less than this part of the boxes may be rounding. */
static const double TOUCHING = 1e-12;
/* ODE's depth along its normal is right to this part. One that is rounding is less by a twentieth: dBoxBox takes an
 * edge's axis only where it is so much shorter than that of each face. */
static const double SAME = 0.01;

typedef struct box {
    const double *centre;
    double axis[3][3], half[3];
} box;

static box read_box(dGeomID geom)
{
    box b = {.centre = dGeomGetPosition(geom)};
    const double *R = dGeomGetRotation(geom);
    dVector3 sides;
    dGeomBoxGetLengths(geom, sides);
    for (int i = 0; i < 3; i++) {
        b.half[i] = 0.5 * sides[i];
        pinch_v3_set(b.axis[i], R[i], R[4 + i], R[8 + i]);
    }
    return b;
}

static bool have_parallel_edges(const box *a, const box *b)
{
    static const double NEARLY = 0.99; /* of the cosine, which tells most others */
    double sine[3];
    for (int i = 0; i < 9; i++) {
        const double *one = a->axis[i / 3], *other = b->axis[i % 3];
        if (fabs(pinch_v3_dot(one, other)) < NEARLY) continue;
        pinch_v3_cross(one, other, sine);
        if (pinch_v3_dot(sine, sine) < PARALLEL * PARALLEL) return true;
    }
    return false;
}

static double half_width(const box *b, const double *direction)
{
    double width = 0;
    for (int i = 0; i < 3; i++) width += b->half[i] * fabs(pinch_v3_dot(b->axis[i], direction));
    return width;
}

/* Returns how far (m) a has to move along a unit vector to leave b. */
static double way_out(const box *a, const box *b, const double *direction)
{
    double apart[3];
    pinch_v3_sub(a->centre, b->centre, apart);
    return half_width(a, direction) + half_width(b, direction) - pinch_v3_dot(apart, direction);
}

/* Boxes with a parallel edge are apart where a face tells so: most of those that ODE has found no contact of. */
static bool face_between(const box *a, const box *b)
{
    double apart[3];
    pinch_v3_sub(a->centre, b->centre, apart);
    for (int i = 0; i < 6; i++) {
        const double *normal = i < 3 ? a->axis[i] : b->axis[i - 3];
        if (fabs(pinch_v3_dot(apart, normal)) >= half_width(a, normal) + half_width(b, normal)) return true;
    }
    return false;
}

static bool has_face(const box *b, const double *normal)
{
    double sine[3];
    for (int i = 0; i < 3; i++) {
        pinch_v3_cross(b->axis[i], normal, sine);
        if (pinch_v3_dot(sine, sine) < PARALLEL * PARALLEL) return true;
    }
    return false;
}

/* Puts points that are half way through the overlap where ODE's collider has them: onto the box whose corners and edges
 * go into the other one's face. */
static void place_as_ode(const box *a, const box *b, dContactGeom *contacts, int skip, int count)
{
    for (int k = 0; k < count; k++) {
        dContactGeom *c = pinch_contact_at(contacts, k, skip);
        double onto = has_face(a, c->normal) ? 0.5 : has_face(b, c->normal) ? -0.5 : 0;
        pinch_v3_add_scaled(c->pos, onto * c->depth, c->normal);
    }
}

int pinch_tip_mend_boxes(dGeomID g1, dGeomID g2, int flags, dContactGeom *contacts, int skip, int count)
{
    enum { MOST = 8 }; /* corners that two faces share */
    if (count > 1 || (unsigned)flags & CONTACTS_UNIMPORTANT || dGeomGetClass(g1) != dBoxClass ||
        dGeomGetClass(g2) != dBoxClass)
        return count;
    box a = read_box(g1), b = read_box(g2);
    if (!have_parallel_edges(&a, &b)) return count;
    if (count == 0 && face_between(&a, &b)) return 0;
    if (count == 1) {
        double way = way_out(&a, &b, contacts->normal);
        if (fabs(way - contacts->depth) <= SAME * way) return count;
    }
    dContactGeom exact[MOST];
    int room = flags & 0xffff, found = pinch_tip_collide(g1, g2, room < MOST ? room : MOST, exact, sizeof *exact);
    double size = pinch_v3_norm(a.half) + pinch_v3_norm(b.half), deepest = 0;
    for (int k = 0; k < found; k++) deepest = fmax(deepest, exact[k].depth);
    if (!(deepest > TOUCHING * size)) return count;
    place_as_ode(&a, &b, exact, sizeof *exact, found);
    for (int k = 0; k < found; k++) *pinch_contact_at(contacts, k, skip) = exact[k];
    return found;
}
