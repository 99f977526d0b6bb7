#include "common/vector.h"
#include "reader.h"

#include <stdlib.h>
#include <string.h>

typedef struct channel_format {
    const char *key; /* in the entry, or in its hand */
    bool of_hand;
    scene_vector_kind kind;
    const char *unit;
} channel_format;

static const channel_format formats[SCENE_CHANNEL_COUNT] = {
    [SCENE_FORCE] = {"force", false, SCENE_POLAR, "N"},
    [SCENE_TORQUE] = {"torque", false, SCENE_AXIAL, "N m"},
    [SCENE_GRAVITY] = {"gravity", false, SCENE_POLAR, "m/s^2"},
    [SCENE_BASE_ACCELERATION] = {"base_acceleration", false, SCENE_POLAR, "m/s^2"},
    [SCENE_HAND_TRANSLATION] = {"translation", true, SCENE_POLAR, "m"},
    [SCENE_HAND_ROTATION] = {"rotation", true, SCENE_AXIAL, "rad"},
};

const char *scene_channel_key(scene_channel channel, bool *of_hand)
{
    *of_hand = formats[channel].of_hand;
    return formats[channel].key;
}

static bool read_sine(const scene_node *node, const channel_format *format, scene_signal *signal)
{
    signal->type = SCENE_SINE;
    return scene_check_object(node, "sine", NULL) &&
           scene_read_vector(node, "amplitude", format->kind, format->unit, signal->value) &&
           scene_read_number(node, "frequency", SCENE_NOT_NEGATIVE, "Hz", &signal->frequency) &&
           scene_read_number(node, "phase", SCENE_ANY_NUMBER, "rad", &signal->phase) &&
           scene_read_number(node, "fade", SCENE_NOT_NEGATIVE, "s", &signal->fade);
}

static bool read_turn(const scene_node *node, const channel_format *format, scene_signal *signal)
{
    signal->type = SCENE_TURN;
    return scene_check_object(node, "turn", NULL) &&
           scene_read_vector(node, "turn", format->kind, format->unit, signal->value) &&
           scene_read_unit_vector(node, "axis", SCENE_AXIAL, signal->axis) &&
           scene_read_number(node, "frequency", SCENE_ANY_NUMBER, "Hz", &signal->frequency);
}

static bool read_channel(const scene_node *parent, const channel_format *format, double time, scene_signal *signal)
{
    scene_node node = scene_member(parent, format->key);
    if (!node.value) return true;
    *signal = (scene_signal){.type = SCENE_CONSTANT, .start = time};
    if (json_is_object(node.value))
        return scene_has(&node, "turn") ? read_turn(&node, format, signal) : read_sine(&node, format, signal);
    if (!json_is_array(node.value))
        return scene_refuse(&node, "a list of 3 numbers (%s), a sine or a turn", format->unit);
    return scene_read_vector(parent, format->key, format->kind, format->unit, signal->value);
}

static bool read_entry(const scene_node *node, double earliest, scene_entry *entry)
{
    scene_node hand = scene_member(node, "hand");
    if (!scene_check_object(node, "entry", NULL) || !scene_read_time(node, earliest, &entry->time)) return false;
    if (hand.value && !scene_check_object(&hand, "hand", NULL)) return false;
    for (int c = 0; c < SCENE_CHANNEL_COUNT; c++)
        if (!read_channel(formats[c].of_hand ? &hand : node, &formats[c], entry->time, &entry->channels[c]))
            return false;
    return true;
}

bool scene_read_schedule(const scene_node *root, scene *s)
{
    scene_node list = scene_member(root, "schedule");
    if (list.value && !scene_check_array(&list, "entries")) return false;
    size_t given = json_array_size(list.value);
    s->schedule = calloc(given ? given : 1, sizeof *s->schedule);
    if (!s->schedule) return scene_refuse_memory(root->reader);
    s->entry_count = given ? given : 1;

    scene_entry *first = s->schedule;
    scene_copy(s->objects[0].force, first->channels[SCENE_FORCE].value);
    scene_copy(s->objects[0].torque, first->channels[SCENE_TORQUE].value);
    scene_copy(s->gravity, first->channels[SCENE_GRAVITY].value);
    for (size_t i = 0; i < given; i++) {
        scene_node node = scene_element(&list, i);
        if (i) s->schedule[i] = s->schedule[i - 1];
        if (!read_entry(&node, i ? s->schedule[i - 1].time : 0.0, &s->schedule[i])) return false;
    }
    return true;
}
