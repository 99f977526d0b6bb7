#ifndef PINCH_VIEW_LOOK_H
#define PINCH_VIEW_LOOK_H

#include "film.h"

/* How a film is shown, the same in every kind of picture. */

/* Colours as #rrggbb that people with any kind of colour vision tell apart (after Okabe and Ito). */
typedef enum look_colour {
    LOOK_OBJECT = 0,
    LOOK_FINGER,
    LOOK_ENVIRONMENT,
    LOOK_FORCE,
    LOOK_STICK,
    LOOK_SLIP,
    LOOK_YIELD,
    LOOK_OPEN,
    LOOK_COLOUR_COUNT
} look_colour;

const char *look_colour_code(look_colour colour);
/* "object", "finger", ..., "stick", ... */
const char *look_colour_name(look_colour colour);
look_colour look_of_body(film_kind kind);
/* The cone of a contact in this state. */
look_colour look_of_state(pinch_contact_state state);

/* The longest arrow (m), which shows the film's largest force, and the height of a friction cone (m). */
double look_arrow_length(const film *f);
double look_cone_height(const film *f);
/* A friction cone's base over its height; flatter ones would cover everything. */
double look_cone_width(double friction);

#endif
