#ifndef PINCH_FINGERTIP_H
#define PINCH_FINGERTIP_H

#include <ode/ode.h>
#include <pinch/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Fingertips of real shape: an ODE geom class for convex bodies that are given by their support functions, and the
 * contact geometry behind it, which also serves pairs of ODE's own geoms.
 *
 * A shape is a convex set and a skin, which is a ball rolled around it. While two convex sets are apart, the distance
 * between them (GJK) gives depth and normal. Once they overlap, the kinds of the shapes decide on the method.
 * Polyhedra, cylinders and flat capsules against polyhedra, and cylinders against each other have a list of axes at
 * which the overlap can be least: those of faces, edges, corners, sides and rims. For all others, a polytope inside
 * their Minkowski difference expands until no other direction can have less overlap (EPA). Curved contacts are finished
 * with Newton's method on the support functions. Depths are good to 1e-6 of the size, normals to 1e-4 rad. SI units.
 *
 * Depth is the shortest way out: the least overlap h_A(-n) + h_B(n) over all unit normals n, where h are the support
 * functions. Contacts are ODE's: `normal` points into g1, `depth` is positive, `pos` is half way through the overlap.
 * Where flat or straight features meet there are several points, all along the same normal, each with its own depth.
 * A superellipsoid with an exponent below 1 is nearly flat around its poles. Under a face, a plane or a straight edge
 * it has the points that stand for a pad's pressure there (its middle and spread), all of them with the whole depth.
 * If the geoms are swapped, the contact is the same, mirrored, to the bit.
 *
 * Several threads may find contacts at the same time, where ODE allows it. What concerns the whole process is not
 * guarded: the class, the known convexes and the pairs that are taken over. The calls that change it are the first
 * pinch_create_tip, pinch_tip_know_convex, pinch_tip_take_over and pinch_close_tips; while one of them runs, no other
 * thread may be in a function of this header or in dCollide.
 */

/* A convex polyhedron in the arrays that dCreateConvex takes, in the geom's own coordinates. */
typedef struct pinch_convex {
    const double *planes;     /* 4 per face: unit outward normal, offset (m) */
    unsigned plane_count;     /* >= 4 */
    const double *points;     /* 3 per vertex, m */
    const unsigned *polygons; /* per face: number of corners, then their indices, counter-clockwise from outside */
    unsigned point_count;     /* >= 4; every point is a corner of some face, and every index is below this */
} pinch_convex;

typedef enum pinch_tip_type {
    PINCH_TIP_SPHERE = 0,     /* size: radius */
    PINCH_TIP_CAPSULE,        /* size: radius, length without caps, along z */
    PINCH_TIP_FLAT_CAPSULE,   /* size: radius, length of the cylinder; a half ball at +z, a flat end at -z */
    PINCH_TIP_BOX,            /* size: edge lengths; edges rounded by the skin */
    PINCH_TIP_CYLINDER,       /* size: radius, length along z; rims rounded by the skin */
    PINCH_TIP_ELLIPSOID,      /* size: semi-axes */
    PINCH_TIP_SUPERELLIPSOID, /* size: semi-axes; with the exponents e:
                               * (|x/a|^(2/e[1]) + |y/b|^(2/e[1]))^(e[1]/e[0]) + |z/c|^(2/e[0]) = 1 */
    PINCH_TIP_CONVEX,         /* `pieces` convex polyhedra, each thickened by the skin; several are one body */
    PINCH_TIP_COUNT
} pinch_tip_type;

/* A shape in its own axes, about its centre of mass (convex: about the origin of its points). */
typedef struct pinch_tip {
    pinch_tip_type type;        /* what it is, and what `size` means */
    double size[3];             /* m, > 0, see above; outer measures, the skin included */
    double exponent[2];         /* superellipsoid: in [0.25, 1.6]; 1 makes an ellipsoid */
    double skin;                /* m, >= 0. box, cylinder: below half the least outer measure; convex: comes on top */
    const pinch_convex *pieces; /* convex: piece_count of them */
    int piece_count;            /* convex: >= 1 */
} pinch_tip;

/* Returns a tip without a size. Fill in `size`. */
PINCH_API pinch_tip pinch_default_tip(pinch_tip_type type);

/* Mass properties at uniform density, about the centre of mass, in the shape's axes. A convex body must be about its
 * own centre of mass, and its pieces must not overlap; its skin is left out. The superellipsoid's are closed forms in
 * the beta function (Jaklic, Leonardis, Solina: Segmentation and Recovery of Superquadrics, 2000); a rounded body's are
 * exact. `unit_inertia` (m^2, row-major 3 x 3) is the inertia per unit of mass; `volume` in m^3. */
PINCH_API pinch_status pinch_tip_inertia(const pinch_tip *tip, double *volume, double unit_inertia[9]);

/*
 * A geom of the fingertip class, in `space` (may be NULL). The data are copied. dInitODE must have been called; the
 * first call registers the class, one of the four that ODE has room for, and dCloseODE ends it. PINCH_INVALID_ARGUMENT
 * for a shape out of range, PINCH_UNSUPPORTED where ODE has no room for the class.
 *
 * dCollide and dSpaceCollide then work against ODE's spheres, boxes, capsules, cylinders, planes, convexes, rays,
 * trimeshes and geom transforms, with offsets, and other tips. ODE has no public way to read a convex geom: make those
 * known with pinch_tip_know_convex. A trimesh counts as a surface: every triangle is met from the side its normal
 * points to. A ray's contact is as ODE's: `depth` is the distance from its start, `normal` the surface's, against the
 * ray.
 */
PINCH_API pinch_status pinch_create_tip(dSpaceID space, const pinch_tip *tip, dGeomID *geom);
/* Returns the number of the class, for dGeomGetClass, or -1 before the first tip. */
PINCH_API int pinch_tip_class(void);
/* Forgets the class and the known convexes. Programs that open ODE again call it after dCloseODE, when all tips are
 * gone. */
PINCH_API void pinch_close_tips(void);
/* Returns the shape of a geom of the class, or NULL for another geom. */
PINCH_API const pinch_tip *pinch_tip_of(dGeomID geom);

/* Makes the arrays of a dConvexClass geom known (they must outlive it), or with NULL says that it is gone. Before
 * that, it has no contact with tips, and counts in `unknown_convex`. */
PINCH_API pinch_status pinch_tip_know_convex(dGeomID geom, const pinch_convex *convex);

/*
 * Finds the contacts of two geoms of any class by this geometry instead of ODE's own colliders, where it knows both
 * shapes. There are at most `room` of them (1 to 65535), `skip` bytes apart. Returns their number.
 */
PINCH_API int pinch_tip_collide(dGeomID g1, dGeomID g2, int room, dContactGeom *contacts, int skip);

/*
 * Puts right what ODE's dCollide has returned for two geoms: `count` contacts for these flags, at `contacts`, `skip`
 * bytes apart. Where edges of two boxes are parallel to rounding, ODE's collider loses one pair in a hundred that
 * overlaps, or returns a point of a wrong depth. There this geometry answers; all else stays as it is. Returns the
 * number of contacts. CONTACTS_UNIMPORTANT in the flags leaves everything to ODE. Programs under the drop-in layer
 * have it done by dCollide.
 */
PINCH_API int pinch_tip_mend_boxes(dGeomID g1, dGeomID g2, int flags, dContactGeom *contacts, int skip, int count);

/* Makes dCollide use this geometry for two of ODE's own classes, until dCloseODE: sphere, box, capsule, cylinder,
 * plane, trimesh, and convexes that are known. PINCH_INVALID_ARGUMENT for other classes. */
PINCH_API pinch_status pinch_tip_take_over(int class1, int class2);

/* Finds the signed distance (m, negative inside) of a point to a geom's surface, the surface point nearest to it, and
 * the surface's outward normal there. It knows the shapes that pinch_tip_collide knows, except rays and trimeshes, for
 * which it returns PINCH_UNSUPPORTED. PINCH_INVALID_ARGUMENT for a point that is not finite. */
PINCH_API pinch_status pinch_tip_closest_point(dGeomID geom, const double point[3], double *distance, double nearest[3],
                                               double normal[3]);

/*
 * Finds the principal curvatures (1/m) of a geom's surface where its outward normal is `normal` (unit, world), and the
 * direction (unit, world) of the first, which is the smaller one. They are 0, 0 on a face and 0, 1/r along a cylinder.
 * On sharp edges and corners they are infinite. It knows the same shapes as pinch_tip_closest_point.
 */
PINCH_API pinch_status pinch_tip_curvature(dGeomID geom, const double normal[3], double curvature[2],
                                           double direction[3]);

/* What this geometry did, in this thread. */
typedef struct pinch_tip_stats {
    long pairs;           /* convex pairs looked at beyond their bounding balls */
    long deep;            /* of these, shapes that overlapped, skins left out */
    long iteration_limit; /* searches that stopped at their limit, short of proof; the best normal so far is used */
    long unknown_convex;  /* convex geoms that were met and not known */
} pinch_tip_stats;

PINCH_API pinch_tip_stats pinch_tip_statistics(void);
PINCH_API void pinch_tip_reset_statistics(void);

#ifdef __cplusplus
}
#endif
#endif
