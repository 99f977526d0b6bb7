#include "film.h"

#include "common/vector.h"
#include "scenes/world/world_hand.h"

#include <stdlib.h>
#include <string.h>

static bool grow(void **list, size_t *room, size_t needed, size_t size)
{
    if (needed <= *room) return true;
    size_t more = 2 * needed + 16;
    void *larger = realloc(*list, more * size);
    if (!larger) return false;
    *list = larger;
    *room = more;
    return true;
}

/* ---- The bodies. ---- */

static const double IN_PLACE[7] = {0, 0, 0, 1, 0, 0, 0};

static bool add_part(film_body *body, const scene_shape *shape, dGeomID geom)
{
    film_part *parts = realloc(body->parts, ((size_t)body->part_count + 1) * sizeof *parts);
    if (!parts) return false;
    body->parts = parts;
    parts[body->part_count] = (film_part){.shape = *shape, .geom = geom};
    memcpy(parts[body->part_count++].pose, IN_PLACE, sizeof IN_PLACE);
    return true;
}

static bool add_body(film *f, film_body body, const scene_shape *shape, dGeomID geom)
{
    if (!add_part(&body, shape, geom)) return false;
    f->bodies[f->body_count++] = body;
    return true;
}

/* A link with all the geoms that it collides with. One that has none is not shown. */
static bool add_link(film *f, const world *w, int index, size_t link)
{
    const scene_hand *h = w->hands[index].hand;
    film_body body = {.name = h->links[link].name, .kind = FILM_FINGER};
    bool done = true;
    for (int i = 0; i < w->geom_count && done; i++) {
        const hand_geom *g = w->hand_geoms[i].geom;
        if (w->hand_geoms[i].hand != index + 1 || g->link != h->link_of[link]) continue;
        scene_shape shape = world_hand_shape(h->model, g);
        done = add_part(&body, &shape, w->geoms[i]);
        if (!done) break;
        double *pose = body.parts[body.part_count - 1].pose;
        body.body = dGeomGetBody(w->geoms[i]);
        memcpy(pose, dGeomGetOffsetPosition(w->geoms[i]), 3 * sizeof *pose);
        dGeomGetOffsetQuaternion(w->geoms[i], pose + 3);
    }
    if (body.part_count > 0)
        f->bodies[f->body_count++] = body; /* film_free takes its parts */
    else
        free(body.parts);
    return done;
}

static bool list_bodies(film *f, const world *w, bool hands_alone)
{
    const scene *s = w->scene;
    size_t links = 0;
    for (int h = 0; h < w->hand_count; h++) links += w->hands[h].hand->link_count;
    f->bodies =
        calloc((size_t)w->object_count + (size_t)w->finger_count + links + s->environment_count, sizeof *f->bodies);
    bool done = f->bodies != NULL;
    for (int i = 0; i < w->object_count && done && !hands_alone; i++) {
        film_body object = {.name = s->objects[i].name, .kind = FILM_OBJECT, .body = w->objects[i].body};
        done = add_body(f, object, &s->objects[i].shape, w->objects[i].geom);
    }
    for (int i = 0; i < w->finger_count && done; i++) {
        const world_finger *finger = &w->fingers[i];
        if (finger->hand) continue;
        film_body body = {.name = finger->finger->name, .kind = FILM_FINGER, .body = finger->body};
        done = add_body(f, body, &finger->finger->tip, finger->tip);
    }
    for (int h = 0; h < w->hand_count; h++)
        for (size_t l = 0; l < w->hands[h].hand->link_count && done; l++) done = add_link(f, w, h, l);
    for (int i = 0, k = 0; i < w->geom_count && done; i++) {
        if (w->categories[i] >= 0) continue;
        const scene_environment *e = &s->environment[k++];
        film_body body = {.name = e->name, .kind = FILM_ENVIRONMENT};
        memcpy(body.place, e->position, sizeof e->position);
        memcpy(body.place + 3, e->orientation, sizeof e->orientation);
        done = add_body(f, body, &e->shape, w->geoms[i]);
    }
    return done;
}

static bool name_fingers(film *f, const world *w)
{
    f->finger_names = calloc((size_t)w->finger_count + 1, sizeof *f->finger_names);
    for (int i = 0; i < w->finger_count && f->finger_names; i++) {
        const world_finger *finger = &w->fingers[i];
        if (w->object_count > 1)
            snprintf(f->finger_names[i], FILM_NAME, "%.90s on %.90s", finger->finger->name,
                     w->scene->objects[finger->object].name);
        else
            snprintf(f->finger_names[i], FILM_NAME, "%.190s", finger->finger->name);
    }
    return f->finger_names != NULL;
}

static int body_of(const film *f, dGeomID geom)
{
    for (int b = 0; b < f->body_count; b++)
        for (int p = 0; p < f->bodies[b].part_count; p++)
            if (f->bodies[b].parts[p].geom == geom) return b;
    return -1;
}

/* ---- The contacts of a frame. ---- */

/* The pair of two bodies, whose forces are shown on the first of them. -1 when memory runs out. */
static int pair_of(film *f, int first, int second)
{
    for (int p = 0; p < f->pair_count; p++)
        if (f->pairs[p].bodies[0] == first && f->pairs[p].bodies[1] == second) return p;
    if (!grow((void **)&f->pairs, &f->pair_room, (size_t)f->pair_count + 1, sizeof *f->pairs)) return -1;
    f->pairs[f->pair_count] = (film_pair){{first, second}, 0};
    return f->pair_count++;
}

/* Adds a contact of two geoms, given as it acts on the first one. Those that carry nothing are not shown. */
static bool add_contact(film *f, dGeomID geom1, dGeomID geom2, film_contact c)
{
    int first = body_of(f, geom1), second = body_of(f, geom2);
    if (first < 0 || second < 0 || !(c.normal_force > 0)) return true;
    if (f->bodies[second].kind < f->bodies[first].kind ||
        (f->bodies[second].kind == f->bodies[first].kind && second < first)) {
        int other = first;
        first = second;
        second = other;
        for (int i = 0; i < 3; i++) {
            c.normal[i] = -c.normal[i];
            c.force[i] = -c.force[i];
        }
    }
    c.pair = pair_of(f, first, second);
    if (c.pair < 0) return false;
    if (!grow((void **)&f->contacts, &f->contact_room, f->contact_count + 1, sizeof *f->contacts)) return false;
    film_frame *frame = &f->frames[f->frame_count - 1];
    for (int k = 0; k < frame->contact_count; k++)
        c.place += f->contacts[frame->first_contact + (size_t)k].pair == c.pair;
    if (c.place >= f->pairs[c.pair].places) f->pairs[c.pair].places = c.place + 1;
    f->largest_force = fmax(f->largest_force, scene_norm(c.force));
    f->contacts[f->contact_count++] = c;
    frame->contact_count++;
    return true;
}

static bool add_pinch_contacts(film *f, const world *w)
{
    const pinch_ode_contact *list;
    int count;
    if (pinch_ode_contacts(w->plugin, &list, &count) != PINCH_OK) return true;
    for (int k = 0; k < count; k++) {
        const pinch_ode_contact *from = &list[k];
        film_contact c = {.state = from->state, .normal_force = from->normal_force, .margin = NAN};
        if (from->normal_force > 0) c.friction = from->friction_limit / from->normal_force;
        if (from->friction_limit > 0) c.margin = 1 - scene_norm(from->tangential) / from->friction_limit;
        scene_copy(from->position, c.position);
        scene_copy(from->normal, c.normal);
        scene_copy(from->force, c.force);
        if (!add_contact(f, from->geom1, from->geom2, c)) return false;
    }
    return true;
}

/* ODE's solvers do not say whether a contact slips. One at the edge of ODE's friction box does, to rounding. */
static bool add_ode_contacts(film *f, const world *w)
{
    static const double AT_LIMIT = 1e-6;
    for (int k = 0; k < w->contact_count; k++) {
        const world_contact *from = &w->contacts[k];
        const dContactGeom *geom = &from->contact.geom;
        film_contact c = {.friction = from->contact.surface.mu, .margin = NAN};
        double tangential[3];
        for (int i = 0; i < 3; i++) {
            c.position[i] = geom->pos[i];
            c.normal[i] = geom->normal[i];
            /* Where the contact is attached as (0, body), ODE writes the force on the body into f1. */
            c.force[i] = (from->body[0] ? 1 : -1) * from->feedback.f1[i];
        }
        c.normal_force = scene_dot(c.force, c.normal);
        scene_copy(c.force, tangential);
        scene_add_scaled(tangential, -c.normal_force, c.normal);
        if (c.normal_force > 0 && c.friction > 0) c.margin = 1 - scene_norm(tangential) / (c.friction * c.normal_force);
        c.state = c.margin <= AT_LIMIT ? PINCH_CONTACT_SLIP : PINCH_CONTACT_STICK;
        if (!add_contact(f, geom->g1, geom->g2, c)) return false;
    }
    return true;
}

/* ---- Frames. ---- */

static bool frame_room(film *f)
{
    size_t needed = f->frame_count + 1, bodies = (size_t)f->body_count, fingers = (size_t)f->finger_count;
    size_t room[2] = {f->frame_room, f->frame_room};
    return grow((void **)&f->poses, &room[0], needed, 7 * bodies * sizeof *f->poses) &&
           grow((void **)&f->fingers, &room[1], needed, (fingers + 1) * sizeof *f->fingers) &&
           grow((void **)&f->frames, &f->frame_room, needed, sizeof *f->frames);
}

static bool take_frame(film *f, const world *w)
{
    if (!frame_room(f)) return false;
    double *pose = f->poses + f->frame_count * 7 * (size_t)f->body_count;
    film_finger *finger = f->fingers + f->frame_count * (size_t)f->finger_count;
    for (int b = 0; b < f->body_count; b++, pose += 7) {
        const film_body *body = &f->bodies[b];
        memcpy(pose, body->body ? dBodyGetPosition(body->body) : body->place, 3 * sizeof *pose);
        memcpy(pose + 3, body->body ? dBodyGetQuaternion(body->body) : body->place + 3, 4 * sizeof *pose);
    }
    for (int i = 0; i < f->finger_count; i++) {
        const world_finger_state *s = &w->fingers[i].state;
        finger[i] = (film_finger){.state = s->state,
                                  .normal_force = s->normal_force,
                                  .tangential_force = scene_norm(s->tangential_force),
                                  .margin = world_least_margin(w, &w->fingers[i]),
                                  .slip = s->slip_total};
        scene_copy(s->force, finger[i].force);
    }
    f->frames[f->frame_count++] = (film_frame){w->steps, w->time, f->contact_count, 0};
    return w->plugin ? add_pinch_contacts(f, w) : add_ode_contacts(f, w);
}

static bool start_extremes(film *f)
{
    f->extremes = calloc((size_t)f->finger_count + 1, sizeof *f->extremes);
    for (int i = 0; i < f->finger_count && f->extremes; i++) f->extremes[i] = (film_extremes){NAN, NAN, NAN, NAN, NAN};
    return f->extremes != NULL;
}

static void watch_extremes(film *f, const world *w)
{
    for (int i = 0; i < f->finger_count; i++) {
        film_extremes *e = &f->extremes[i];
        const world_finger_state *s = &w->fingers[i].state;
        double margin = world_least_margin(w, &w->fingers[i]);
        if (s->state == PINCH_CONTACT_SLIP && isnan(e->first_slip)) e->first_slip = w->time;
        if (!isnan(margin) && !(margin >= e->least_margin)) {
            e->least_margin = margin;
            e->least_margin_time = w->time;
        }
        if (s->normal_force > 0 && !(s->normal_force <= e->peak_force)) {
            e->peak_force = s->normal_force;
            e->peak_force_time = w->time;
        }
    }
}

static film *start(const world *w, double rate, bool hands_alone)
{
    film *f = calloc(1, sizeof *f);
    if (!f) return NULL;
    f->scene = w->scene;
    f->solver = w->settings.contact_solver;
    f->rate = rate;
    f->finger_count = w->finger_count;
    if (list_bodies(f, w, hands_alone) && name_fingers(f, w) && start_extremes(f) && take_frame(f, w)) return f;
    film_free(f);
    return NULL;
}

film *film_start(const world *w, double rate)
{
    return start(w, rate, false);
}

film *film_of_hands(const world *w)
{
    return start(w, 1, true);
}

/* The number of the picture that shows time t: pictures change half a step before the time at which they are due. */
static double picture_at(const film *f, double t)
{
    return floor((t + 0.5 * f->scene->step) * f->rate);
}

bool film_step(film *f, const world *w)
{
    const film_frame *last = &f->frames[f->frame_count - 1];
    watch_extremes(f, w);
    return picture_at(f, w->time) <= picture_at(f, last->time) || take_frame(f, w);
}

bool film_finish(film *f, const world *w)
{
    return f->frames[f->frame_count - 1].step == w->steps || take_frame(f, w);
}

void film_free(film *f)
{
    if (!f) return;
    for (int b = 0; b < f->body_count && f->bodies; b++) free(f->bodies[b].parts);
    free(f->bodies);
    free(f->pairs);
    free(f->frames);
    free(f->poses);
    free(f->fingers);
    free(f->extremes);
    free(f->finger_names);
    free(f->contacts);
    free(f);
}

const double *film_pose(const film *f, size_t frame, int body)
{
    return f->poses + 7 * (frame * (size_t)f->body_count + (size_t)body);
}

const film_contact *film_contact_at(const film *f, size_t frame, int pair, int place)
{
    const film_frame *at = &f->frames[frame];
    for (int k = 0; k < at->contact_count; k++) {
        const film_contact *c = &f->contacts[at->first_contact + (size_t)k];
        if (c->pair == pair && c->place == place) return c;
    }
    return NULL;
}
