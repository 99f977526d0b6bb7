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
 * Where all contacts of a step come in the places of those of the last step, between the same sides and with the same
 * surfaces, several threads may take them over, to the same bits. Where it turns out that not all do, those that were
 * taken are given back, and all are handed over in their order.
 */
typedef enum pinch_taken { PINCH_NOT_TAKEN, PINCH_TAKEN, PINCH_TAKEN_UNCHANGED /* to the bit */ } pinch_taken;

/* Does the buffer allow for that? Makes room for what may be given back. */
bool pinch_may_take_again(pinch_contact_store *store);
/* Takes the contacts of a pair of geoms if they come in these places, as the last step had them. Several threads
 * may do so for places of their own. */
pinch_taken pinch_take_again(const pinch_contact_sink *sink, const dGeomID geom[2], const dContact *contacts,
                             pinch_range places);
/* Ends it when all have been taken, from place 0 on; unchanged: all are those of the last step. */
void pinch_taken_again(pinch_contact_store *store, int count, bool unchanged);
/* Otherwise all pairs that were taken are given back before any contact is handed over. Returns where the contacts of
 * the pair in these places are kept. */
pinch_range pinch_give_back(const pinch_contact_sink *sink, pinch_range places);
/* Buffers the contacts of a pair that has been given back. */
pinch_status pinch_buffer_given_back(const pinch_contact_sink *sink, const dGeomID geom[2], pinch_range kept);
/* Ends it. Where not all have been handed over, nothing is known of the last step any more: it has been written over.
 */
void pinch_given_back(pinch_contact_store *store, bool handed_over);

/*
 * ODE's own solver must not see the contact joints that Pinch solves. The program must find them as it left them, with
 * the forces where it asked for them (dJointSetFeedback).
 */
void pinch_disable_contact_joints(pinch_contact_store *store);
/* Gives the joints of a pair their feedback where its island is solved, and leaves them to ODE otherwise. */
void pinch_answer_contact_joints(pinch_contact_store *store, const pinch_pair *pair, bool solved);

/* Enables the contact joints and empties the buffer after a step. From here on, what is handed over may be what it was
 * in that step. */
void pinch_finish_contacts(pinch_contact_store *store);
/* The same for a step that is given up, of which nothing is reused. */
void pinch_abandon_contacts(pinch_contact_store *store);

#endif
