#include "mesh_file.h"

#include "common/input_file.h"
#include "common/vector.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A mesh has thousands of triangles. */
static const size_t MAX_BYTES = (size_t)256 << 20;

/* No object that a hand holds has larger coordinates, and its volume would overflow. */
static const double MAX_COORDINATE = 1e6;

typedef struct source {
    char *text; /* with a 0 at the end */
    size_t length;
    char *at;
    int line;
    char *error;
    mesh_status status;
} source;

static bool refuse(source *s, const char *what)
{
    snprintf(s->error, 256, "line %d: expected %s", s->line, what);
    s->status = MESH_BAD;
    return false;
}

static bool no_memory(source *s)
{
    s->status = MESH_NO_MEMORY;
    return false;
}

static bool reserve(source *s, void **items, size_t *room, size_t count, size_t size)
{
    if (count <= *room) return true;
    size_t bigger = *room ? 2 * *room : 64;
    void *moved = realloc(*items, bigger * size);
    if (!moved) return no_memory(s);
    *items = moved;
    *room = bigger;
    return true;
}

static bool read_all(source *s, const char *path)
{
    char fault[128];
    FILE *stream = input_open_regular(path, fault);
    input_status status = *fault ? INPUT_REFUSED : INPUT_NO_MEMORY;
    if (stream) status = input_read(stream, MAX_BYTES, &s->text, &s->length, fault);
    if (status == INPUT_NO_MEMORY) return no_memory(s);
    if (status == INPUT_READ) return true;
    snprintf(s->error, 256, "expected a readable mesh file: %s", fault);
    s->status = MESH_BAD;
    return false;
}

/* The next line without its end; NULL after the last. A backslash at its end makes one line of it and the next. */
static char *next_line(source *s)
{
    if (s->at >= s->text + s->length) return NULL;
    char *line = s->at, *end;
    while ((end = strchr(s->at, '\n')) != NULL) {
        char *last = end > s->at && end[-1] == '\r' ? end - 1 : end;
        s->line++;
        if (last == s->at || last[-1] != '\\') break;
        memset(last - 1, ' ', (size_t)(end + 2 - last));
        s->at = end + 1;
    }
    if (!end) s->line++;
    s->at = end ? end + 1 : s->text + s->length;
    if (end) *end = '\0';
    size_t length = strlen(line);
    while (length > 0 && (line[length - 1] == '\r' || line[length - 1] == ' ' || line[length - 1] == '\t'))
        line[--length] = '\0';
    return line + strspn(line, " \t");
}

static bool read_point(source *s, const char *text, double x[3])
{
    for (int i = 0; i < 3; i++) {
        char *end;
        x[i] = strtod(text, &end);
        if (end == text || (*end && !strchr(" \t", *end)) || !(fabs(x[i]) < MAX_COORDINATE))
            return refuse(s, "three coordinates (m, below 1e6)");
        text = end;
    }
    return true;
}

/* Starts a piece. A piece without a triangle is dropped. */
static bool start_piece(source *s, mesh_file *mesh, const char *name)
{
    size_t last = mesh->piece_count;
    if (last > 0 && mesh->pieces[last - 1].count == 0) mesh->piece_count = --last;
    if (!reserve(s, (void **)&mesh->pieces, &mesh->piece_room, last + 1, sizeof *mesh->pieces)) return false;
    mesh_piece *piece = &mesh->pieces[mesh->piece_count++];
    memset(piece, 0, sizeof *piece);
    piece->first = mesh->triangle_count;
    snprintf(piece->name, sizeof piece->name, "%.60s", name);
    return true;
}

static bool add_triangle(source *s, mesh_file *mesh, const double *a, const double *b, const double *c)
{
    if (mesh->piece_count == 0 && !start_piece(s, mesh, "")) return false;
    if (!reserve(s, (void **)&mesh->corners, &mesh->triangle_room, mesh->triangle_count + 1, 9 * sizeof(double)))
        return false;
    double *x = mesh->corners + 9 * mesh->triangle_count++;
    scene_copy(a, x);
    scene_copy(b, x + 3);
    scene_copy(c, x + 6);
    mesh->pieces[mesh->piece_count - 1].count++;
    return true;
}

typedef struct points {
    double *x;
    size_t count, room;
} points;

/* Reads a face such as "f 1/2/3 4//5 -1" as a fan of triangles. Corners are numbered from 1, or from the end where
 * negative. Texture and normal are ignored. */
static bool read_face(source *s, mesh_file *mesh, const points *p, char *text)
{
    const double *corner[2] = {NULL, NULL}, *first = NULL;
    int count = 0;
    while (*(text += strspn(text, " \t"))) {
        char *end;
        long number = strtol(text, &end, 10);
        if (end == text || (*end && !strchr("/ \t", *end))) return refuse(s, "a face of corner numbers");
        size_t index = number > 0 ? (size_t)number - 1 : p->count + (size_t)number;
        if (number == 0 || index >= p->count) return refuse(s, "the number of a vertex that is there");
        const double *x = p->x + 3 * index;
        if (count >= 2 && !add_triangle(s, mesh, first, corner[1], x)) return false;
        if (count == 0) first = x;
        corner[0] = corner[1];
        corner[1] = x;
        count++;
        text = end + strcspn(end, " \t");
    }
    return count >= 3 || refuse(s, "a face of at least three corners");
}

static bool read_obj(source *s, mesh_file *mesh)
{
    points p = {NULL, 0, 0};
    bool good = true;
    for (char *line = next_line(s); line && good; line = good ? next_line(s) : NULL) {
        if (line[0] == 'v' && (line[1] == ' ' || line[1] == '\t')) {
            good = reserve(s, (void **)&p.x, &p.room, p.count + 1, 3 * sizeof(double)) &&
                   read_point(s, line + 1, p.x + 3 * p.count);
            p.count++;
        } else if (line[0] == 'f' && (line[1] == ' ' || line[1] == '\t')) {
            good = read_face(s, mesh, &p, line + 1);
        } else if ((line[0] == 'o' || line[0] == 'g') && (line[1] == ' ' || line[1] == '\0')) {
            good = start_piece(s, mesh, line[1] ? line + 2 : "");
        }
    }
    free(p.x);
    return good;
}

static bool read_text_stl(source *s, mesh_file *mesh)
{
    double x[9];
    int corners = 0;
    for (char *line = next_line(s); line; line = next_line(s)) {
        if (strncmp(line, "solid", 5) == 0) {
            if (!start_piece(s, mesh, line[5] ? line + 6 : "")) return false;
        } else if (strncmp(line, "vertex", 6) == 0) {
            if (corners == 3) return refuse(s, "three vertices in a facet");
            if (!read_point(s, line + 6, x + 3 * corners)) return false;
            corners++;
        } else if (strncmp(line, "endfacet", 8) == 0) {
            if (corners != 3) return refuse(s, "three vertices in a facet");
            corners = 0;
            if (!add_triangle(s, mesh, x, x + 3, x + 6)) return false;
        } else if (*line && strncmp(line, "facet", 5) != 0 && strncmp(line, "outer", 5) != 0 &&
                   strncmp(line, "end", 3) != 0) {
            return refuse(s, "a line of an STL file");
        }
    }
    return corners == 0 || refuse(s, "the end of the facet");
}

static uint32_t little_endian(const unsigned char *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* The format is 80 bytes of anything, the number of triangles, and 50 bytes for each: normal, three corners, two more
 * bytes. */
static bool read_binary_stl(source *s, mesh_file *mesh)
{
    const unsigned char *b = (const unsigned char *)s->text;
    size_t count = little_endian(b + 80);
    for (size_t t = 0; t < count; t++) {
        double x[9];
        for (int k = 0; k < 9; k++) {
            uint32_t bits = little_endian(b + 84 + 50 * t + 12 + 4 * (size_t)k);
            float value;
            memcpy(&value, &bits, sizeof value);
            x[k] = (double)value;
            if (!(fabs(x[k]) < MAX_COORDINATE)) {
                snprintf(s->error, 256, "triangle %zu: expected coordinates in m, below 1e6", t + 1);
                s->status = MESH_BAD;
                return false;
            }
        }
        if (!add_triangle(s, mesh, x, x + 3, x + 6)) return false;
    }
    return true;
}

static bool is_binary_stl(const source *s)
{
    return s->length >= 84 && s->length == 84 + 50 * (size_t)little_endian((const unsigned char *)s->text + 80);
}

/* A text would end at its first zero byte, and the rest would be lost in silence. */
static bool refuse_binary(source *s)
{
    for (const char *c = s->text; *c; c++) s->line += *c == '\n';
    s->line++;
    return refuse(s, "text, or an STL file whose length fits its number of triangles, but got a zero byte");
}

mesh_status mesh_read(const char *path, mesh_file *mesh, char *error)
{
    source s = {.error = error, .status = MESH_OK};
    memset(mesh, 0, sizeof *mesh);
    bool good = read_all(&s, path);
    if (good) {
        s.at = s.text;
        const char *start = s.text + strspn(s.text, " \t\r\n");
        if (is_binary_stl(&s))
            good = read_binary_stl(&s, mesh);
        else if (memchr(s.text, '\0', s.length))
            good = refuse_binary(&s);
        else
            good = strncmp(start, "solid", 5) == 0 ? read_text_stl(&s, mesh) : read_obj(&s, mesh);
    }
    if (good && mesh->piece_count > 0 && mesh->pieces[mesh->piece_count - 1].count == 0) mesh->piece_count--;
    if (good && mesh->piece_count == 0) {
        snprintf(error, 256, "expected an OBJ or STL file with triangles");
        s.status = MESH_BAD;
    }
    free(s.text);
    if (s.status != MESH_OK) mesh_free(mesh);
    return s.status;
}

void mesh_free(mesh_file *mesh)
{
    free(mesh->corners);
    free(mesh->pieces);
    memset(mesh, 0, sizeof *mesh);
}

void mesh_piece_measure(const mesh_file *mesh, const mesh_piece *piece, const double about[3], mesh_measure *m)
{
    *m = (mesh_measure){.area = 0};
    for (size_t t = piece->first; t < piece->first + piece->count; t++) {
        const double *corner = mesh->corners + 9 * t;
        double from[3], side[2][3], normal[3];
        scene_subtract(corner, about, from);
        for (int k = 0; k < 2; k++) scene_subtract(corner + 3 * (k + 1), corner, side[k]);
        scene_cross(side[0], side[1], normal);
        m->volume += scene_dot(from, normal) / 6;
        m->area += scene_norm(normal) / 2;
        scene_add_scaled(m->opening, 0.5, normal);
    }
}
