#ifndef PINCH_SCENE_LOAD_H
#define PINCH_SCENE_LOAD_H

#include "reader.h"

/* The parts of scene_load, one per kind of object. All fill in defaults; all return false after refusing. */

/* load_shape.c. `extra`: one more key the shape's object may have, or NULL. */
bool scene_read_shape(const scene_node *node, const char *extra, scene_shape *shape);

/* load_body.c */
bool scene_read_object(const scene_node *root, scene_object *object);
bool scene_read_environment(const scene_node *root, scene *s);
/* The default name: a letter and the place, counted from 1. */
bool scene_name_by_place(const scene_node *node, char letter, size_t index, char **name);
/* Refuses the node's name because list[index] has it already. */
bool scene_refuse_name(const scene_node *node, const char *list, size_t index);

/* load_material.c */
bool scene_read_material(const scene_node *node, const char *stiffness_kind, const char *damping_kind,
                         scene_stiffness *stiffness, scene_damping *damping, scene_friction *friction);

/* load_finger.c: after object and dimension. */
bool scene_read_fingers(const scene_node *root, scene *s);

/* load_drive.c */
bool scene_read_drive(const scene_node *finger, scene_drive *drive);
/* A `time` key: >= 0 and not before `earliest`. */
bool scene_read_time(const scene_node *node, double earliest, double *time);

/* load_schedule.c: after gravity and object. */
bool scene_read_schedule(const scene_node *root, scene *s);

/* place.c: point on the object's surface, normal into it, contact frame, and the tip's pose. */
bool scene_place_finger(const scene_node *node, const scene_object *object, scene_finger *finger);

#endif
