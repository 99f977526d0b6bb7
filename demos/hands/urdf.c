#define _XOPEN_SOURCE 700 /* realpath */

/* URDF: links, joints and what is in them. */

#include "formats.h"
#include "geometry.h"
#include "inertia.h"

#include <stdlib.h>
#include <unistd.h>

/* Published hands have inertias that somebody guessed: positive, but with a moment up to 1.4 times the sum of the other
 * two. They move like any other, so they are taken. What is above this part is a mistake. */
static const double GUESSED_INERTIA = 0.5;

/* The tree while it is put in order: an entry per <link>. */
typedef struct urdf_link {
    xmlNode *node;
    const xmlNode *joint;    /* the one above; NULL: root */
    int parent, first, next; /* entries: above, the first below, the next beside; -1: none */
    int last;
    int place; /* in the hand's list; -1: not there yet */
} urdf_link;

static hand_pose read_origin(hand_reader *r, const xmlNode *node)
{
    hand_pose pose = pose_identity();
    double rpy[3] = {0};
    const xmlNode *origin = xml_child(node, "origin");
    if (!origin) return pose;
    reader_numbers(r, origin, "xyz", pose.position, 3, 3);
    /* roll, pitch and yaw turn about the fixed axes */
    if (reader_numbers(r, origin, "rpy", rpy, 3, 3)) geometry_euler(rpy, "XYZ", pose.orientation);
    return pose;
}

static void read_inertial(hand_reader *r, const xmlNode *link, hand_mass *out)
{
    static const char *const names[] = {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"};
    static const int places[6][2] = {{0, 0}, {1, 3}, {2, 6}, {4, 4}, {5, 7}, {8, 8}};
    const xmlNode *node = xml_child(link, "inertial");
    if (!node) return;
    const xmlNode *mass = xml_child(node, "mass"), *inertia = xml_child(node, "inertia");
    if (!mass || !inertia) {
        reader_refuse(r, node, "expected <mass> and <inertia> in it");
        return;
    }
    hand_mass own = {0};
    if (!reader_number(r, mass, "value", &own.mass)) reader_required(r, mass, "value");
    for (int i = 0; i < 6; i++) {
        double value = 0;
        if (!reader_number(r, inertia, names[i], &value)) reader_required(r, inertia, names[i]);
        own.inertia[places[i][0]] = own.inertia[places[i][1]] = value;
    }
    geometry_check_mass(r, node, &own, GUESSED_INERTIA);
    if (r->status != HAND_OK) return;
    hand_pose origin = read_origin(r, node);
    mass_in_outer(&origin, &own, out);
    urdf_list_rest(r, node, "origin mass inertia");
}

/* ---- Files of meshes. ---- */

static const char PACKAGE[] = "package://";

static bool is_there(const char *path)
{
    return access(path, R_OK) == 0;
}

/* The directory of the package NAME: one that was given, else the nearest directory above the file that has the name
 * or has one of that name in it. */
static char *find_package(hand_reader *r, const char *file, const char *name, size_t length, const char *rest)
{
    for (size_t i = 0; i < r->package_count; i++)
        if (strlen(r->packages[i].name) == length && strncmp(r->packages[i].name, name, length) == 0)
            return reader_text(r, "%s/%s", r->packages[i].directory, rest);
    char *whole = realpath(file, NULL);
    for (char *slash = whole ? strrchr(whole, '/') : NULL; slash; slash = strrchr(whole, '/')) {
        *slash = '\0';
        const char *last = strrchr(whole, '/');
        char *own = reader_text(r, "%s/%s", whole, rest);
        char *inner = reader_text(r, "%s/%.*s/%s", whole, (int)length, name, rest);
        bool named = last && strlen(last + 1) == length && strncmp(last + 1, name, length) == 0;
        char *found = !own || !inner ? NULL : named && is_there(own) ? own : is_there(inner) ? inner : NULL;
        if (found || r->status != HAND_OK) {
            free(whole);
            return found;
        }
    }
    free(whole);
    return NULL;
}

/* A file of a package that is nowhere is not there, as any other: its path is then what the attribute says. */
static char *mesh_path(hand_reader *r, const xmlNode *node)
{
    const char *name = reader_required(r, node, "filename");
    if (!name) return NULL;
    if (strncmp(name, "file://", 7) == 0) name += 7;
    if (strncmp(name, PACKAGE, strlen(PACKAGE)) != 0) return reader_path(r, xml_file(node), name);
    const char *package = name + strlen(PACKAGE);
    size_t length = strcspn(package, "/");
    const char *rest = package[length] ? package + length + 1 : "";
    char *found = find_package(r, xml_file(node), package, length, rest);
    return found ? found : reader_text(r, "%s", name);
}

/* Pictures need no mesh to be there. Of those in a package that is nowhere, the package is listed once. */
static void list_missing_mesh(hand_reader *r, const xmlNode *node, const char *file, bool collides)
{
    const char *text = "mesh of a picture, which is not there";
    bool is_in_package = strncmp(file, PACKAGE, strlen(PACKAGE)) == 0;
    if (collides)
        text = reader_text(r, "contact with the mesh %s, which is not there", xml_text(node, "filename"));
    else if (is_in_package)
        text = reader_text(r, "meshes of pictures in the package %.*s, which is not there",
                           (int)strcspn(file + strlen(PACKAGE), "/"), file + strlen(PACKAGE));
    if (text) (collides ? reader_unmodelled : reader_ignore)(r, node, text);
}

/* ---- Geometry. ---- */

static void read_mesh(hand_reader *r, const xmlNode *node, hand_geom *geom)
{
    double scale[3] = {1, 1, 1};
    geom->type = HAND_MESH;
    char *file = mesh_path(r, node);
    reader_numbers(r, node, "scale", scale, 3, 3);
    if (!file || r->status != HAND_OK) return;
    const char *name = strrchr(file, '/');
    geom->mesh = geometry_mesh(r, node, name ? name + 1 : file, file, scale);
    if (geom->mesh < 0 || r->h->meshes[geom->mesh].hull.vertex_count) return;
    if (!is_there(file)) {
        list_missing_mesh(r, node, file, geom->collides);
        geom->collides = false;
    }
    if (!geom->collides) return;
    mesh_file mesh;
    if (!geometry_read(r, node, file, &mesh)) return;
    for (size_t i = 0; i < 9 * mesh.triangle_count; i++) mesh.corners[i] *= scale[i % 3];
    geometry_hull(r, node, geom->mesh, &mesh);
    mesh_free(&mesh);
}

static void read_size(hand_reader *r, const xmlNode *node, const char *name, double *value)
{
    if (!reader_number(r, node, name, value)) reader_required(r, node, name);
    if (r->status == HAND_OK && !(*value > 0)) reader_refuse(r, node, "expected a positive %s", name);
}

/* Of several shapes the first counts. */
static const xmlNode *find_shape(hand_reader *r, const xmlNode *node)
{
    const xmlNode *geometry = xml_child(node, "geometry"), *shape = geometry ? xml_child(geometry, NULL) : NULL;
    for (const xmlNode *n = shape ? xml_next(shape, NULL) : NULL; n; n = xml_next(n, NULL)) {
        const char *text = reader_text(r, "%s after the shape of a <geometry>", (const char *)n->name);
        if (text) reader_ignore(r, n, text);
    }
    return shape;
}

/* The shape; URDF has whole lengths where the hand has half lengths. */
static void read_shape(hand_reader *r, const xmlNode *node, hand_geom *geom)
{
    const xmlNode *shape = find_shape(r, node);
    if (!shape) {
        reader_refuse(r, node, "expected <geometry> with a shape in it");
        return;
    }
    if (xml_is(shape, "box")) {
        geom->type = HAND_BOX;
        if (!reader_numbers(r, shape, "size", geom->size, 3, 3)) reader_required(r, shape, "size");
        for (int i = 0; i < 3; i++) {
            if (r->status == HAND_OK && !(geom->size[i] > 0))
                reader_refuse(r, shape, "expected positive lengths in size");
            geom->size[i] *= 0.5;
        }
    } else if (xml_is(shape, "sphere")) {
        geom->type = HAND_SPHERE;
        read_size(r, shape, "radius", &geom->size[0]);
    } else if (xml_is(shape, "cylinder") || xml_is(shape, "capsule")) {
        geom->type = xml_is(shape, "cylinder") ? HAND_CYLINDER : HAND_CAPSULE;
        read_size(r, shape, "radius", &geom->size[0]);
        read_size(r, shape, "length", &geom->size[1]);
        geom->size[1] *= 0.5;
    } else if (xml_is(shape, "mesh")) {
        read_mesh(r, shape, geom);
    } else {
        reader_refuse(r, shape, "expected <box>, <sphere>, <cylinder>, <capsule> or <mesh>");
    }
}

static void read_colour(hand_reader *r, const xmlNode *root, const xmlNode *visual, double colour[4])
{
    const xmlNode *material = xml_child(visual, "material");
    const char *name = material ? xml_text(material, "name") : NULL;
    const xmlNode *own = material ? xml_child(material, "color") : NULL;
    for (const xmlNode *m = xml_child(root, "material"); m && name && !own; m = xml_next(m, "material"))
        if (xml_text(m, "name") && strcmp(xml_text(m, "name"), name) == 0) own = xml_child(m, "color");
    if (own) reader_numbers(r, own, "rgba", colour, 4, 4);
}

static void read_geom(hand_reader *r, const xmlNode *root, const xmlNode *node, int link)
{
    hand *h = r->h;
    hand_geom own = {.link = link,
                     .collides = xml_is(node, "collision"),
                     .mesh = -1,
                     .contype = 1,
                     .conaffinity = 1,
                     .friction = {-1, -1, -1},
                     .colour = {0, 0, 0, -1},
                     .line = (int)xmlGetLineNo(node)};
    bool is_picture = !own.collides;
    own.pose = read_origin(r, node);
    read_shape(r, node, &own);
    urdf_list_rest(r, node, "origin geometry material");
    if (!own.collides) own.contype = own.conaffinity = 0;
    if (is_picture) read_colour(r, root, node, own.colour);
    if (is_picture && reader_forgive(r, node, "picture that is left out")) return;
    /* Names of collision and visual elements need not differ in URDF. */
    const char *name = xml_text(node, "name");
    own.name = name && *name ? reader_text(r, "%s", name) : reader_text(r, "geom_%zu", h->geom_count);
    hand_geom *geom = reader_append(r, &h->geoms, &h->geom_count, sizeof *geom);
    if (geom) *geom = own;
}

/* ---- Links and joints. ---- */

static void read_link(hand_reader *r, const xmlNode *root, urdf_link *entries, urdf_link *entry)
{
    hand *h = r->h;
    hand_link own = {.parent = entry->parent < 0 ? -1 : entries[entry->parent].place,
                     .pose = pose_identity(),
                     .line = (int)xmlGetLineNo(entry->node)};
    own.name = reader_text(r, "%s", xml_text(entry->node, "name"));
    own.file = reader_text(r, "%s", xml_file(entry->node));
    if (entry->joint) own.pose = read_origin(r, entry->joint);
    read_inertial(r, entry->node, &own.mass);
    entry->place = (int)h->link_count;
    hand_link *link = reader_append(r, &h->links, &h->link_count, sizeof *link);
    if (!link) return;
    *link = own;
    for (const xmlNode *child = xml_child(entry->node, NULL); child; child = xml_next(child, NULL)) {
        if (xml_is(child, "collision") || xml_is(child, "visual"))
            read_geom(r, root, child, entry->place);
        else if (!xml_is(child, "inertial"))
            reader_ignore(r, child, (const char *)child->name);
    }
    urdf_list_repeated(r, entry->node, "inertial");
}

/* A bound of 0 or more. Many files write 0 where none is known, as MuJoCo has it, too, and those that were made of SDF
 * write -1, which means no bound there. */
static double read_bound(hand_reader *r, const xmlNode *limit, const char *key)
{
    double value = INFINITY;
    reader_number(r, limit, key, &value);
    if (r->status != HAND_OK || value > 0) return value;
    if (value == -1)
        reader_ignore(r, limit,
                      strcmp(key, "effort") == 0 ? "effort of -1, taken as no bound"
                                                 : "velocity of -1, taken as no bound");
    else if (value < 0)
        reader_refuse(r, limit, "expected %s >= 0, not %g", key, value);
    return INFINITY;
}

static void read_limit(hand_reader *r, const xmlNode *node, bool continuous, hand_joint *joint)
{
    const xmlNode *limit = xml_child(node, "limit");
    if (!limit) {
        if (!continuous)
            reader_refuse(r, node, "expected <limit>; a joint that turns without end has the type \"continuous\"");
        return;
    }
    if (!continuous) {
        joint->limited = true;
        joint->lower = joint->upper = 0;
        reader_number(r, limit, "lower", &joint->lower);
        reader_number(r, limit, "upper", &joint->upper);
        if (r->status == HAND_OK && joint->lower > joint->upper)
            reader_refuse(r, limit, "expected lower <= upper, not %g and %g", joint->lower, joint->upper);
    }
    joint->effort = read_bound(r, limit, "effort");
    joint->least_effort = -joint->effort;
    joint->velocity = read_bound(r, limit, "velocity");
}

static void read_joint(hand_reader *r, const xmlNode *node, int link)
{
    hand *h = r->h;
    const char *type = xml_text(node, "type");
    if (strcmp(type, "fixed") == 0) return;
    hand_joint own = {.coupling = -1,
                      .type = strcmp(type, "prismatic") == 0 ? HAND_SLIDER : HAND_HINGE,
                      .link = link,
                      .axis = {1, 0, 0},
                      .lower = -INFINITY,
                      .upper = INFINITY,
                      .least_effort = -INFINITY,
                      .effort = INFINITY,
                      .velocity = INFINITY,
                      .line = (int)xmlGetLineNo(node)};
    const xmlNode *axis = xml_child(node, "axis"), *dynamics = xml_child(node, "dynamics");
    if (axis && !reader_numbers(r, axis, "xyz", own.axis, 3, 3)) reader_required(r, axis, "xyz");
    double length = scene_norm(own.axis);
    if (r->status == HAND_OK && !(length > 1e-14)) reader_refuse(r, axis, "expected an axis with a direction");
    for (int i = 0; i < 3; i++) own.axis[i] /= length;
    read_limit(r, node, strcmp(type, "continuous") == 0, &own);
    if (dynamics) {
        reader_number(r, dynamics, "damping", &own.damping);
        reader_number(r, dynamics, "friction", &own.friction);
        if (r->status == HAND_OK && (own.damping < 0 || own.friction < 0))
            reader_refuse(r, dynamics, "expected damping and friction that are not negative");
    }
    own.name = reader_name(r, node, "joint", h->joint_count);
    hand_joint *joint = reader_append(r, &h->joints, &h->joint_count, sizeof *joint);
    if (joint) *joint = own;
    urdf_list_rest(r, node, "origin parent child axis limit dynamics mimic");
}

static void read_mimic(hand_reader *r, const xmlNode *joint)
{
    const xmlNode *node = xml_child(joint, "mimic");
    const char *name = xml_text(joint, "name");
    if (!node || !name || r->status != HAND_OK) return;
    hand_coupling own = {.joint = reader_find(r, "joint", name), .multiplier = 1, .line = (int)xmlGetLineNo(node)};
    if (own.joint < 0) {
        reader_ignore(r, node, "mimic of a fixed joint");
        return;
    }
    own.of = reader_refer(r, node, "joint", "joint");
    reader_number(r, node, "multiplier", &own.multiplier);
    reader_number(r, node, "offset", &own.offset);
    tree_couple(r, node, &own);
}

/* ---- The tree. ---- */

static int refer_link(hand_reader *r, const xmlNode *joint, const char *end)
{
    const xmlNode *node = xml_child(joint, end);
    if (!node) {
        reader_refuse(r, joint, "expected <%s> in it", end);
        return -1;
    }
    return reader_refer(r, node, "link", "link");
}

static void connect(hand_reader *r, const xmlNode *joint, urdf_link *entries)
{
    const char *type = reader_required(r, joint, "type");
    reader_required(r, joint, "name");
    int parent = refer_link(r, joint, "parent"), child = refer_link(r, joint, "child");
    if (!type || parent < 0 || child < 0) return;
    if (!xml_listed("revolute continuous prismatic fixed", type))
        reader_refuse(r, joint, "expected the type revolute, continuous, prismatic or fixed, not \"%.60s\"", type);
    else if (entries[child].joint)
        reader_refuse(r, joint, "expected one joint above link \"%.100s\", but line %ld has another",
                      xml_text(entries[child].node, "name"), xmlGetLineNo(entries[child].joint));
    if (r->status != HAND_OK) return;
    entries[child].joint = joint;
    entries[child].parent = parent;
    if (entries[parent].first < 0)
        entries[parent].first = child;
    else
        entries[entries[parent].last].next = child;
    entries[parent].last = child;
}

/* The links that hang from the root, depth first, each with the joint above it. */
static void read_tree(hand_reader *r, const xmlNode *root, urdf_link *entries, int at)
{
    int start = at;
    while (at >= 0 && r->status == HAND_OK) {
        read_link(r, root, entries, &entries[at]);
        if (entries[at].joint) read_joint(r, entries[at].joint, entries[at].place);
        int next = entries[at].first;
        while (next < 0 && at != start) {
            next = entries[at].next;
            at = entries[at].parent;
        }
        at = next;
    }
}

static size_t list_links(hand_reader *r, const xmlNode *root, urdf_link **entries)
{
    size_t count = 0;
    for (xmlNode *n = xml_child(root, "link"); n && r->status == HAND_OK; n = xml_next(n, "link")) {
        if (!reader_required(r, n, "name") || !reader_name(r, n, "link", count)) break;
        urdf_link *entry = reader_append(r, entries, &count, sizeof *entry);
        if (entry) *entry = (urdf_link){.node = n, .parent = -1, .first = -1, .next = -1, .last = -1, .place = -1};
    }
    return count;
}

void urdf_read(hand_reader *r, const xmlNode *root)
{
    urdf_link *entries = NULL;
    urdf_check_attributes(r, root);
    size_t count = list_links(r, root, &entries);
    const char *name = xml_text(root, "name");
    int top = -1;
    r->h->name = reader_text(r, "%s", name ? name : "");
    for (const xmlNode *n = xml_child(root, NULL); n && r->status == HAND_OK; n = xml_next(n, NULL)) {
        if (xml_is(n, "joint"))
            connect(r, n, entries);
        else if (!xml_listed("link material", (const char *)n->name))
            reader_ignore(r, n, (const char *)n->name);
    }
    for (size_t i = 0; i < count && r->status == HAND_OK; i++) {
        if (entries[i].joint) continue;
        if (top >= 0)
            reader_refuse(r, entries[i].node,
                          "expected one link without a joint above it, but \"%.100s\" has none, too",
                          xml_text(entries[top].node, "name"));
        top = (int)i;
    }
    if (r->status == HAND_OK && top < 0) reader_refuse(r, root, "expected a link without a joint above it");
    if (r->status == HAND_OK) read_tree(r, root, entries, top);
    for (size_t i = 0; i < count && r->status == HAND_OK; i++)
        if (entries[i].place < 0)
            reader_refuse(r, entries[i].node,
                          "expected joints that lead to it from link \"%.100s\": it hangs in a circle",
                          xml_text(entries[top].node, "name"));
    for (const xmlNode *n = xml_child(root, "joint"); n && r->status == HAND_OK; n = xml_next(n, "joint"))
        read_mimic(r, n);
    free(entries);
}
