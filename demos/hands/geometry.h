#ifndef PINCH_HANDS_GEOMETRY_H
#define PINCH_HANDS_GEOMETRY_H

#include "reader.h"

#include "meshes/mesh_file.h"

/* How a mesh has mass (MJCF). Legacy counts the tetrahedra between its triangles and their middle, all as positive. */
typedef enum mesh_inertia { MESH_LEGACY = 0, MESH_EXACT, MESH_CONVEX, MESH_SHELL } mesh_inertia;

/* The mesh of that file and scale in the list of the hand; -1 after an error. */
int geometry_mesh(hand_reader *r, const xmlNode *at, const char *name, const char *file, const double scale[3]);
/* The convex hull of mesh `index`, from the triangles in its scale. */
void geometry_hull(hand_reader *r, const xmlNode *at, int index, const mesh_file *triangles);
/* Reads the file. Where that fails, `mesh` is empty. */
bool geometry_read(hand_reader *r, const xmlNode *at, const char *file, mesh_file *mesh);

/* Volume (for a shell: surface) as mass, centre of mass, inertia at density 1. False, with an error, where there is no
 * volume. */
bool geometry_mesh_mass(hand_reader *r, const xmlNode *at, const mesh_file *mesh, mesh_inertia mode, hand_mass *mass);

/* Refuses a mass or inertia that nothing can have. A moment may be larger than the sum of the other two by `part` of
 * it; where it is larger by more than rounding, that is remarked. */
void geometry_check_mass(hand_reader *r, const xmlNode *at, const hand_mass *mass, double part);

/* Unit quaternion of a turn by x, then by the turned y and so on, for the letters of the sequence; lower case turns
 * with the body, upper case about the fixed axes (MJCF's eulerseq). False for other letters. */
bool geometry_euler(const double angles[3], const char *sequence, double q[4]);

#endif
