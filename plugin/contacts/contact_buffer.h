/*
 * The contact buffer takes the contacts that a program hands over for the next step, as plain contacts or as contact
 * joints that the program made itself.
 */
#ifndef PINCH_CONTACTS_CONTACT_BUFFER_H
#define PINCH_CONTACTS_CONTACT_BUFFER_H

#include "bodies/step_bodies.h"
#include "contacts/contact_store.h"

/* What taking contacts over reads and counts. */
typedef struct pinch_contact_sink {
    pinch_contact_store *store;
    const pinch_step_context *context;
    const pinch_drives *drives;
    pinch_ode_stats *stats;
} pinch_contact_sink;

/* Buffers a contact, or leaves it to ODE where Pinch has no law for it, or skips it where it is malformed. */
pinch_status pinch_buffer_contact(const pinch_contact_sink *sink, const dContact *contact, dBodyID body1,
                                  dBodyID body2);
/* The same for a contact that the program made a contact joint of ODE's, which is enabled. */
pinch_status pinch_buffer_contact_joint(const pinch_contact_sink *sink, const pinch_contact_joint *joint,
                                        const dContact *contact);

/*
 * Several threads may take over the contacts of pairs that come as in the last step, between the same sides, as many,
 * and with the same surfaces, without first friction directions, to the same bits. Each looks for them in places of its
 * own, which are those of the last step (pinch_take_again). Where all come in their places, that is all
 * (pinch_taken_again).
 *
 * Otherwise one thread buffers the rest behind those of the last step (pinch_begin_behind), and then the threads move
 * all of them to where they would have come one by one (pinch_begin_moving, pinch_move_contacts, pinch_end_moving).
 * Where something goes wrong on the way, pinch_abandon_taken ends it.
 */
typedef enum pinch_taken { PINCH_NOT_TAKEN, PINCH_TAKEN, PINCH_TAKEN_UNCHANGED /* to the bit */ } pinch_taken;

/* Does the buffer allow for that? */
bool pinch_may_take_again(const pinch_contact_store *store);
/* Takes so many contacts of a pair of geoms, >= 1, if it comes again. *places: those of the last step in which it is
 * looked for; afterwards those behind it. Where it is taken, its contacts are in the `count` places before these. */
pinch_taken pinch_take_again(const pinch_contact_sink *sink, const dGeomID geom[2], const dContact *contacts, int count,
                             pinch_range *places);
/* Ends it when all are in their places, from place 0 on; unchanged: all are those of the last step. */
void pinch_taken_again(pinch_contact_store *store, int count, bool unchanged);
/* Has what is buffered next come behind the last step's contacts. Returns false when memory runs out. */
bool pinch_begin_behind(pinch_contact_store *store);
/* Makes room for so many contacts, of all pairs. Returns false when memory runs out. */
bool pinch_begin_moving(pinch_contact_store *store, int count);
/* Moves the contacts that a pair of geoms has in these places, at least one. Several threads may do so. */
void pinch_move_contacts(pinch_contact_store *store, pinch_range places, int to);
void pinch_end_moving(pinch_contact_store *store, int count, bool unchanged);
/* Nothing has come, and nothing is known of the last step any more: it has been written over. */
void pinch_abandon_taken(pinch_contact_store *store);

/* Chains the first `count` contacts of the buffer, those of each pair in their order. */
void pinch_chain_contacts(pinch_contact_store *store, int count);

/* Enables the contact joints and empties the buffer after a step. From here on, what is handed over may be what it was
 * in that step. */
void pinch_finish_contacts(pinch_contact_store *store);
/* The same for a step that is given up, of which nothing is reused. */
void pinch_abandon_contacts(pinch_contact_store *store);

#endif
