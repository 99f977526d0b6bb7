#ifndef PINCH_HANDS_LISTING_H
#define PINCH_HANDS_LISTING_H

#include "hand.h"

#include <jansson.h>
#include <stdio.h>

/* The hand as a JSON document: everything that was read. Infinite limits are null. NULL when memory runs out. */
json_t *hand_document(const hand *h);
/* The poses of all links in the frame of the hand, as the value of "kinematics". */
json_t *hand_document_poses(const hand *h, const double *positions, const hand_pose *poses);

/* The same for people. */
void hand_print(const hand *h, FILE *stream);
void hand_print_poses(const hand *h, const hand_pose *poses, FILE *stream);

#endif
