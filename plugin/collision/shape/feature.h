/* Features are the flat and straight parts of a shape's surface: vertices, edges and faces. */
#ifndef PINCH_COLLISION_FEATURE_H
#define PINCH_COLLISION_FEATURE_H

#include "convex_shape.h"

/* The feature of a shape at a direction is a point, a straight line, or a flat face with its corners in order. */
typedef struct pinch_feature {
    int count;
    bool face;
    bool disc; /* the corners stand for a cap that is square to the direction */
    int index; /* which face of a hull */
    int corner_count;
    unsigned corner[32]; /* vertices of a hull that are as far along d as any other */
    double x[32][3];
    /* of a face: a ball around it (m), and the squared distance of two opposite corners or of a cap's ends (m^2) */
    double centre[3], radius, across2;
} pinch_feature;

/* A regular polygon stands for a rim. These are its corners on the unit circle. */
enum { PINCH_RIM = 8 };
extern const double PINCH_RIM_CORNER[PINCH_RIM][2];

/* A cap is given in any axes: two unit vectors across the shape's axis, the centre and the radius. */
typedef struct pinch_cap {
    double x[3], y[3], centre[3], radius;
} pinch_cap;

/* Fills in the corners that stand for a cap that faces d. The corners are in the axes of `cap`, d is in the shape's. */
void pinch_rim_polygon(const pinch_cap *cap, const double d[3], pinch_feature *part);

/* Tells whether the feature at d is exactly a cap, and finds its centre. */
bool pinch_exact_cap(const pinch_shape *shape, const double d[3], double centre[3]);

/* Fills in that face of a hull with its first corner only, which is often enough. */
void pinch_hull_face_feature(const pinch_hull *hull, int face, pinch_feature *part);

/* Finds a ball around the face or line of a box or cylinder that is nearest to facing d. */
void pinch_nearest_feature_ball(const pinch_shape *shape, const double d[3], double centre[3], double *radius);

/* Fills in all corners of a face that is exactly there and has been given with its first corner only. */
void pinch_face_corners(const pinch_shape *shape, const double d[3], const pinch_feature *exact, pinch_feature *part);

/* Finds the exact feature of a hull where a vertex farthest along d is known. */
void pinch_exact_feature_at_vertex(const pinch_shape *shape, const double d[3], unsigned farthest, pinch_feature *part);

/* Returns the hull's face that is nearest to facing d, where the exact feature is known. */
int pinch_nearest_hull_face(const pinch_shape *shape, const double d[3], const pinch_feature *exact);

/* Finds the face or line that is nearest to facing d, where the exact feature is known and is no face. */
void pinch_nearest_feature(const pinch_shape *shape, const double d[3], const pinch_feature *exact,
                           pinch_feature *part);

/* With `exact`, finds only what is at right angles to d to rounding; a face of a box or hull then comes with one
 * corner. Without it, finds the face or line that is nearest to facing d. */
void pinch_feature_at(const pinch_shape *shape, const double d[3], bool exact, pinch_feature *part);

#endif
