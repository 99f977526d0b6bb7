/*
 * The contact buffer takes the contacts that a program hands over for the next step, as plain contacts or as contact
 * joints that the program made itself.
 */
#ifndef PINCH_CONTACTS_CONTACT_BUFFER_H
#define PINCH_CONTACTS_CONTACT_BUFFER_H

#include "bodies/step_bodies.h"
#include "contacts/contact_store.h"

/* Buffers a contact, or leaves it to ODE where Pinch has no law for it, or skips it where it is malformed. */
pinch_status pinch_buffer_contact(pinch_contact_store *store, const pinch_step_context *context,
                                  const pinch_drives *drives, pinch_ode_stats *stats, const dContact *contact,
                                  dBodyID body1, dBodyID body2);
/* The same for a contact that the program made a contact joint of ODE's, which is enabled. */
pinch_status pinch_buffer_contact_joint(pinch_contact_store *store, const pinch_step_context *context,
                                        const pinch_drives *drives, pinch_ode_stats *stats,
                                        const pinch_contact_joint *joint, const dContact *contact);

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
