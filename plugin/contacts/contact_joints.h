/*
 * Contact joints that the program made itself. ODE's own solver must not see those that Pinch solves; the program must
 * find them as it left them, with the forces where it asked for them (dJointSetFeedback).
 */
#ifndef PINCH_CONTACTS_CONTACT_JOINTS_H
#define PINCH_CONTACTS_CONTACT_JOINTS_H

#include "contacts/contact_store.h"

void pinch_disable_contact_joints(pinch_contact_store *store);
void pinch_enable_contact_joints(pinch_contact_store *store);
/* Gives the joints of a pair their feedback where its island is solved, and leaves them to ODE otherwise. */
void pinch_answer_contact_joints(pinch_contact_store *store, const pinch_pair *pair, bool solved);

#endif
