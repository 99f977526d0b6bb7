#include "look.h"

#include <math.h>

static const struct {
    const char *name, *code;
} colours[LOOK_COLOUR_COUNT] = {
    [LOOK_OBJECT] = {"object", "#e0b96e"},
    [LOOK_FINGER] = {"finger", "#8fa8c8"},
    [LOOK_ENVIRONMENT] = {"environment", "#b8bcc2"},
    [LOOK_FORCE] = {"force", "#0062a8"},
    [LOOK_STICK] = {"stick", "#009e73"},
    [LOOK_SLIP] = {"slip", "#d55e00"},
    [LOOK_YIELD] = {"yield", "#7a4a12"},
    [LOOK_OPEN] = {"open", "#8c8c8c"},
};

const char *look_colour_code(look_colour colour)
{
    return colours[colour].code;
}

const char *look_colour_name(look_colour colour)
{
    return colours[colour].name;
}

look_colour look_of_body(film_kind kind)
{
    return kind == FILM_OBJECT ? LOOK_OBJECT : kind == FILM_FINGER ? LOOK_FINGER : LOOK_ENVIRONMENT;
}

look_colour look_of_state(pinch_contact_state state)
{
    switch (state) {
    case PINCH_CONTACT_STICK:
        return LOOK_STICK;
    case PINCH_CONTACT_SLIP:
        return LOOK_SLIP;
    case PINCH_CONTACT_YIELD:
        return LOOK_YIELD;
    default:
        return LOOK_OPEN;
    }
}

double look_arrow_length(const film *f)
{
    return 1.2 * f->scene->objects[0].shape.bounding_radius;
}

double look_cone_height(const film *f)
{
    return 0.4 * f->scene->objects[0].shape.bounding_radius;
}

double look_cone_width(double friction)
{
    return fmin(friction, 2);
}
