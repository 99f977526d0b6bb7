/* A film as the page reads it. All numbers are packed into one block: little-endian, each part at a multiple of four
 * bytes, compressed by zlib, as base64. */
#include "page.h"

#include "common/output.h"
#include "common/vector.h"
#include "look.h"
#include "triangles.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

typedef struct block {
    unsigned char *bytes;
    size_t size, room;
    bool failed;
} block;

/* Returns where the bytes are. */
static json_t *put(block *b, const void *bytes, size_t size)
{
    size_t at = b->size, padded = (size + 3) / 4 * 4;
    if (b->size + padded > b->room || !b->bytes) {
        size_t room = 2 * (b->size + padded) + 4096;
        unsigned char *larger = realloc(b->bytes, room);
        if (!larger) {
            b->failed = true;
            return json_null();
        }
        b->bytes = larger;
        b->room = room;
    }
    memset(b->bytes + b->size, 0, padded);
    if (size > 0) memcpy(b->bytes + b->size, bytes, size);
    b->size += padded;
    return json_integer((json_int_t)at);
}

static json_t *put_doubles(block *b, const double *values, size_t count)
{
    float *floats = malloc((count + 1) * sizeof *floats);
    if (!floats) {
        b->failed = true;
        return json_null();
    }
    for (size_t i = 0; i < count; i++) floats[i] = (float)values[i];
    json_t *at = put(b, floats, count * sizeof *floats);
    free(floats);
    return at;
}

static char *base64(const unsigned char *bytes, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char *text = malloc(4 * (size / 3 + 1) + 1), *to = text;
    if (!text) return NULL;
    for (size_t i = 0; i < size; i += 3) {
        size_t left = size - i;
        unsigned word = bytes[i] * 65536u + (left > 1 ? bytes[i + 1] * 256u : 0) + (left > 2 ? bytes[i + 2] : 0);
        for (int k = 0; k < 4; k++) *to++ = (size_t)k > left ? '=' : digits[word >> (18 - 6 * k) & 63u];
    }
    *to = '\0';
    return text;
}

static json_t *pack(const block *b)
{
    uLongf size = compressBound((uLong)b->size);
    unsigned char *packed = malloc(size);
    char *text = NULL;
    if (packed && compress2(packed, &size, b->bytes, (uLong)b->size, Z_BEST_COMPRESSION) == Z_OK)
        text = base64(packed, size);
    json_t *value = text ? json_string_nocheck(text) : NULL;
    free(text);
    free(packed);
    return value;
}

/* ---- Meshes. Bodies of one shape share one. ---- */

static json_t *put_mesh(block *b, const triangles *t)
{
    signed char *normals = calloc(t->vertex_count, 4);
    if (!normals) {
        b->failed = true;
        return json_null();
    }
    for (size_t k = 0; k < t->vertex_count; k++)
        for (size_t i = 0; i < 3; i++) normals[4 * k + i] = (signed char)lround(127 * (double)t->normals[3 * k + i]);
    json_t *mesh = json_pack(
        "{s:I, s:I, s:o, s:o, s:o}", "vertices", (json_int_t)t->vertex_count, "indices", (json_int_t)t->index_count,
        "positions_at", put(b, t->positions, 3 * t->vertex_count * sizeof *t->positions), "normals_at",
        put(b, normals, 4 * t->vertex_count), "indices_at", put(b, t->indices, t->index_count * sizeof *t->indices));
    free(normals);
    return mesh;
}

static bool same_mesh(const triangles *a, const triangles *b)
{
    return a->vertex_count == b->vertex_count && a->index_count == b->index_count &&
           memcmp(a->positions, b->positions, 3 * a->vertex_count * sizeof *a->positions) == 0 &&
           memcmp(a->indices, b->indices, a->index_count * sizeof *a->indices) == 0;
}

/* Fills `numbers` with the mesh of each body. */
static json_t *put_meshes(const film *f, block *b, int *numbers)
{
    json_t *list = json_array();
    triangles *made = calloc((size_t)f->body_count, sizeof *made);
    int count = 0;
    b->failed = b->failed || !made;
    for (int i = 0; i < f->body_count && !b->failed; i++) {
        triangles *t = &made[count];
        for (int p = 0; p < f->bodies[i].part_count && !b->failed; p++)
            b->failed = !triangles_add_shape(t, &f->bodies[i].parts[p].shape, f->bodies[i].parts[p].pose);
        for (numbers[i] = 0; numbers[i] < count && !same_mesh(&made[numbers[i]], t);) numbers[i]++;
        if (numbers[i] < count) {
            triangles_free(t);
            continue;
        }
        json_array_append_new(list, put_mesh(b, t));
        count++;
    }
    for (int i = 0; i < f->body_count && made; i++) triangles_free(&made[i]);
    free(made);
    return list;
}

/* ---- Bodies, fingers, contacts. ---- */

static bool moves(const film *f, int body)
{
    for (size_t k = 1; k < f->frame_count; k++)
        if (memcmp(film_pose(f, k, body), film_pose(f, 0, body), 7 * sizeof(double)) != 0) return true;
    return false;
}

/* A body's track: 7 numbers per frame; null where it stands still at its place. */
static json_t *put_track(const film *f, block *b, int body)
{
    if (!moves(f, body)) return json_null();
    double *track = malloc(7 * f->frame_count * sizeof *track);
    if (!track) {
        b->failed = true;
        return json_null();
    }
    for (size_t k = 0; k < f->frame_count; k++) memcpy(track + 7 * k, film_pose(f, k, body), 7 * sizeof *track);
    json_t *at = put_doubles(b, track, 7 * f->frame_count);
    free(track);
    return at;
}

static json_t *put_bodies(const film *f, block *b, const int *meshes)
{
    json_t *list = json_array();
    for (int i = 0; i < f->body_count; i++)
        json_array_append_new(list,
                              json_pack("{s:s, s:s, s:i, s:o, s:o}", "name", f->bodies[i].name, "kind",
                                        look_colour_name(look_of_body(f->bodies[i].kind)), "mesh", meshes[i], "place",
                                        json_numbers(film_pose(f, 0, i), 7), "track_at", put_track(f, b, i)));
    return list;
}

/* Numbers that the page shows as words: the places of "open", "stick", "slip", "yield". */
static double state_number(pinch_contact_state state)
{
    return state == PINCH_CONTACT_STICK ? 1 : state == PINCH_CONTACT_SLIP ? 2 : state == PINCH_CONTACT_YIELD ? 3 : 0;
}

static json_t *put_fingers(const film *f, block *b)
{
    json_t *list = json_array();
    double *series = malloc(6 * f->frame_count * sizeof *series);
    b->failed = b->failed || !series;
    for (int i = 0; i < f->finger_count && !b->failed; i++) {
        /* of a hand's many links, those that press */
        if ((size_t)i >= f->scene->finger_count && isnan(f->extremes[i].peak_force)) continue;
        for (size_t k = 0; k < f->frame_count; k++) {
            const film_finger *s = &f->fingers[k * (size_t)f->finger_count + (size_t)i];
            const double row[6] = {s->normal_force, s->tangential_force,  s->margin,
                                   s->slip,         scene_norm(s->force), state_number(s->state)};
            memcpy(series + 6 * k, row, sizeof row);
        }
        const film_extremes *e = &f->extremes[i];
        json_array_append_new(list, json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:o}", "name", f->finger_names[i],
                                              "series_at", put_doubles(b, series, 6 * f->frame_count), "first_slip",
                                              json_number(e->first_slip), "least_margin", json_number(e->least_margin),
                                              "least_margin_time", json_number(e->least_margin_time), "peak_force",
                                              json_number(e->peak_force), "peak_force_time",
                                              json_number(e->peak_force_time)));
    }
    free(series);
    return list;
}

static json_t *put_contacts(const film *f, block *b)
{
    uint32_t *firsts = malloc((f->frame_count + 1) * sizeof *firsts);
    double *rows = malloc((14 * f->contact_count + 1) * sizeof *rows);
    b->failed = b->failed || !firsts || !rows;
    json_t *contacts = NULL;
    if (!b->failed) {
        for (size_t k = 0; k < f->frame_count; k++) firsts[k] = (uint32_t)f->frames[k].first_contact;
        firsts[f->frame_count] = (uint32_t)f->contact_count;
        for (size_t k = 0; k < f->contact_count; k++) {
            const film_contact *c = &f->contacts[k];
            double *row = rows + 14 * k;
            row[0] = c->pair;
            row[1] = c->place;
            row[2] = state_number(c->state);
            scene_copy(c->position, row + 3);
            scene_copy(c->normal, row + 6);
            scene_copy(c->force, row + 9);
            row[12] = c->margin;
            row[13] = c->friction;
        }
        contacts = json_pack("{s:o, s:o}", "first_at", put(b, firsts, (f->frame_count + 1) * sizeof *firsts), "at",
                             put_doubles(b, rows, 14 * f->contact_count));
    }
    free(firsts);
    free(rows);
    return contacts ? contacts : json_null();
}

static json_t *put_times(const film *f, block *b)
{
    float *times = malloc(f->frame_count * sizeof *times);
    b->failed = b->failed || !times;
    for (size_t k = 0; k < f->frame_count && times; k++) times[k] = (float)f->frames[k].time;
    json_t *at = times ? put(b, times, f->frame_count * sizeof *times) : json_null();
    free(times);
    return at;
}

static bool yields(const film *f)
{
    for (size_t k = 0; k < f->contact_count; k++)
        if (f->contacts[k].state == PINCH_CONTACT_YIELD) return true;
    return false;
}

json_t *page_film(const film *f, bool meshes)
{
    block b = {.size = 0};
    int *numbers = calloc((size_t)f->body_count, sizeof *numbers);
    if (!numbers) return NULL;
    json_t *made = meshes ? put_meshes(f, &b, numbers) : json_array();
    json_t *description = json_pack(
        "{s:s, s:s, s:s, s:I, s:b, s:f, s:f, s:f, s:f, s:o, s:o, s:o, s:o, s:o}", "scene", f->scene->name, "solver",
        world_solver_name(f->solver), "up", f->scene->dimension == 2 ? "y" : "z", "frames", (json_int_t)f->frame_count,
        "yields", yields(f), "radius", f->scene->objects[0].shape.bounding_radius, "arrow", look_arrow_length(f),
        "cone", look_cone_height(f), "largest_force", f->largest_force, "time_at", put_times(f, &b), "meshes", made,
        "bodies", put_bodies(f, &b, numbers), "fingers", put_fingers(f, &b), "contacts", put_contacts(f, &b));
    json_t *data = b.failed ? NULL : pack(&b);
    if (!data || json_object_set_new(description, "data", data)) {
        json_decref(description);
        description = NULL;
    }
    free(numbers);
    free(b.bytes);
    return description;
}
