#include "load.h"

#include <stdlib.h>

static const char *const drive_names[] = {
    [SCENE_DRIVE_FIXED] = "fixed",
    [SCENE_DRIVE_SLIDER] = "slider",
    [SCENE_DRIVE_PATH] = "path",
};

const char *scene_drive_name(scene_drive_type type)
{
    return drive_names[type];
}

bool scene_read_time(const scene_node *node, double earliest, double *time)
{
    if (!scene_read_number(node, "time", SCENE_NOT_NEGATIVE, "s", time)) return false;
    scene_node member = scene_member(node, "time");
    return *time >= earliest || scene_refuse(&member, "a time not before the entry in front of it (%g s)", earliest);
}

static bool read_path(const scene_node *drive_node, scene_drive *drive)
{
    scene_node list = scene_member(drive_node, "points");
    if (!scene_check_array(&list, "points")) return false;
    size_t count = json_array_size(list.value);
    if (!count) return scene_refuse(&list, "a list of at least one point");
    drive->u.path.points = calloc(count, sizeof *drive->u.path.points);
    if (!drive->u.path.points) return scene_refuse_memory(drive_node->reader);
    drive->u.path.count = count;
    for (size_t i = 0; i < count; i++) {
        scene_path_point *point = &drive->u.path.points[i];
        scene_node node = scene_element(&list, i);
        if (i) *point = point[-1];
        if (!scene_check_object(&node, "path_point", NULL) || !scene_read_time(&node, point->time, &point->time) ||
            !scene_read_vector(&node, "translation", SCENE_POLAR, "m", point->translation) ||
            !scene_read_vector(&node, "rotation", SCENE_AXIAL, "rad", point->rotation))
            return false;
    }
    return true;
}

bool scene_read_drive(const scene_node *finger, scene_drive *drive)
{
    scene_node node = scene_member(finger, "drive");
    if (!node.value) return true;
    int type = SCENE_DRIVE_FIXED;
    if (!json_is_object(node.value)) return scene_refuse(&node, "an object");
    scene_node type_node = scene_member(&node, "type");
    if (!type_node.value) return scene_refuse(&type_node, "a drive's type");
    if (!scene_read_name(&node, "type", drive_names, SCENE_DRIVE_PATH + 1, &type) ||
        !scene_check_object(&node, drive_names[type], NULL))
        return false;
    drive->type = (scene_drive_type)type;
    if (drive->type == SCENE_DRIVE_PATH) return read_path(&node, drive);
    if (drive->type == SCENE_DRIVE_FIXED) return true;
    return scene_read_number(&node, "mass", SCENE_POSITIVE, "kg", &drive->u.slider.mass) &&
           scene_read_number(&node, "force", SCENE_NOT_NEGATIVE, "N", &drive->u.slider.force) &&
           scene_read_number(&node, "damping", SCENE_NOT_NEGATIVE, "N s/m", &drive->u.slider.damping) &&
           scene_read_boolean(&node, "gravity", &drive->u.slider.gravity);
}
