#ifndef PINCH_MESHES_MESH_FILE_H
#define PINCH_MESHES_MESH_FILE_H

#include <stdbool.h>
#include <stddef.h>

/* Triangle meshes from OBJ files (text; `o` and `g` start a new piece) and STL files (text with one piece per `solid`,
 * or binary with one piece). Lengths are metres. The contents decide which format a file has. */
typedef struct mesh_piece {
    char name[64];
    size_t first, count; /* of its triangles */
} mesh_piece;

typedef struct mesh_file {
    double *corners; /* 9 per triangle */
    size_t triangle_count, triangle_room;
    mesh_piece *pieces; /* none empty */
    size_t piece_count, piece_room;
} mesh_file;

typedef enum mesh_status { MESH_OK = 0, MESH_BAD, MESH_NO_MEMORY } mesh_status;

/* On MESH_BAD `error` (256 bytes) says where and what was expected: "line 3: ...". */
mesh_status mesh_read(const char *path, mesh_file *mesh, char *error);
/* Any file of triangles, by the end of its name: OBJ and STL as above, all others (DAE, glTF, GLB, PLY) by Assimp, as
 * one piece, with the transformations of its nodes applied. */
mesh_status mesh_read_any(const char *path, mesh_file *mesh, char *error);
void mesh_free(mesh_file *mesh);

/* What a piece's triangles enclose. The volume comes from the divergence theorem: triangles of a closed surface give
 * the same about every point. `opening` is the sum of the area vectors (m^2), which is 0 for a closed surface. */
typedef struct mesh_measure {
    double volume, area, opening[3]; /* m^3, m^2, m^2 */
} mesh_measure;

void mesh_piece_measure(const mesh_file *mesh, const mesh_piece *piece, const double about[3], mesh_measure *measure);

#endif
