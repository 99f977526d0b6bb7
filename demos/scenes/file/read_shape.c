#define _XOPEN_SOURCE 700

#include "reader.h"
#include "scenes/shape/shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const shape_names[SCENE_SHAPE_COUNT] = {
    [SCENE_BOX] = "box",
    [SCENE_SPHERE] = "sphere",
    [SCENE_CAPSULE] = "capsule",
    [SCENE_CYLINDER] = "cylinder",
    [SCENE_ELLIPSOID] = "ellipsoid",
    [SCENE_CONVEX] = "convex",
    [SCENE_SUPERELLIPSOID] = "superellipsoid",
    [SCENE_FLAT_CAPSULE] = "flat_capsule",
    [SCENE_PRISM] = "prism",
    [SCENE_MESH] = "mesh",
};

const char *scene_shape_name(scene_shape_type type)
{
    return shape_names[type];
}

static bool read_positive_numbers(const scene_node *parent, const char *key, double out[3])
{
    scene_node node = scene_member(parent, key);
    return scene_read_numbers(&node, 3, SCENE_POSITIVE, "m", out);
}

/* Reads `minimum` or more points of `width` coordinates each into a new array. */
static bool read_vertices(const scene_node *parent, size_t width, size_t minimum, size_t *count, double **vertices)
{
    scene_node list = scene_member(parent, "vertices");
    if (!scene_check_array(&list, "vertices")) return false;
    size_t n = json_array_size(list.value);
    if (n < minimum) return scene_refuse(&list, "a list of at least %zu vertices", minimum);
    *vertices = malloc(n * width * sizeof **vertices);
    if (!*vertices) return scene_refuse_memory(parent->reader);
    *count = n;
    for (size_t i = 0; i < n; i++) {
        scene_node vertex = scene_element(&list, i);
        if (!scene_read_numbers(&vertex, width, SCENE_ANY_NUMBER, "m", *vertices + width * i)) return false;
    }
    return true;
}

bool scene_read_path(const scene_node *node, const char *key, char **path)
{
    char *name = NULL;
    if (!scene_read_string(node, key, false, &name)) return false;
    const char *slash = strrchr(node->reader->file, '/');
    size_t folder = slash && *name != '/' ? (size_t)(slash - node->reader->file) + 1 : 0;
    char *joined = malloc(folder + strlen(name) + 1);
    if (joined) {
        memcpy(joined, node->reader->file, folder);
        strcpy(joined + folder, name);
    }
    free(name);
    if (!joined) return scene_refuse_memory(node->reader);
    *path = realpath(joined, NULL);
    if (*path)
        free(joined);
    else /* reading the file will say why not */
        *path = joined;
    return true;
}

static bool read_mesh(const scene_node *node, scene_shape *shape)
{
    return scene_read_path(node, "file", &shape->u.mesh.file);
}

/* Reads the radius of rounded edges, which must be below half of the least measure. */
static bool read_rounding(const scene_node *parent, double limit, double *rounding)
{
    scene_node node = scene_member(parent, "rounding");
    *rounding = 0.0;
    if (!scene_read_number(parent, "rounding", SCENE_NOT_NEGATIVE, "m", rounding)) return false;
    return *rounding < limit || scene_refuse(&node, "a rounding below %g m, half of the least measure", limit);
}

static bool read_exponents(const scene_node *parent, double exponents[2])
{
    scene_node node = scene_member(parent, "exponents");
    exponents[0] = exponents[1] = 1.0;
    if (!node.value) return true;
    if (!scene_read_numbers(&node, 2, SCENE_POSITIVE, "", exponents)) return false;
    for (size_t i = 0; i < 2; i++) {
        scene_node element = scene_element(&node, i);
        if (!(exponents[i] >= 0.25 && exponents[i] <= 1.6)) return scene_refuse(&element, "a number from 0.25 to 1.6");
    }
    return true;
}

static bool read_cylinder(const scene_node *node, scene_shape *shape)
{
    double *radius = &shape->u.cylinder.radius, *length = &shape->u.cylinder.length;
    return scene_read_number(node, "radius", SCENE_POSITIVE, "m", radius) &&
           scene_read_number(node, "length", SCENE_POSITIVE, "m", length) &&
           read_rounding(node, fmin(*radius, 0.5 * *length), &shape->u.cylinder.rounding);
}

static bool read_box(const scene_node *node, scene_shape *shape)
{
    const double *size = shape->u.box.size;
    return read_positive_numbers(node, "size", shape->u.box.size) &&
           read_rounding(node, 0.5 * fmin(size[0], fmin(size[1], size[2])), &shape->u.box.rounding);
}

static bool read_dimensions(const scene_node *node, scene_shape *shape)
{
    switch (shape->type) {
    case SCENE_BOX:
        return read_box(node, shape);
    case SCENE_SPHERE:
        return scene_read_number(node, "radius", SCENE_POSITIVE, "m", &shape->u.sphere.radius);
    case SCENE_CAPSULE: /* the same members as the flat capsule's */
    case SCENE_FLAT_CAPSULE:
        return scene_read_number(node, "radius", SCENE_POSITIVE, "m", &shape->u.capsule.radius) &&
               scene_read_number(node, "length", SCENE_POSITIVE, "m", &shape->u.capsule.length);
    case SCENE_CYLINDER:
        return read_cylinder(node, shape);
    case SCENE_ELLIPSOID:
        return read_positive_numbers(node, "radii", shape->u.ellipsoid.radii);
    case SCENE_SUPERELLIPSOID:
        return read_positive_numbers(node, "radii", shape->u.superellipsoid.radii) &&
               read_exponents(node, shape->u.superellipsoid.exponents);
    case SCENE_CONVEX:
        return read_vertices(node, 3, 4, &shape->u.convex.count, &shape->u.convex.vertices);
    case SCENE_PRISM:
        return read_vertices(node, 2, 3, &shape->u.prism.count, &shape->u.prism.vertices) &&
               scene_read_number(node, "height", SCENE_POSITIVE, "m", &shape->u.prism.height);
    default:
        return read_mesh(node, shape);
    }
}

static bool refuse_fault(const scene_node *node, const scene_shape *shape, scene_shape_fault fault, const char *error)
{
    scene_node vertices = scene_member(node, "vertices"), file = scene_member(node, "file");
    bool of_file = fault == SCENE_SHAPE_FLAT || fault == SCENE_SHAPE_NOT_CONVEX || fault == SCENE_SHAPE_BAD_FILE;
    if (shape->type == SCENE_MESH && of_file)
        return scene_refuse_plainly(&file, "a usable mesh: %s: %s", shape->u.mesh.file, error);
    switch (fault) {
    case SCENE_SHAPE_FLAT:
        return scene_refuse_plainly(&vertices, "vertices that span a volume, got a flat shape");
    case SCENE_SHAPE_NOT_CONVEX:
        return scene_refuse_plainly(&vertices, "the corners of a strictly convex polygon, got a corner that does not "
                                               "turn left or a polygon that crosses itself");
    case SCENE_SHAPE_CLOCKWISE:
        return scene_refuse_plainly(&vertices, "corners in counter-clockwise order, got them clockwise");
    case SCENE_SHAPE_OUT_OF_MEMORY:
        return scene_refuse_memory(node->reader);
    default:
        return scene_refuse_plainly(node, "a shape whose volume and inertia are finite numbers > 0");
    }
}

bool scene_read_shape(const scene_node *node, const char *extra, scene_shape *shape)
{
    int type = 0;
    /* The type decides which keys there may be, so it is read before they are checked. */
    if (!json_is_object(node->value)) return scene_refuse(node, "an object");
    scene_node type_node = scene_member(node, "type");
    if (!type_node.value) return scene_refuse(&type_node, "a shape's type");
    if (!scene_read_name(node, "type", shape_names, SCENE_SHAPE_COUNT, &type)) return false;
    shape->type = (scene_shape_type)type;
    if (!scene_check_object(node, shape_names[type], extra) || !read_dimensions(node, shape)) return false;
    char error[256] = "";
    scene_shape_fault fault =
        shape->type == SCENE_MESH ? scene_shape_load_mesh(shape, error) : scene_shape_complete(shape);
    return fault == SCENE_SHAPE_FINE || refuse_fault(node, shape, fault, error);
}
