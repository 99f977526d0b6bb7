#ifndef PINCH_LAW_LIMIT_POLYGON_H
#define PINCH_LAW_LIMIT_POLYGON_H

#include <stdbool.h>

/*
 * Projection of the trial friction s (N, N) onto the regular polygon whose facet k has the outward normal at angle
 * 2 pi k/faces and the distance `apothem` (N, >= 0) from the centre: the linearized counterpart of the friction disc.
 * faces = 2 is the strip |r_1| <= apothem.
 *
 * dr_ds[4] (row-major) and dr_dscale[2], with respect to a common factor on the polygon at 1, may be NULL.
 * Returns whether s was inside: r = s.
 */
bool pinch_limit_polygon_project(int faces, double apothem, const double s[2], double r[2], double dr_ds[4],
                                 double dr_dscale[2]);

#endif
