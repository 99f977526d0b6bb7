/* What parts of hands are called, and what they do, as JSON. */
#include "world_hand.h"

#include "common/output.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

char *world_name_of_hand(const world *w, const world_hand *h, const char *name)
{
    const char *prefix = w->scene->hand_count > 1 ? h->hand->name : "", *slash = *prefix ? "/" : "";
    size_t size = strlen(prefix) + strlen(slash) + strlen(name) + 1;
    char *whole = malloc(size);
    if (whole) (void)snprintf(whole, size, "%s%s%s", prefix, slash, name);
    return whole;
}

json_t *world_joint_documents(const world *w)
{
    json_t *list = json_array();
    for (int k = 0; k < w->hand_count; k++) {
        for (int i = 0; i < w->hands[k].joint_count; i++) {
            const world_joint *j = &w->hands[k].joints[i];
            bool driven = j->control->type != SCENE_UNDRIVEN;
            json_t *document =
                json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:b, s:b}", "name", j->name, "control",
                          scene_control_name(j->control->type), "position", json_number(j->position), "velocity",
                          json_number(j->velocity), "target", json_number(driven ? j->target : NAN), "torque",
                          json_number(j->torque), "max_force", json_number(driven ? j->control->max_force : NAN),
                          "at_limit", j->at_limit, "saturated", j->saturated);
            if (json_array_append_new(list, document)) {
                json_decref(list);
                return NULL;
            }
        }
    }
    return list;
}

/* The place that a tie pulls to, rad or m. NAN where there is none: a drive by torque or by speed, a damper without a
 * spring, and dry friction, which has its place with Pinch alone. */
static double place_of(const world *w, const world_tie *t)
{
    if (t->control) return t->control->type == SCENE_POSITION_CONTROL ? scene_target_at(t->control, w->time) : NAN;
    bool pulls = t->law.kp > 0 && (w->plugin || !t->is_friction);
    return pulls ? t->law.target + t->offset : NAN;
}

static const char *name_of_tie(const world_hand *h, const world_tie *t)
{
    const hand *model = h->hand->model;
    if (t->is_further) return t->control->name;
    return t->tendon < 0 ? h->joints[t->joint[0]].of->name : model->tendons[t->tendon].name;
}

static const char *type_of_tie(const world_tie *t)
{
    if (t->control) return "drive";
    if (t->tendon < 0) return "mimic";
    return t->is_friction ? "friction" : "spring";
}

/* What drives or ties several joints at once, and what drives one besides its first drive. */
json_t *world_tie_documents(const world *w)
{
    json_t *list = json_array();
    for (int k = 0; k < w->hand_count; k++) {
        for (int i = 0; i < w->hands[k].tie_count; i++) {
            const world_tie *t = &w->hands[k].ties[i];
            double x = 0;
            for (int j = 0; j < t->terms; j++) x += t->factor[j] * w->hands[k].joints[t->joint[j]].position;
            char *name = world_name_of_hand(w, &w->hands[k], name_of_tie(&w->hands[k], t));
            (void)json_array_append_new(
                list, json_pack("{s:s?, s:s, s:o, s:o, s:o, s:b}", "name", name, "type", type_of_tie(t), "position",
                                json_number(x), "target", json_number(place_of(w, t)), "force",
                                json_number(w->plugin ? t->force : NAN), "saturated",
                                t->control && world_control_is_saturated(t->control, t->force)));
            free(name);
        }
    }
    return list;
}
