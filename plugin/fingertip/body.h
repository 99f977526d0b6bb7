/* A geom as this geometry sees it: cores with a pose. */
#ifndef PINCH_FINGERTIP_BODY_H
#define PINCH_FINGERTIP_BODY_H

#include "manifold_points.h"
#include "normal.h"

typedef struct pinch_tip_body {
    dGeomID geom; /* named in contacts: a transform that asks for it stands for what it holds */
    const pinch_core *cores;
    int core_count;
    pinch_core own; /* of ODE's geoms, made on the spot */
    double position[3], R[9];
} pinch_tip_body;

/* A tip's data, owned by its geom. */
typedef struct pinch_tip_data {
    pinch_tip tip;
    pinch_core *cores;
    pinch_core_hull *hulls;
    pinch_convex *pieces;
} pinch_tip_data;

/* tip_data.c: NULL without memory; the shape must be legal */
bool pinch_tip_legal(const pinch_tip *tip);
pinch_tip_data *pinch_tip_data_create(const pinch_tip *tip);
void pinch_tip_data_free(pinch_tip_data *data);
/* The edges of a polyhedron; false without memory or where its faces do not close. Free hull->edges. */
bool pinch_hull_of_convex(const pinch_convex *convex, pinch_core_hull *hull);

/* geom.c: false where this geometry does not know the geom's class. `body` must not be copied. */
bool pinch_body_of_geom(dGeomID geom, pinch_tip_body *body);
pinch_tip_stats *pinch_tip_counters(void);

/* One contact, world axes. */
typedef struct pinch_tip_touch {
    double position[3], normal[3], depth;
    int piece[2];
} pinch_tip_touch;

typedef struct pinch_tip_touches {
    int count;
    pinch_tip_touch item[PINCH_TOUCHES];
} pinch_tip_touches;

/* collide.c */
void pinch_collide_bodies(const pinch_tip_body *a, const pinch_tip_body *b, pinch_tip_touches *touches);
void pinch_collide_cores(const pinch_tip_body *a, int piece_a, const pinch_tip_body *b, int piece_b,
                         pinch_tip_touches *touches);
/* Sets the pair up with the pose of b in a's axes. */
void pinch_pair_of(const pinch_tip_body *a, const pinch_core *core_a, const pinch_tip_body *b, const pinch_core *core_b,
                   pinch_core_pair *pair);
/* Drops what pieces of one body have on each other's seams. `which`: the body in pieces. */
void pinch_drop_seams(const pinch_tip_body *body, int which, pinch_tip_touches *touches);
int pinch_write_contacts(const pinch_tip_touches *touches, dGeomID g1, dGeomID g2, int room, dContactGeom *contacts,
                         int skip);

/* special.c */
void pinch_collide_plane(const pinch_tip_body *body, dGeomID plane, pinch_tip_touches *touches);
void pinch_collide_trimesh(const pinch_tip_body *body, dGeomID mesh, pinch_tip_touches *touches);
/* A ray's contact, normal and depth as in ODE; false: none. */
bool pinch_collide_ray(const pinch_tip_body *body, dGeomID ray, double position[3], double normal[3], double *depth);
/* Distance of a point to the body (negative inside) and the outward normal of the nearest surface point; of the core
 * `piece`, or of all (-1). */
double pinch_body_distance(const pinch_tip_body *body, int piece, const double point[3], double normal[3]);

#endif
