#ifndef PINCH_HANDS_FORMATS_H
#define PINCH_HANDS_FORMATS_H

#include "reader.h"

/* urdf.c and mjcf.c: read the document into the links, joints, geoms and so on, each as the file has it. A geom's pose
 * is in the frame of its link. */
void urdf_read(hand_reader *r, const xmlNode *root);
void mjcf_read(hand_reader *r, xmlNode *root);

/* urdf_names.c: refuses an attribute that URDF does not have where it may be a misspelt one that may be left out, and
 * lists others, in `node` and in what it has in it. */
void urdf_check_attributes(hand_reader *r, const xmlNode *node);
/* Lists those of `names` that stand in `node` again, of which the first counts. */
void urdf_list_repeated(hand_reader *r, const xmlNode *node, const char *names);
/* The same, and what else stands in `node`. */
void urdf_list_rest(hand_reader *r, const xmlNode *node, const char *names);

/* tree.c: adds a coupling, when all joints are there. Refuses one that closes a circle. */
void tree_couple(hand_reader *r, const xmlNode *at, const hand_coupling *coupling);

/* Makes bodies of the links, and checks what both formats have in common. */
void tree_complete(hand_reader *r);

#endif
