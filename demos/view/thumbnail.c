/* Small drawings of runs. */
#include "thumbnail.h"

#include "common/vector.h"
#include "look.h"
#include "scenes/shape/shape.h"

#include <stdlib.h>

enum { SIDE = 240, DIRECTIONS = 48 };

/* The world as the viewer sees it: to the right, upwards, and towards the eye. All are unit vectors. */
typedef struct camera {
    double right[3], up[3], eye[3];
    double centre[3], size; /* m: half of the drawing's width */
} camera;

static camera camera_of(const film *f, size_t frame)
{
    const bool flat = f->scene->dimension == 2;
    /* dimension 2 lies in the plane of x and y */
    camera c = {.right = {flat ? 1 : 0.8, flat ? 0 : 0.6, 0},
                .eye = {flat ? 0 : 0.48, flat ? 0 : -0.64, flat ? 1 : 0.6}};
    scene_cross(c.eye, c.right, c.up);
    c.size = 2.6 * f->scene->objects[0].shape.bounding_radius;
    scene_copy(film_pose(f, frame, 0), c.centre);
    return c;
}

static void project(const camera *c, const double point[3], double place[2])
{
    double from[3];
    scene_subtract(point, c->centre, from);
    place[0] = 0.5 * SIDE * (1 + scene_dot(from, c->right) / c->size);
    place[1] = 0.5 * SIDE * (1 - scene_dot(from, c->up) / c->size);
    for (int k = 0; k < 2; k++) place[k] = fmin(fmax(place[k], -SIDE), 2 * SIDE);
}

/* ---- Outlines. ---- */

/* A convex piece of a body. */
typedef struct piece {
    const film_body *body;
    const scene_shape *shape;
    size_t number; /* of a mesh */
    double pose[7];
    double depth; /* towards the eye, m */
} piece;

static void farthest(const piece *p, const double direction[3], double point[3])
{
    double local[3], found[3];
    scene_rotate_back(p->pose + 3, direction, local);
    if (p->shape->type == SCENE_MESH) {
        const scene_hull *hull = &p->shape->pieces[p->number];
        size_t best = 0;
        for (size_t i = 1; i < hull->vertex_count; i++)
            if (scene_dot(hull->vertices + 3 * i, local) > scene_dot(hull->vertices + 3 * best, local)) best = i;
        scene_copy(hull->vertices + 3 * best, found);
    } else {
        scene_shape_support(p->shape, local, found);
    }
    scene_rotate(p->pose + 3, found, point);
    scene_add_scaled(point, 1.0, p->pose);
}

/* The points that lie farthest along directions all around. The directions are turned slightly out of the picture's
 * plane, so that edges seen end on give a corner. */
static void write_outline(const camera *c, const piece *p, FILE *stream)
{
    double last[2] = {-1e9, -1e9}, place[2];
    bool begun = false;
    fprintf(stream, "<path class=\"%s\" d=\"", look_colour_name(look_of_body(p->body->kind)));
    for (int k = 0; k < DIRECTIONS; k++) {
        double angle = 2 * SCENE_PI * (k + 0.3183) / DIRECTIONS, direction[3] = {1e-7, 2e-7, 3e-7}, point[3];
        scene_add_scaled(direction, cos(angle), c->right);
        scene_add_scaled(direction, sin(angle), c->up);
        scene_add_scaled(direction, 1 / scene_norm(direction) - 1, direction);
        farthest(p, direction, point);
        project(c, point, place);
        if (fabs(place[0] - last[0]) < 0.3 && fabs(place[1] - last[1]) < 0.3) continue;
        fprintf(stream, "%s%.1f %.1f", begun ? "L" : "M", place[0], place[1]);
        begun = true;
        last[0] = place[0];
        last[1] = place[1];
    }
    fputs("Z\"/>", stream);
}

static void place_part(const film_part *part, const double pose[7], double placed[7])
{
    scene_rotate(pose + 3, part->pose, placed);
    scene_add_scaled(placed, 1.0, pose);
    scene_quaternion_product(pose + 3, part->pose + 3, placed + 3);
}

static int from_back_to_front(const void *a, const void *b)
{
    double x = ((const piece *)a)->depth, y = ((const piece *)b)->depth;
    return (x > y) - (x < y);
}

static size_t list_pieces(const film *f, size_t frame, const camera *c, piece *list)
{
    size_t count = 0;
    for (int b = 0; b < f->body_count; b++)
        for (int k = 0; k < f->bodies[b].part_count; k++) {
            const film_part *part = &f->bodies[b].parts[k];
            size_t pieces = part->shape.type == SCENE_MESH ? part->shape.piece_count : 1;
            for (size_t n = 0; n < pieces; n++, count++) {
                if (!list) continue;
                piece *p = &list[count];
                *p = (piece){.body = &f->bodies[b], .shape = &part->shape, .number = n};
                place_part(part, film_pose(f, frame, b), p->pose);
                p->depth = scene_dot(p->pose, c->eye);
            }
        }
    return count;
}

/* ---- Forces. ---- */

static void write_arrow(const camera *c, const double at[3], const double force[3], double scale, FILE *stream)
{
    double tail[3], from[2], to[2];
    scene_copy(at, tail);
    scene_add_scaled(tail, -scale, force);
    project(c, tail, from);
    project(c, at, to);
    double length = hypot(to[0] - from[0], to[1] - from[1]);
    if (!(length >= 2)) return;
    double along[2] = {(to[0] - from[0]) / length, (to[1] - from[1]) / length}, head = fmin(8, 0.5 * length);
    fprintf(stream, "<path class=\"arrow\" d=\"M%.1f %.1fL%.1f %.1fM%.1f %.1fL%.1f %.1fL%.1f %.1f\"/>", from[0],
            from[1], to[0], to[1], to[0] - head * (along[0] - 0.4 * along[1]),
            to[1] - head * (along[1] + 0.4 * along[0]), to[0], to[1], to[0] - head * (along[0] + 0.4 * along[1]),
            to[1] - head * (along[1] - 0.4 * along[0]));
}

static void write_forces(const film *f, const camera *c, const film_frame *frame, FILE *stream)
{
    double largest = 0.0;
    for (int k = 0; k < frame->contact_count; k++)
        largest = fmax(largest, scene_norm(f->contacts[frame->first_contact + (size_t)k].force));
    for (int k = 0; k < frame->contact_count; k++) {
        const film_contact *contact = &f->contacts[frame->first_contact + (size_t)k];
        if (f->bodies[f->pairs[contact->pair].bodies[0]].kind == FILM_OBJECT)
            write_arrow(c, contact->position, contact->force, 0.5 * c->size / largest, stream);
    }
}

void thumbnail_write(const film *f, size_t frame, FILE *stream)
{
    camera c = camera_of(f, frame);
    size_t count = list_pieces(f, frame, &c, NULL);
    piece *list = calloc(count + 1, sizeof *list);
    if (!list) return;
    list_pieces(f, frame, &c, list);
    qsort(list, count, sizeof *list, from_back_to_front);
    fprintf(stream, "<svg viewBox=\"0 0 %d %d\" aria-hidden=\"true\">", SIDE, SIDE);
    for (size_t i = 0; i < count; i++) write_outline(&c, &list[i], stream);
    write_forces(f, &c, &f->frames[frame], stream);
    fputs("</svg>", stream);
    free(list);
}

size_t thumbnail_last_touch(const film *f)
{
    for (size_t i = f->frame_count; i-- > 1;)
        for (int k = 0; k < f->frames[i].contact_count; k++) {
            int pair = f->contacts[f->frames[i].first_contact + (size_t)k].pair;
            if (f->pairs[pair].bodies[0] == 0) return i;
        }
    return f->frame_count - 1;
}
