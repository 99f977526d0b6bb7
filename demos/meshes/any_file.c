/* Meshes in other formats than OBJ and STL, by Assimp. OBJ and STL files stay with mesh_file.c: Assimp reads numbers in
 * single precision, and rounds those of a text more than once. */

#define _POSIX_C_SOURCE 200809L

#include "mesh_file.h"

#include "common/input_file.h"
#include "common/pipe.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/* As for the other formats. */
static const double MAX_COORDINATE = 1e6;

/* A file is a tree of some nodes. */
enum { MAX_DEPTH = 64 };

/* A point in the axes of a node. The matrix is row-major; its last row is (0, 0, 0, 1). */
static bool place_point(const struct aiMatrix4x4 *m, const struct aiVector3D *v, double x[3])
{
    double a[3] = {(double)v->x, (double)v->y, (double)v->z};
    x[0] = (double)m->a1 * a[0] + (double)m->a2 * a[1] + (double)m->a3 * a[2] + (double)m->a4;
    x[1] = (double)m->b1 * a[0] + (double)m->b2 * a[1] + (double)m->b3 * a[2] + (double)m->b4;
    x[2] = (double)m->c1 * a[0] + (double)m->c2 * a[1] + (double)m->c3 * a[2] + (double)m->c4;
    return fabs(x[0]) < MAX_COORDINATE && fabs(x[1]) < MAX_COORDINATE && fabs(x[2]) < MAX_COORDINATE;
}

static mesh_status add_face(const struct aiMesh *from, const struct aiFace *face, const struct aiMatrix4x4 *matrix,
                            mesh_file *mesh)
{
    if (face->mNumIndices != 3) return MESH_OK; /* points and lines */
    if (mesh->triangle_count == mesh->triangle_room) {
        size_t room = mesh->triangle_room ? 2 * mesh->triangle_room : 64;
        double *moved = realloc(mesh->corners, 9 * room * sizeof *moved);
        if (!moved) return MESH_NO_MEMORY;
        mesh->corners = moved;
        mesh->triangle_room = room;
    }
    double *x = mesh->corners + 9 * mesh->triangle_count;
    for (int k = 0; k < 3; k++) {
        if (face->mIndices[k] >= from->mNumVertices) return MESH_BAD;
        if (!place_point(matrix, &from->mVertices[face->mIndices[k]], x + 3 * k)) return MESH_BAD;
    }
    mesh->triangle_count++;
    return MESH_OK;
}

static mesh_status add_node(const struct aiScene *scene, const struct aiNode *node, struct aiMatrix4x4 above, int depth,
                            mesh_file *mesh)
{
    mesh_status status = depth < MAX_DEPTH ? MESH_OK : MESH_BAD;
    aiMultiplyMatrix4(&above, &node->mTransformation);
    for (unsigned i = 0; i < node->mNumMeshes && status == MESH_OK; i++) {
        const struct aiMesh *from = scene->mMeshes[node->mMeshes[i]];
        for (unsigned f = 0; f < from->mNumFaces && status == MESH_OK; f++)
            status = add_face(from, &from->mFaces[f], &above, mesh);
    }
    for (unsigned i = 0; i < node->mNumChildren && status == MESH_OK; i++)
        status = add_node(scene, node->mChildren[i], above, depth + 1, mesh);
    return status;
}

static mesh_status import(const char *path, mesh_file *mesh, char *error)
{
    struct aiPropertyStore *settings = aiCreatePropertyStore();
    if (!settings) return MESH_NO_MEMORY;
    /* A hand's file says itself how a mesh is turned, so Collada's own idea of up does not turn it once more. */
    aiSetImportPropertyInteger(settings, AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, 1);
    const struct aiScene *scene =
        aiImportFileExWithProperties(path, aiProcess_Triangulate | aiProcess_ValidateDataStructure, NULL, settings);
    aiReleasePropertyStore(settings);
    if (!scene || !scene->mRootNode) {
        snprintf(error, 256, "expected a mesh that can be read: %.200s", aiGetErrorString());
        for (char *c = error; *c; c++)
            if (*c == '\n' || *c == '\r') *c = ' ';
        if (scene) aiReleaseImport(scene);
        return MESH_BAD;
    }
    struct aiMatrix4x4 identity;
    aiIdentityMatrix4(&identity);
    mesh_status status = add_node(scene, scene->mRootNode, identity, 0, mesh);
    aiReleaseImport(scene);
    if (status == MESH_BAD)
        snprintf(error, 256, "expected coordinates in m, below 1e6, and faces of vertices that are there");
    return status;
}

/* ---- Some of Assimp's readers crash on broken files, or do not come back. So it works in a process of its own. ----
 */

/* Processor seconds, of which a large file takes some tenths of one. */
enum { MOST_SECONDS = 5 };

typedef struct answer {
    mesh_status status;
    size_t triangle_count;
    char error[256];
} answer;

/* The child: nothing of the parent's is touched or flushed. */
static _Noreturn void import_and_send(const char *path, int to)
{
    struct rlimit limit = {MOST_SECONDS, MOST_SECONDS};
    mesh_file mesh = {0};
    answer a = {0};
    setrlimit(RLIMIT_CPU, &limit);
    a.status = import(path, &mesh, a.error);
    a.triangle_count = mesh.triangle_count;
    bool sent =
        pipe_send(to, &a, sizeof a) && pipe_send(to, mesh.corners, 9 * mesh.triangle_count * sizeof *mesh.corners);
    _exit(sent ? 0 : 1);
}

static mesh_status receive_mesh(int from, mesh_file *mesh, char *error)
{
    answer a;
    snprintf(error, 256, "expected a mesh that can be read, but Assimp fails on it");
    if (!pipe_receive(from, &a, sizeof a)) return MESH_BAD;
    if (a.status != MESH_OK) {
        memcpy(error, a.error, sizeof a.error);
        return a.status;
    }
    if (a.triangle_count == 0) {
        snprintf(error, 256, "expected a file with triangles");
        return MESH_BAD;
    }
    mesh->corners = malloc(9 * a.triangle_count * sizeof *mesh->corners);
    mesh->pieces = calloc(1, sizeof *mesh->pieces);
    if (!mesh->corners || !mesh->pieces) return MESH_NO_MEMORY;
    if (!pipe_receive(from, mesh->corners, 9 * a.triangle_count * sizeof *mesh->corners)) return MESH_BAD;
    mesh->triangle_count = mesh->triangle_room = mesh->pieces[0].count = a.triangle_count;
    mesh->piece_count = mesh->piece_room = 1;
    return MESH_OK;
}

static mesh_status import_apart(const char *path, mesh_file *mesh, char *error)
{
    int ends[2];
    if (pipe(ends) != 0) return MESH_NO_MEMORY;
    pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        import_and_send(path, ends[1]);
    }
    close(ends[1]);
    mesh_status status = child < 0 ? MESH_NO_MEMORY : receive_mesh(ends[0], mesh, error);
    close(ends[0]);
    while (child > 0 && waitpid(child, NULL, 0) < 0 && errno == EINTR) continue;
    return status;
}

static bool ends_with(const char *path, const char *end)
{
    size_t length = strlen(path), own = strlen(end);
    return length >= own && strcasecmp(path + length - own, end) == 0;
}

mesh_status mesh_read_any(const char *path, mesh_file *mesh, char *error)
{
    if (ends_with(path, ".obj") || ends_with(path, ".stl")) return mesh_read(path, mesh, error);
    memset(mesh, 0, sizeof *mesh);
    char fault[128];
    FILE *stream = input_open_regular(path, fault);
    if (!stream && !*fault) return MESH_NO_MEMORY;
    if (!stream) {
        snprintf(error, 256, "expected a readable mesh file: %s", fault);
        return MESH_BAD;
    }
    fclose(stream);
    mesh_status status = import_apart(path, mesh, error);
    if (status != MESH_OK) mesh_free(mesh);
    return status;
}
