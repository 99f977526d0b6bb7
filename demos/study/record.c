/* What is recorded of a trial. */
#include "trial.h"

#include "common/output.h"
#include "common/vector.h"
#include "quality/grasp_quality.h"
#include "scenes/grasp.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_NAME = 512 };

/* What an element of a list is called. */
static void label_of(const json_t *element, size_t index, char label[MOST_NAME])
{
    const char *name = json_string_value(json_object_get(element, "name"));
    if (name)
        snprintf(label, MOST_NAME, "%s", name);
    else
        snprintf(label, MOST_NAME, "%zu", index);
}

static int take(const json_t *value, const char *rest, const char *so_far, json_t *into);

static int enter(const json_t *value, const char *label, const char *rest, const char *so_far, json_t *into)
{
    char name[MOST_NAME];
    int length = snprintf(name, sizeof name, "%s%s%s", so_far, *so_far ? "." : "", label);
    return length < MOST_NAME ? take(value, rest, name, into) : 0;
}

static int take(const json_t *value, const char *rest, const char *so_far, json_t *into)
{
    if (!*rest) return json_object_set(into, so_far, (json_t *)value) == 0;
    size_t length = strcspn(rest, ".");
    const char *next = rest[length] ? rest + length + 1 : rest + length;
    char label[MOST_NAME];
    int taken = 0;
    const char *key;
    json_t *member;
    json_object_foreach((json_t *)value, key, member)
    {
        if ((length == 1 && *rest == '*') || (strlen(key) == length && strncmp(key, rest, length) == 0))
            taken += enter(member, key, next, so_far, into);
    }
    for (size_t i = 0; i < json_array_size(value); i++) {
        label_of(json_array_get(value, i), i, label);
        if ((length == 1 && *rest == '*') || (strlen(label) == length && strncmp(label, rest, length) == 0))
            taken += enter(json_array_get(value, i), label, next, so_far, into);
    }
    return taken;
}

int record_take(const json_t *document, const char *name, json_t *into)
{
    return take(document, name, "", into);
}

bool record_is_static(const char *name)
{
    return strncmp(name, "grasp.", 6) == 0;
}

/* ---- The static grasp. ---- */

enum { FRICTION = 0, LOAD, CLOSING, EPSILON, EPSILON_UPPER, VOLUME, QUANTITIES };
static const char *const quantity_names[QUANTITIES] = {"grasp.smallest_friction", "grasp.largest_load_factor",
                                                       "grasp.least_closing",     "grasp.epsilon",
                                                       "grasp.epsilon_upper",     "grasp.volume"};

/* Which quantities the study records. Returns false where a name is none. */
static bool wanted_quantities(const study *s, bool wanted[QUANTITIES], bool *any)
{
    bool good = true;
    *any = false;
    for (int q = 0; q < QUANTITIES; q++) wanted[q] = false;
    for (size_t i = 0; i < s->record_count; i++) {
        if (!record_is_static(s->records[i])) continue;
        int q = 0;
        while (q < QUANTITIES && strcmp(s->records[i], quantity_names[q]) != 0) q++;
        if (q < QUANTITIES)
            wanted[q] = *any = true;
        else
            good = false;
    }
    return good;
}

static void find_reserves(const pinch_grasp *grasp, const bool wanted[QUANTITIES], double values[QUANTITIES])
{
    pinch_statics_settings settings = pinch_default_statics_settings();
    pinch_statics *statics;
    pinch_static_limits limits;
    pinch_static_limit closing;
    if (!(wanted[FRICTION] || wanted[LOAD] || wanted[CLOSING])) return;
    if (pinch_statics_create(grasp->finger_count, 0, &statics) != PINCH_OK) return;
    bool both = wanted[FRICTION] || wanted[LOAD];
    if (both && pinch_statics_limits(statics, grasp, &settings, &limits) == PINCH_OK) {
        values[FRICTION] = limits.smallest_friction.holds;
        values[LOAD] = limits.largest_load_factor.holds;
    }
    if (wanted[CLOSING] && pinch_statics_least_closing(statics, grasp, &settings, &closing) == PINCH_OK)
        values[CLOSING] = closing.holds;
    pinch_statics_destroy(statics);
}

/* The quality of the faces alone: a study ranks grasps, and the refinement would cost more than the run. */
static void find_quality(const pinch_grasp *grasp, const bool wanted[QUANTITIES], double values[QUANTITIES])
{
    grasp_quality q;
    grasp_quality_settings settings = grasp_quality_default_settings();
    settings.tolerance = INFINITY;
    if (!(wanted[EPSILON] || wanted[EPSILON_UPPER] || wanted[VOLUME])) return;
    if (grasp_quality_find(grasp, &settings, &q) != GRASP_QUALITY_FINE) return;
    values[EPSILON] = q.epsilon;
    values[EPSILON_UPPER] = q.epsilon_upper;
    values[VOLUME] = q.volume;
}

static void set_quantities(const bool wanted[QUANTITIES], const double values[QUANTITIES], json_t *into)
{
    for (int q = 0; q < QUANTITIES; q++)
        if (wanted[q]) json_object_set_new(into, quantity_names[q], json_number(values[q]));
}

bool record_grasp(const study *s, const scene *base, double time, json_t *into)
{
    bool wanted[QUANTITIES], any;
    double values[QUANTITIES];
    if (!wanted_quantities(s, wanted, &any)) return false;
    for (int q = 0; q < QUANTITIES; q++) values[q] = NAN;
    pinch_finger *fingers = any ? calloc(base->finger_count + 1, sizeof *fingers) : NULL;
    /* the statics know fingers at their points, and no hands */
    if (fingers && base->finger_count > 0 && base->hand_count == 0 && !scene_finger_on_path(base, time)) {
        pinch_grasp grasp;
        scene_static_grasp_at(base, time, fingers, &grasp);
        find_reserves(&grasp, wanted, values);
        find_quality(&grasp, wanted, values);
    }
    free(fingers);
    set_quantities(wanted, values, into);
    return true;
}

/* ---- The grasp as a run finds it. ---- */

static pinch_finger finger_at(const pinch_ode_contact *c, double sign, const double centre[3])
{
    pinch_finger f = {.model = PINCH_CONTACT_HARD, .max_force = INFINITY};
    if (c->torsion_limit > 0.0) f.model = PINCH_CONTACT_SOFT;
    if (!(c->friction_limit > 0.0)) f.model = PINCH_CONTACT_FRICTIONLESS;
    scene_subtract(c->position, centre, f.point);
    int least = 0;
    for (int i = 0; i < 3; i++) {
        f.normal[i] = sign * c->normal[i];
        f.stiffness[i] = c->stiffness[i];
        if (fabs(f.normal[i]) < fabs(f.normal[least])) least = i;
    }
    f.tangent1[least] = 1.0;
    scene_add_scaled(f.tangent1, -f.normal[least], f.normal);
    double size = scene_norm(f.tangent1);
    for (int i = 0; i < 3; i++) f.tangent1[i] /= size;
    f.friction = c->friction_limit / c->normal_force;
    f.torsional_friction = c->torsion_limit / c->normal_force;
    f.closing = c->normal_force / c->stiffness[0];
    return f;
}

/* Of the contacts between the first object and fingers those that press. */
static int press_points(const world *w, const pinch_ode_contact *list, int count, pinch_finger *fingers)
{
    int found = 0;
    for (int k = 0; k < count; k++) {
        const pinch_ode_contact *c = &list[k];
        int finger = world_finger_of_pair(w, c->geom1, c->geom2);
        if (finger < 0 || w->fingers[finger].object != 0 || !(c->normal_force > 0.0) || !(c->stiffness[0] > 0.0))
            continue;
        fingers[found++] = finger_at(c, c->body1 == w->object ? 1.0 : -1.0, dBodyGetPosition(w->object));
    }
    return found;
}

void record_contacts(const study *s, const world *w, json_t *into)
{
    bool wanted[QUANTITIES], any;
    double values[QUANTITIES];
    const pinch_ode_contact *list;
    int count;
    bool moved = w->hand_count > 0 || scene_finger_on_path(w->scene, w->time);
    if (!moved || !w->plugin || !wanted_quantities(s, wanted, &any) || !any) return;
    if (pinch_ode_contacts(w->plugin, &list, &count) != PINCH_OK) return;
    pinch_finger *fingers = calloc((size_t)count + 1, sizeof *fingers);
    pinch_grasp grasp = {
        .fingers = fingers, .radius = w->scene->objects[0].shape.bounding_radius, .planar = w->scene->dimension == 2};
    for (int q = 0; q < QUANTITIES; q++) values[q] = NAN;
    if (fingers) grasp.finger_count = press_points(w, list, count, fingers);
    if (grasp.finger_count > 0) {
        world_external_wrench(w, 0, grasp.wrench, grasp.wrench + 3);
        find_reserves(&grasp, wanted, values);
        find_quality(&grasp, wanted, values);
    }
    free(fingers);
    set_quantities(wanted, values, into);
}
