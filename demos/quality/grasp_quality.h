#ifndef PINCH_GRASP_QUALITY_H
#define PINCH_GRASP_QUALITY_H

#include <pinch/statics.h>
#include <stdbool.h>

/* The qualities of Ferrari and Canny (1992) of a grasp: the largest ball about the origin that lies in the grasp wrench
 * space, and the volume of that space. Both are of one newton of normal force in all, whatever the closings are. */

enum { WRENCH_MOST = 6 }; /* components of a wrench */

typedef struct grasp_quality_settings {
    int faces;        /* of the polyhedral cone that stands for each friction cone: 3 to 256, default 8 */
    double tolerance; /* epsilon is refined until its bounds are this close, relative; INFINITY: it is that of the
                         faces alone. Default 0.01 */
    int most_points;  /* and until the hull has this many points; default 200 */
} grasp_quality_settings;

grasp_quality_settings grasp_quality_default_settings(void);

typedef struct grasp_quality {
    int faces;  /* used */
    int points; /* of the hull, after the refinement */
    /* The least wrench (N for each newton, torques over the radius) that the grasp cannot exert lies between these two.
     * The first holds by the hull, which lies within the wrench space, and the second by the exact friction cones in
     * the weakest direction. Both are 0 where it is proved that some wrench cannot be exerted at all; a lower bound of
     * 0 beside an upper one that is larger leaves that open. */
    double epsilon, epsilon_upper;
    double volume;               /* of the hull with these faces, a lower bound of the wrench space's */
    double weakest[WRENCH_MOST]; /* unit: the direction of wrenches in which epsilon_upper is reached */
} grasp_quality;

typedef enum grasp_quality_status {
    GRASP_QUALITY_FINE = 0,
    GRASP_QUALITY_NO_MEMORY,
    GRASP_QUALITY_FAILED /* Qhull found no hull, for a reason other than a flat wrench space */
} grasp_quality_status;

/* The fingers' stiffness, closing and force play no part. */
grasp_quality_status grasp_quality_find(const pinch_grasp *grasp, const grasp_quality_settings *settings,
                                        grasp_quality *quality);

/* ---- directions.c ---- */

/* What is in reserve where the load is a force at the centre of mass along one of the world's axes. */
typedef struct grasp_direction {
    double direction[3];                                                      /* unit */
    pinch_static_limit least_closing, smallest_friction, largest_load_factor; /* as <pinch/statics.h> has them */
} grasp_direction;

typedef struct grasp_directions {
    int count;    /* 6; in the plane 4 */
    double force; /* N, > 0: the size of each load */
    grasp_direction of[6];
} grasp_directions;

/* Closing, friction and stiffness are the grasp's; its own wrench plays no part. Costs and returns as three searches of
 * pinch_statics_limits for each direction. */
pinch_status grasp_directions_find(pinch_statics *statics, const pinch_grasp *grasp,
                                   const pinch_statics_settings *settings, double force, grasp_directions *found);

/* ---- wrench_space.c ---- */

/*
 * The grasp wrench space of Ferrari and Canny (1992): all wrenches that the contacts can exert on the object with
 * normal forces of 1 N in all,
 *
 *     { sum_i G_i r_i :  r_i in the friction cone of contact i,  sum_i r_in <= 1 }.
 *
 * Torques are divided by the grasp's radius, so that all components are newtons for each newton of normal force. A
 * space of dimension 6 has the components (force, torque), one of dimension 3 (planar) has (fx, fy, torque about z).
 */
typedef struct wrench_space {
    int dimension; /* 3 or 6 */
    int count;     /* contacts, >= 1 */
    const pinch_finger *contacts;
    double radius; /* m, > 0 */
} wrench_space;

wrench_space wrench_space_of(const pinch_grasp *grasp);

/* How far contact i reaches in the direction d, the largest d . w of its wrenches w, and in `w` such a wrench. */
double wrench_space_support(const wrench_space *s, int i, const double d[WRENCH_MOST], double w[WRENCH_MOST]);

/* The same of all contacts: the furthest reach, < 0 where all wrenches point away from d, and such a wrench. */
double wrench_space_reach(const wrench_space *s, const double d[WRENCH_MOST], double w[WRENCH_MOST]);

/* Looks for a direction d (unit) in which no contact reaches further than `most` (>= 0, about 0): no force of the
 * contacts gives a wrench there. False: none was found, which is no proof that there is none. */
bool wrench_space_lacks(const wrench_space *s, double most, double d[WRENCH_MOST]);

/* The number of wrenches that stand for a contact's cone with this many faces. */
int wrench_space_generators(const wrench_space *s, int i, int faces);
/* Writes them, `dimension` numbers each. They lie on the surface of the friction cone: directions of friction at equal
 * angles, and for a soft contact such rings at `faces` / 4 latitudes above and below the equator of its limit surface,
 * with the two poles. */
void wrench_space_generate(const wrench_space *s, int i, int faces, double *wrenches);

#endif
