/* The flat and straight parts of a shape's surface. */
#ifndef PINCH_COLLISION_FEATURE_H
#define PINCH_COLLISION_FEATURE_H

#include "convex_shape.h"

/* What a shape's surface is at a direction: a point, a straight line, a flat face (its corners in order). */
typedef struct pinch_feature {
    int count;
    bool face;
    bool disc; /* the corners of a cap that is square to the direction */
    int index; /* of a hull's face */
    int corner_count;
    unsigned corner[32]; /* of a hull: those as far along d as any */
    double x[32][3];
    /* of a face: a ball around it, m; squared distance of two corners opposite, or of a cap that of its ends, m^2 */
    double centre[3], radius, across2;
} pinch_feature;

/* What stands for a rim: corners of a regular polygon, on the unit circle. */
enum { PINCH_RIM = 8 };
extern const double PINCH_RIM_CORNER[PINCH_RIM][2];

/* In any axes: those across the shape's axis (unit), the cap's centre and radius. */
typedef struct pinch_cap {
    double x[3], y[3], centre[3], radius;
} pinch_cap;

/* The corners that stand for a cap that faces d, in the axes of `cap`; d in the shape's. */
void pinch_rim_polygon(const pinch_cap *cap, const double d[3], pinch_feature *part);

/* Is there exactly a cap? Its centre. */
bool pinch_exact_cap(const pinch_shape *shape, const double d[3], double centre[3]);

/* That face of a hull, of which the first corner is enough. */
void pinch_hull_face_feature(const pinch_hull *hull, int face, pinch_feature *part);

/* Of a box or cylinder, a ball around the face or line that is nearest to d. */
void pinch_nearest_feature_ball(const pinch_shape *shape, const double d[3], double centre[3], double *radius);

/* The corners of a face that is exactly there, and of which one alone has been given. */
void pinch_face_corners(const pinch_shape *shape, const double d[3], const pinch_feature *exact, pinch_feature *part);

/* What is exactly there, a hull's corner that is farthest along d being known. */
void pinch_exact_feature_at_vertex(const pinch_shape *shape, const double d[3], unsigned farthest, pinch_feature *part);

/* The hull's face that is nearest to d, `exact` being what is there exactly. */
int pinch_nearest_hull_face(const pinch_shape *shape, const double d[3], const pinch_feature *exact);

/* The face or line that comes nearest, where `exact` is what there is exactly and no face. */
void pinch_nearest_feature(const pinch_shape *shape, const double d[3], const pinch_feature *exact,
                           pinch_feature *part);

/* `exact`: only what is at right angles to d to rounding, and of a box' or hull's face one corner; otherwise the face
 * or line that comes nearest. */
void pinch_feature_at(const pinch_shape *shape, const double d[3], bool exact, pinch_feature *part);

#endif
