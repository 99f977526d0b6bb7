#include "gltf.h"

#include "common/vector.h"
#include "look.h"
#include "triangles.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

/* The numbers that glTF has for component types, buffer targets and primitives. */
enum { GLTF_FLOAT = 5126, GLTF_UNSIGNED_INT = 5125, GLTF_VERTICES = 34962, GLTF_INDICES = 34963 };

typedef struct document {
    const film *film;
    json_t *nodes, *meshes, *materials, *accessors, *views, *channels, *samplers;
    unsigned char *bytes; /* the binary chunk */
    size_t size, room;
    size_t frame_count; /* that are animated */
    size_t *frames;     /* their numbers */
    json_int_t times;   /* the accessor of their times */
    json_int_t colours[LOOK_COLOUR_COUNT],
        cones[LOOK_COLOUR_COUNT]; /* 1 + the number of a material; of a cone's mesh */
    json_int_t cone_stored[3];    /* the cone's accessors */
    triangles cone;
    float *values; /* room for a track: frame_count x 4 */
    bool failed;
} document;

/* ---- Bytes and accessors. ---- */

static json_int_t add_bytes(document *d, const void *bytes, size_t size, int target)
{
    if (d->size + size > d->room || !d->bytes) {
        size_t room = 2 * (d->size + size) + 4096;
        unsigned char *larger = realloc(d->bytes, room);
        if (!larger) {
            d->failed = true;
            return 0;
        }
        d->bytes = larger;
        d->room = room;
    }
    memcpy(d->bytes + d->size, bytes, size);
    json_t *view =
        json_pack("{s:i, s:I, s:I}", "buffer", 0, "byteOffset", (json_int_t)d->size, "byteLength", (json_int_t)size);
    if (target) json_object_set_new(view, "target", json_integer(target));
    json_array_append_new(d->views, view);
    d->size += size;
    return (json_int_t)json_array_size(d->views) - 1;
}

/* The smallest or largest of every component, as the floats that are stored. */
static json_t *bounds(const float *values, size_t count, int width, bool largest)
{
    json_t *list = json_array();
    for (int i = 0; i < width; i++) {
        float bound = values[i];
        for (size_t k = 1; k < count; k++) {
            float v = values[k * (size_t)width + (size_t)i];
            if (largest ? v > bound : v < bound) bound = v;
        }
        json_array_append_new(list, json_real(bound));
    }
    return list;
}

static json_int_t add_floats(document *d, const float *values, size_t count, int width, int target, bool bounded)
{
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    json_int_t view = add_bytes(d, values, count * (size_t)width * sizeof *values, target);
    json_t *accessor = json_pack("{s:I, s:i, s:I, s:s}", "bufferView", view, "componentType", GLTF_FLOAT, "count",
                                 (json_int_t)count, "type", types[width]);
    if (bounded) {
        json_object_set_new(accessor, "min", bounds(values, count, width, false));
        json_object_set_new(accessor, "max", bounds(values, count, width, true));
    }
    json_array_append_new(d->accessors, accessor);
    return (json_int_t)json_array_size(d->accessors) - 1;
}

/* ---- Materials and meshes. ---- */

/* glTF has linear colours. */
static double linear(const char *code, int channel)
{
    unsigned value = 0;
    (void)sscanf(code + 1 + 2 * channel, "%2x", &value);
    double c = value / 255.0;
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

/* The number of a colour's material, which is added where it is used first. */
static json_int_t material(document *d, look_colour colour)
{
    if (d->colours[colour] > 0) return d->colours[colour] - 1;
    const char *code = look_colour_code(colour);
    bool cone = colour >= LOOK_STICK, through = cone || colour == LOOK_OBJECT || colour == LOOK_ENVIRONMENT;
    json_t *added =
        json_pack("{s:s, s:{s:[f, f, f, f], s:f, s:f}}", "name", look_colour_name(colour), "pbrMetallicRoughness",
                  "baseColorFactor", linear(code, 0), linear(code, 1), linear(code, 2),
                  cone      ? 0.35
                  : through ? 0.6
                            : 1.0,
                  "metallicFactor", 0.0, "roughnessFactor", 0.6);
    if (through) json_object_set_new(added, "alphaMode", json_string("BLEND"));
    if (cone) json_object_set_new(added, "doubleSided", json_true());
    json_array_append_new(d->materials, added);
    d->colours[colour] = (json_int_t)json_array_size(d->materials);
    return d->colours[colour] - 1;
}

/* Adds a mesh. Its accessors may be shared: *positions is -1 where the triangles are to be stored. */
static json_int_t add_mesh(document *d, const char *name, const triangles *t, look_colour colour, json_int_t shared[3])
{
    if (shared[0] < 0) {
        shared[0] = add_floats(d, t->positions, t->vertex_count, 3, GLTF_VERTICES, true);
        shared[1] = add_floats(d, t->normals, t->vertex_count, 3, GLTF_VERTICES, false);
        json_int_t view = add_bytes(d, t->indices, t->index_count * sizeof *t->indices, GLTF_INDICES);
        json_array_append_new(d->accessors,
                              json_pack("{s:I, s:i, s:I, s:s}", "bufferView", view, "componentType", GLTF_UNSIGNED_INT,
                                        "count", (json_int_t)t->index_count, "type", "SCALAR"));
        shared[2] = (json_int_t)json_array_size(d->accessors) - 1;
    }
    json_array_append_new(d->meshes, json_pack("{s:s, s:[{s:{s:I, s:I}, s:I, s:I}]}", "name", name, "primitives",
                                               "attributes", "POSITION", shared[0], "NORMAL", shared[1], "indices",
                                               shared[2], "material", material(d, colour)));
    return (json_int_t)json_array_size(d->meshes) - 1;
}

/* ---- Nodes and what moves them. ---- */

static json_int_t add_node(document *d, const char *name, json_t *children)
{
    json_t *node = json_pack("{s:s}", "name", name);
    json_array_append_new(d->nodes, node);
    json_int_t number = (json_int_t)json_array_size(d->nodes) - 1;
    if (children) json_array_append_new(children, json_integer(number));
    return number;
}

static json_t *node_at(const document *d, json_int_t node)
{
    return json_array_get(d->nodes, (size_t)node);
}

/* Moves a property of a node by the values of d->values. What never changes is no animation. */
static void add_track(document *d, json_int_t node, const char *property, int width, const char *interpolation)
{
    bool moves = false;
    size_t row = (size_t)width;
    for (size_t k = 1; k < d->frame_count && !moves; k++)
        moves = memcmp(d->values, d->values + k * row, row * sizeof *d->values) != 0;
    if (!moves) {
        json_t *value = json_array();
        for (int i = 0; i < width; i++) json_array_append_new(value, json_real(d->values[i]));
        json_object_set_new(node_at(d, node), property, value);
        return;
    }
    json_int_t output = add_floats(d, d->values, d->frame_count, width, 0, false);
    json_array_append_new(
        d->samplers, json_pack("{s:I, s:s, s:I}", "input", d->times, "interpolation", interpolation, "output", output));
    json_array_append_new(d->channels,
                          json_pack("{s:i, s:{s:I, s:s}}", "sampler", (int)json_array_size(d->samplers) - 1, "target",
                                    "node", node, "path", property));
}

/* A quaternion (w, x, y, z) as glTF has it (x, y, z, w), on the side of the one before, so that what lies between two
 * frames is the short way. It has unit length to a float's rounding. */
static void put_turn(document *d, size_t k, const double q[4])
{
    double along = 0, length = hypot(hypot(q[0], q[1]), hypot(q[2], q[3]));
    float *to = d->values + 4 * k;
    for (int i = 0; i < 4; i++) {
        to[i] = (float)(q[(i + 1) % 4] / length);
        if (k > 0) along += (double)to[i] * (double)to[i - 4];
    }
    for (int i = 0; i < 4 && along < 0; i++) to[i] = -to[i];
}

static void put_vector(document *d, size_t k, const double v[3])
{
    for (int i = 0; i < 3; i++) d->values[3 * k + (size_t)i] = (float)v[i];
}

/* The smallest turn from +y to a direction of any length. */
static void turn_from_y(const double direction[3], double q[4])
{
    double length = scene_norm(direction), along = direction[1] / length;
    if (along < -1 + 1e-12) {
        memcpy(q, (double[4]){0, 1, 0, 0}, 4 * sizeof *q);
        return;
    }
    double sum[4] = {1 + along, direction[2] / length, 0, -direction[0] / length};
    double size = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[3] * sum[3]);
    for (int i = 0; i < 4; i++) q[i] = sum[i] / size;
}

/* ---- Bodies. ---- */

static void add_body(document *d, int b, json_t *children)
{
    const film_body *body = &d->film->bodies[b];
    triangles t = {.positions = NULL};
    json_int_t stored[3] = {-1, -1, -1}, node = add_node(d, body->name, children);
    for (int p = 0; p < body->part_count && !d->failed; p++)
        d->failed = !triangles_add_shape(&t, &body->parts[p].shape, body->parts[p].pose);
    if (d->failed || t.index_count == 0) {
        triangles_free(&t);
        return;
    }
    json_int_t mesh = add_mesh(d, body->name, &t, look_of_body(body->kind), stored);
    json_object_set_new(node_at(d, node), "mesh", json_integer(mesh));
    json_object_set_new(node_at(d, node), "extras",
                        json_pack("{s:s}", "kind", look_colour_name(look_of_body(body->kind))));
    for (size_t k = 0; k < d->frame_count; k++) put_vector(d, k, film_pose(d->film, d->frames[k], b));
    add_track(d, node, "translation", 3, "LINEAR");
    for (size_t k = 0; k < d->frame_count; k++) put_turn(d, k, film_pose(d->film, d->frames[k], b) + 3);
    add_track(d, node, "rotation", 4, "LINEAR");
    triangles_free(&t);
}

/* ---- Contacts. ---- */

/* Where a contact point is looked for: its pair and place. */
typedef struct point {
    int pair, place;
    const char *name;
} point;

static const film_contact *contact_at(const document *d, const point *p, size_t k)
{
    return film_contact_at(d->film, d->frames[k], p->pair, p->place);
}

/* A point that does not touch keeps what it had when it last did, or will have when it first does. */
static const film_contact *known_contact(const document *d, const point *p, size_t k, const film_contact *before)
{
    const film_contact *c = contact_at(d, p, k);
    if (!c) c = before;
    for (size_t later = k + 1; !c && later < d->frame_count; later++) c = contact_at(d, p, later);
    return c;
}

static void add_arrow(document *d, const point *p, json_int_t mesh, json_t *children)
{
    json_int_t node = add_node(d, "force", children);
    json_object_set_new(node_at(d, node), "mesh", json_integer(mesh));
    double scale = look_arrow_length(d->film) / d->film->largest_force, q[4];
    const film_contact *c = NULL;
    for (size_t k = 0; k < d->frame_count; k++) {
        c = known_contact(d, p, k, c);
        turn_from_y(c->force, q);
        put_turn(d, k, q);
    }
    add_track(d, node, "rotation", 4, "LINEAR");
    for (size_t k = 0; k < d->frame_count; k++) {
        c = contact_at(d, p, k);
        double size = c ? scale * scene_norm(c->force) : 0;
        put_vector(d, k, (double[3]){size, size, size});
    }
    add_track(d, node, "scale", 3, "LINEAR");
}

/* The colour that the point's cone has in a frame; LOOK_COLOUR_COUNT before it has ever touched. */
static look_colour cone_colour(const document *d, const point *p, size_t k, bool touched)
{
    const film_contact *c = contact_at(d, p, k);
    return c ? look_of_state(c->state) : touched ? LOOK_OPEN : LOOK_COLOUR_COUNT;
}

/* The mesh of a cone, which is added where its colour occurs first. */
static json_int_t cone_mesh(document *d, look_colour colour)
{
    if (d->cones[colour] == 0)
        d->cones[colour] = 1 + add_mesh(d, look_colour_name(colour), &d->cone, colour, d->cone_stored);
    return d->cones[colour] - 1;
}

/* A cone of each colour that occurs, of which one at a time has a size. */
static void add_cones(document *d, const point *p, double friction, json_t *children)
{
    double height = look_cone_height(d->film), width = height * look_cone_width(friction);
    for (int colour = LOOK_STICK; colour < LOOK_COLOUR_COUNT; colour++) {
        bool touched = false, occurs = false;
        for (size_t k = 0; k < d->frame_count; k++) {
            touched = touched || contact_at(d, p, k);
            bool shown = cone_colour(d, p, k, touched) == (look_colour)colour;
            occurs = occurs || shown;
            put_vector(d, k, (double[3]){shown ? width : 0, shown ? height : 0, shown ? width : 0});
        }
        if (!occurs) continue;
        json_int_t node = add_node(d, look_colour_name((look_colour)colour), children);
        json_object_set_new(node_at(d, node), "mesh", json_integer(cone_mesh(d, (look_colour)colour)));
        add_track(d, node, "scale", 3, "STEP");
    }
}

static void add_point(document *d, const point *p, json_int_t arrow, json_t *children)
{
    const film_contact *c = known_contact(d, p, 0, NULL);
    if (!c) return;
    double friction = c->friction, q[4];
    json_t *of_contact = json_array();
    json_int_t contact = add_node(d, p->name, children);
    for (size_t k = 0; k < d->frame_count; k++) {
        c = known_contact(d, p, k, k ? c : NULL);
        put_vector(d, k, c->position);
    }
    add_track(d, contact, "translation", 3, "LINEAR");
    add_arrow(d, p, arrow, of_contact);
    if (friction > 0) {
        json_t *of_frame = json_array();
        json_int_t frame = add_node(d, "cone", of_contact);
        c = NULL;
        for (size_t k = 0; k < d->frame_count; k++) {
            c = known_contact(d, p, k, c);
            turn_from_y(c->normal, q);
            put_turn(d, k, q);
        }
        add_track(d, frame, "rotation", 4, "LINEAR");
        add_cones(d, p, friction, of_frame);
        json_object_set_new(node_at(d, frame), "children", of_frame);
    }
    json_object_set_new(node_at(d, contact), "children", of_contact);
}

static void add_contacts(document *d, json_t *children)
{
    const film *f = d->film;
    triangles arrow = {.positions = NULL};
    json_int_t stored[3] = {-1, -1, -1};
    if (f->pair_count == 0) return;
    d->cone_stored[0] = -1;
    d->failed = d->failed || !triangles_add_arrow(&arrow, 0.025, 0.2, 0.06) || !triangles_add_cone(&d->cone);
    json_int_t arrow_mesh = d->failed ? 0 : add_mesh(d, "force", &arrow, LOOK_FORCE, stored);
    for (int pair = 0; pair < f->pair_count && !d->failed; pair++)
        for (int place = 0; place < f->pairs[pair].places; place++) {
            char name[256];
            snprintf(name, sizeof name, "%.100s on %.100s, contact %d", f->bodies[f->pairs[pair].bodies[1]].name,
                     f->bodies[f->pairs[pair].bodies[0]].name, place + 1);
            add_point(d, &(point){pair, place, name}, arrow_mesh, children);
        }
    triangles_free(&arrow);
    triangles_free(&d->cone);
}

/* ---- The whole. ---- */

/* An animation's times are floats, each larger than the one before. */
static bool choose_frames(document *d)
{
    const film *f = d->film;
    d->frames = calloc(f->frame_count, sizeof *d->frames);
    d->values = calloc(f->frame_count, 4 * sizeof *d->values);
    if (!d->frames || !d->values) return false;
    for (size_t k = 0; k < f->frame_count; k++) {
        float now = (float)f->frames[k].time;
        if (d->frame_count > 0 && !(now > d->values[d->frame_count - 1])) continue;
        d->frames[d->frame_count] = k;
        d->values[d->frame_count++] = now;
    }
    if (d->frame_count > 1) d->times = add_floats(d, d->values, d->frame_count, 1, 0, true);
    return true;
}

/* The format has no lists without items, and no buffer without bytes: of a hand that has no shapes. */
static void leave_out_empty(json_t *all, bool no_bytes)
{
    static const char *const lists[] = {"meshes", "materials", "accessors", "bufferViews"};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        if (json_array_size(json_object_get(all, lists[i])) == 0) json_object_del(all, lists[i]);
    if (no_bytes) json_object_del(all, "buffers");
}

static json_t *whole_document(document *d)
{
    const film *f = d->film;
    json_t *children = json_array();
    json_int_t root = add_node(d, f->scene->name, NULL);
    for (int b = 0; b < f->body_count; b++) add_body(d, b, children);
    add_contacts(d, children);
    if (f->scene->dimension == 3)
        json_object_set_new(node_at(d, root), "rotation",
                            json_pack("[f, f, f, f]", -0.70710678118654752, 0.0, 0.0, 0.70710678118654752));
    json_object_set_new(node_at(d, root), "children", children);
    json_object_set_new(node_at(d, root), "extras",
                        json_pack("{s:s, s:f, s:f}", "contact_solver", world_solver_name(f->solver), "largest_force",
                                  f->largest_force, "longest_arrow", look_arrow_length(f)));
    json_t *all =
        json_pack("{s:{s:s, s:s}, s:i, s:[{s:s, s:[I]}], s:O, s:O, s:O, s:O, s:O, s:[{s:I}]}", "asset", "version",
                  "2.0", "generator", "pinch", "scene", 0, "scenes", "name", f->scene->name, "nodes", root, "nodes",
                  d->nodes, "meshes", d->meshes, "materials", d->materials, "accessors", d->accessors, "bufferViews",
                  d->views, "buffers", "byteLength", (json_int_t)d->size);
    if (json_array_size(d->channels) > 0)
        json_object_set_new(
            all, "animations",
            json_pack("[{s:s, s:O, s:O}]", "name", "run", "channels", d->channels, "samplers", d->samplers));
    leave_out_empty(all, d->size == 0);
    return all;
}

static void put_word(uint32_t word, FILE *stream)
{
    for (int i = 0; i < 4; i++) fputc((int)(word >> (8 * i) & 255u), stream);
}

/* The file: a header, the JSON chunk, and the binary chunk, if there is any, each filled up to a multiple of four
 * bytes.
 */
static bool write_chunks(const document *d, const char *text, FILE *stream)
{
    size_t length = strlen(text), json_pad = (4 - length % 4) % 4, bytes_pad = (4 - d->size % 4) % 4;
    size_t total = 12 + 8 + length + json_pad + (d->size > 0 ? 8 + d->size + bytes_pad : 0);
    if (total > UINT32_MAX) return false;
    put_word(0x46546c67u, stream);
    put_word(2, stream);
    put_word((uint32_t)total, stream);
    put_word((uint32_t)(length + json_pad), stream);
    put_word(0x4e4f534au, stream);
    fwrite(text, 1, length, stream);
    for (size_t i = 0; i < json_pad; i++) fputc(' ', stream);
    if (d->size == 0) return true;
    put_word((uint32_t)(d->size + bytes_pad), stream);
    put_word(0x004e4942u, stream);
    fwrite(d->bytes, 1, d->size, stream);
    for (size_t i = 0; i < bytes_pad; i++) fputc(0, stream);
    return true;
}

bool gltf_write(const film *f, FILE *stream)
{
    document d = {.film = f,
                  .nodes = json_array(),
                  .meshes = json_array(),
                  .materials = json_array(),
                  .accessors = json_array(),
                  .views = json_array(),
                  .channels = json_array(),
                  .samplers = json_array()};
    bool done = choose_frames(&d);
    json_t *all = done ? whole_document(&d) : NULL;
    char *text = all && !d.failed ? json_dumps(all, JSON_COMPACT) : NULL;
    done = text && write_chunks(&d, text, stream);
    free(text);
    json_decref(all);
    json_t *const lists[] = {d.nodes, d.meshes, d.materials, d.accessors, d.views, d.channels, d.samplers};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) json_decref(lists[i]);
    free(d.bytes);
    free(d.frames);
    free(d.values);
    return done;
}
