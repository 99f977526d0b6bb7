/* Meshes of MJCF files: in files or written out, moved, scaled, and weighed. */

#include "mjcf.h"

#include <stdlib.h>

static const char *stem(hand_reader *r, const char *file)
{
    const char *slash = strrchr(file, '/');
    if (slash) file = slash + 1;
    const char *dot = strrchr(file, '.');
    return reader_text(r, "%.*s", (int)(dot ? dot - file : (long)strlen(file)), file);
}

static void read_mesh(mjcf *m, xmlNode *node)
{
    hand_reader *r = m->r;
    const char *file = xml_text(node, "file"), *name = xml_text(node, "name");
    reader_only(
        r, node,
        "name class content_type file vertex normal texcoord face refpos refquat scale smoothnormal maxhullvert "
        "inertia material");
    if (!file && !xml_text(node, "vertex")) {
        reader_refuse(r, node, "expected a file or vertices");
        return;
    }
    if (!name || !*name) name = file ? stem(r, file) : "";
    if (r->status == HAND_OK && mjcf_find_mesh(m, name)) {
        reader_refuse(r, node, "expected a name of its own, but another mesh is called \"%.100s\", too", name);
        return;
    }
    mjcf_mesh *mesh = reader_append(r, &m->meshes, &m->mesh_count, sizeof *mesh);
    if (mesh) *mesh = (mjcf_mesh){.name = name, .node = node, .place = -1};
}

void mjcf_read_assets(mjcf *m)
{
    for (xmlNode *s = xml_child(m->root, "asset"); s && m->r->status == HAND_OK; s = xml_next(s, "asset"))
        for (xmlNode *n = xml_child(s, NULL); n && m->r->status == HAND_OK; n = xml_next(n, NULL)) {
            if (xml_is(n, "mesh"))
                read_mesh(m, n);
            else if (xml_listed("texture material skin hfield", (const char *)n->name))
                reader_ignore(m->r, n, (const char *)n->name);
            else
                reader_refuse(m->r, n, "not supported in an asset");
        }
}

mjcf_mesh *mjcf_find_mesh(mjcf *m, const char *name)
{
    for (size_t i = 0; i < m->mesh_count; i++)
        if (strcmp(m->meshes[i].name, name) == 0) return &m->meshes[i];
    return NULL;
}

static char *mesh_path(mjcf *m, const char *file)
{
    hand_reader *r = m->r;
    const char *slash = m->compiler.strip ? strrchr(file, '/') : NULL, *directory = m->compiler.meshes;
    if (slash) file = slash + 1;
    if (file[0] == '/' || !*directory) return reader_path(r, r->h->file, file);
    char *path = reader_text(r, "%s%s%s", directory, directory[strlen(directory) - 1] == '/' ? "" : "/", file);
    return path ? reader_path(r, r->h->file, path) : NULL;
}

static size_t count_numbers(const char *text)
{
    size_t count = 0;
    while (*(text += strspn(text, " \t\r\n"))) {
        text += strcspn(text, " \t\r\n");
        count++;
    }
    return count;
}

/* An attribute of any number of numbers; NULL where it is not there, or after an error. */
static double *read_list(hand_reader *r, const xmlNode *node, const char *name, size_t *count)
{
    const char *text = xml_text(node, name);
    *count = text ? count_numbers(text) : 0;
    if (*count == 0 || r->status != HAND_OK) return NULL;
    double *values = malloc(*count * sizeof *values);
    if (!values) reader_no_memory(r);
    if (*count % 3) reader_refuse(r, node, "expected three numbers for each of the %s list", name);
    if (values) reader_numbers(r, node, name, values, *count, *count);
    if (r->status == HAND_OK) return values;
    free(values);
    return NULL;
}

/* Vertices and faces that stand in the file. Without faces the mesh is the hull of its vertices: every vertex becomes
 * a triangle of no size, which the hull does not mind. */
static void read_written(hand_reader *r, const xmlNode *node, mesh_file *mesh)
{
    size_t vertices, corners;
    double *x = read_list(r, node, "vertex", &vertices), *face = read_list(r, node, "face", &corners);
    memset(mesh, 0, sizeof *mesh);
    if (x && r->status == HAND_OK) {
        size_t count = face ? corners : vertices;
        mesh->corners = malloc((face ? 3 : 9) * count / (face ? 1 : 3) * sizeof *mesh->corners);
        mesh->triangle_count = count / 3;
        if (!mesh->corners) reader_no_memory(r);
        for (size_t i = 0; i < count && mesh->corners; i++) {
            double index = face ? face[i] : 0;
            if (index < 0 || index >= (double)(vertices / 3) || index != floor(index)) {
                reader_refuse(r, node, "expected numbers of vertices in face, not %g", index);
                break;
            }
            if (face)
                scene_copy(x + 3 * (size_t)index, mesh->corners + 3 * i);
            else if (i % 3 == 0)
                for (size_t k = 0; k < 3; k++) scene_copy(x + i, mesh->corners + 3 * (i + k));
        }
    }
    free(x);
    free(face);
    if (r->status != HAND_OK) mesh_free(mesh);
}

/* MuJoCo keeps coordinates of files in single precision; then it moves by refpos and refquat, and scales. */
static void transform(const mjcf_element *e, const double scale[3], mesh_file *mesh)
{
    hand_pose frame = pose_identity();
    reader_numbers(e->m->r, e->node, "refpos", frame.position, 3, 3);
    if (reader_numbers(e->m->r, e->node, "refquat", frame.orientation, 4, 4) && !pose_normalize(frame.orientation))
        reader_refuse(e->m->r, e->node, "expected a refquat that is not 0");
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        double *x = mesh->corners + 3 * i, moved[3];
        for (int k = 0; k < 3; k++) x[k] = (double)(float)x[k];
        pose_point_back(&frame, x, moved);
        for (int k = 0; k < 3; k++) x[k] = scale[k] * moved[k];
    }
    if (scale[0] * scale[1] * scale[2] > 0) return;
    for (size_t t = 0; t < mesh->triangle_count; t++) { /* a mirrored mesh would have its inside out */
        double *x = mesh->corners + 9 * t, kept[3];
        scene_copy(x + 3, kept);
        scene_copy(x + 6, x + 3);
        scene_copy(kept, x + 6);
    }
}

bool mjcf_weigh_mesh(mjcf *m, mjcf_mesh *mesh, bool weighed, bool collides)
{
    hand_reader *r = m->r;
    mjcf_element e;
    mesh_file triangles;
    double scale[3] = {1, 1, 1};
    if (!mjcf_open(m, mesh->node, NULL, "mesh", &e)) return false;
    mjcf_numbers(&e, "scale", scale, 3, 3);
    mesh_inertia mode = (mesh_inertia)mjcf_word(&e, "inertia", "legacy exact convex shell", MESH_LEGACY);
    const char *file = xml_text(mesh->node, "file");
    char *path = file ? mesh_path(m, file) : reader_text(r, "%s", "");
    if (mesh->place < 0 && path) mesh->place = geometry_mesh(r, mesh->node, mesh->name, path, scale);
    if (r->status != HAND_OK || mesh->place < 0) return false;
    bool has_hull = r->h->meshes[mesh->place].hull.vertex_count > 0;
    if ((!weighed || mesh->is_weighed) && (!collides || has_hull)) return true;
    if (file)
        geometry_read(r, mesh->node, path, &triangles);
    else
        read_written(r, mesh->node, &triangles);
    if (r->status != HAND_OK) return false;
    transform(&e, scale, &triangles);
    if (!file && !xml_text(mesh->node, "face")) mode = MESH_CONVEX;
    if (weighed && !mesh->is_weighed)
        mesh->is_weighed = geometry_mesh_mass(r, mesh->node, &triangles, mode, &mesh->mass);
    if (collides) geometry_hull(r, mesh->node, mesh->place, &triangles);
    mesh_free(&triangles);
    return r->status == HAND_OK;
}
