/* Geoms: shape, place, contact bits, and the mass that a body gets from them. */

#include "inertia.h"
#include "mjcf.h"

static const char attributes[] =
    "name class type contype conaffinity condim group priority size material friction mass "
    "density shellinertia solmix solref solimp margin gap fromto pos quat axisangle xyaxes "
    "zaxis euler hfield mesh fitscale rgba fluidshape fluidcoef user";

/* The words of MJCF's type, and what they are here; -1: something else. */
static const char words[] = "sphere capsule ellipsoid cylinder box mesh plane hfield sdf";
static const int types[] = {HAND_SPHERE, HAND_CAPSULE, HAND_ELLIPSOID, HAND_CYLINDER, HAND_BOX, HAND_MESH, -1, -1, -1};
enum { WORD_PLANE = 6 };

static size_t sizes_of(hand_geom_type type)
{
    return type == HAND_SPHERE ? 1 : type == HAND_CAPSULE || type == HAND_CYLINDER ? 2 : 3;
}

/* fromto: the ends of the shape's z axis. */
static bool read_ends(const mjcf_element *e, hand_geom *geom)
{
    hand_reader *r = e->m->r;
    double ends[6], axis[3];
    if (!mjcf_numbers(e, "fromto", ends, 6, 6)) return false;
    if (geom->type == HAND_SPHERE || geom->type == HAND_MESH) {
        reader_refuse(r, e->node, "expected no fromto: only capsules, cylinders, ellipsoids and boxes have one");
        return true;
    }
    if (scene_norm(geom->pose.position) > 0) reader_refuse(r, e->node, "expected either pos or fromto");
    scene_subtract(ends, ends + 3, axis);
    double length = scene_norm(axis);
    if (r->status == HAND_OK && !(length > 1e-14)) reader_refuse(r, e->node, "expected two different points in fromto");
    for (int i = 0; i < 3; i++) {
        axis[i] /= length;
        geom->pose.position[i] = 0.5 * (ends[i] + ends[i + 3]);
    }
    mjcf_orientation_of_z(axis, geom->pose.orientation);
    geom->size[1] = 0.5 * length;
    if (sizes_of(geom->type) == 3) {
        geom->size[2] = geom->size[1];
        geom->size[1] = geom->size[0];
    }
    return true;
}

/* A shape that is not a mesh but names one is as large as the box with the mesh's moments of inertia, and lies along
 * its principal axes. */
static void fit(const mjcf_element *e, const mjcf_mesh *mesh, hand_geom *geom)
{
    double moments[3], axes[9], half[3], scale = 1;
    hand_pose frame;
    inertia_principal(mesh->mass.inertia, moments, axes);
    for (int i = 0; i < 3; i++) {
        double square = 6 * (moments[(i + 1) % 3] + moments[(i + 2) % 3] - moments[i]) / mesh->mass.mass;
        half[i] = 0.5 * sqrt(fmax(square, 0));
    }
    reader_number(e->m->r, e->node, "fitscale", &scale);
    scene_copy(mesh->mass.centre, frame.position);
    inertia_quaternion(axes, frame.orientation);
    geom->pose = pose_product(&geom->pose, &frame);
    double round = 0.5 * (half[0] + half[1]);
    switch (geom->type) {
    case HAND_SPHERE:
        geom->size[0] = (half[0] + half[1] + half[2]) / 3;
        break;
    case HAND_CAPSULE:
        geom->size[0] = round;
        geom->size[1] = fmax(0, half[2] - 0.5 * round);
        break;
    case HAND_CYLINDER:
        geom->size[0] = round;
        geom->size[1] = half[2];
        break;
    default:
        scene_copy(half, geom->size);
    }
    for (int i = 0; i < 3; i++) geom->size[i] *= scale;
}

static void read_colour(const mjcf_element *e, double colour[4])
{
    const char *material = mjcf_text(e, "material");
    if (mjcf_numbers(e, "rgba", colour, 4, 4) || !material) return;
    for (const xmlNode *s = xml_child(e->m->root, "asset"); s; s = xml_next(s, "asset"))
        for (const xmlNode *n = xml_child(s, "material"); n; n = xml_next(n, "material")) {
            const char *name = xml_text(n, "name");
            if (name && strcmp(name, material) == 0) reader_numbers(e->m->r, n, "rgba", colour, 4, 4);
        }
}

static unsigned read_bits(const mjcf_element *e, const char *name)
{
    double bits = 1;
    mjcf_numbers(e, name, &bits, 1, 1);
    if (bits >= 0 && bits <= 2147483647 && bits == floor(bits)) return (unsigned)bits;
    reader_refuse(e->m->r, e->node, "expected a whole number from 0 to 2147483647 in %s", name);
    return 0;
}

static void read_contact(const mjcf_element *e, hand_geom *geom)
{
    double friction[3] = {1, 0.005, 0.0001};
    geom->contype = read_bits(e, "contype");
    geom->conaffinity = read_bits(e, "conaffinity");
    geom->collides = geom->contype != 0 || geom->conaffinity != 0;
    double directions = 3;
    mjcf_numbers(e, "condim", &directions, 1, 1);
    if (directions != 1 && directions != 3 && directions != 4 && directions != 6)
        reader_refuse(e->m->r, e->node, "expected 1, 3, 4 or 6 in condim");
    if (geom->collides && directions != 3) reader_unmodelled(e->m->r, e->node, "condim of a geom");
    bool given = mjcf_numbers(e, "friction", friction, 1, 3) > 0;
    for (int i = 0; i < 3; i++) geom->friction[i] = given ? friction[i] : -1;
}

/* The mass of the geom, in its own frame, from mass or density. */
static void weigh(const mjcf_element *e, const hand_geom *geom, const mjcf_mesh *mesh, hand_mass *mass)
{
    double given = -1, density = 1000, moments[3];
    bool shell = mjcf_word(e, "shellinertia", "false true", 0) == 1, has_mass = mjcf_numbers(e, "mass", &given, 1, 1);
    memset(mass, 0, sizeof *mass);
    mjcf_numbers(e, "density", &density, 1, 1);
    if (e->m->r->status != HAND_OK) return;
    if ((has_mass && given < 0) || density < 0) reader_refuse(e->m->r, e->node, "expected a mass that is not negative");
    if (shell && geom->type == HAND_MESH)
        reader_refuse(e->m->r, e->node, "expected inertia=\"shell\" in the mesh, not shellinertia here");
    if (geom->type == HAND_MESH) {
        *mass = mesh->mass;
    } else {
        geom_moments(geom->type, geom->size, shell, moments);
        mass->mass = geom_volume(geom->type, geom->size, shell);
        for (int i = 0; i < 3; i++) mass->inertia[4 * i] = mass->mass * moments[i];
    }
    double factor = has_mass ? given / mass->mass : density;
    mass->mass = has_mass ? given : density * mass->mass;
    for (int i = 0; i < 9; i++) mass->inertia[i] *= factor;
    if (mass->mass <= 1e-14) memset(mass, 0, sizeof *mass); /* as in MuJoCo */
}

/* Shape, pose in the frame that the geom is written in, and what it weighs in it. */
static void read_solid(const mjcf_element *e, bool inferred, hand_geom *geom, hand_mass *mass)
{
    mjcf *m = e->m;
    const char *name = mjcf_text(e, "mesh");
    mjcf_mesh *mesh = name ? mjcf_find_mesh(m, name) : NULL;
    memset(mass, 0, sizeof *mass);
    mjcf_numbers(e, "size", geom->size, 1, 3);
    geom->pose = mjcf_pose(e);
    read_ends(e, geom);
    if (name ? !mesh : geom->type == HAND_MESH) {
        reader_refuse(m->r, e->node, "expected the name of a mesh in mesh%s%.100s%s", name ? ", not \"" : "",
                      name ? name : "", name ? "\"" : "");
        return;
    }
    if (mesh &&
        !mjcf_weigh_mesh(m, mesh, inferred || geom->type != HAND_MESH, geom->collides && geom->type == HAND_MESH))
        return;
    if (mesh && geom->type != HAND_MESH) fit(e, mesh, geom);
    if (geom->type == HAND_MESH)
        geom->mesh = mesh->place;
    else
        for (size_t i = 0; i < sizes_of(geom->type); i++)
            if (!(geom->size[i] > 0) && !(mesh && i == 1 && geom->size[i] == 0)) {
                reader_refuse(m->r, e->node, "expected %zu positive number%s in size", sizes_of(geom->type),
                              sizes_of(geom->type) > 1 ? "s" : "");
                return;
            }
    hand_mass own;
    if (!inferred || m->r->status != HAND_OK) return;
    weigh(e, geom, mesh, &own);
    if (own.mass > 0) mass_in_outer(&geom->pose, &own, mass);
}

void mjcf_read_geom(mjcf *m, const xmlNode *node, const mjcf_place *place, hand_mass *sum)
{
    hand_reader *r = m->r;
    hand *h = r->h;
    mjcf_element e;
    hand_mass mass, moved;
    double group = 0;
    if (!mjcf_open(m, node, place->childclass, "geom", &e) || !mjcf_only(&e, attributes)) return;
    if (xml_child(node, "plugin")) reader_unmodelled(r, node, "geom with a plugin");
    int word = mjcf_word(&e, "type", words, 0);
    if (r->status != HAND_OK) return;
    if (word == WORD_PLANE && place->link < 0) {
        reader_ignore(r, node, "geom of type plane");
        return;
    }
    if (types[word] < 0) {
        reader_refuse(r, node, "the type %s is not supported here", mjcf_text(&e, "type"));
        return;
    }
    hand_geom own = {.link = place->link,
                     .type = (hand_geom_type)types[word],
                     .mesh = -1,
                     .colour = {0, 0, 0, -1},
                     .line = (int)xmlGetLineNo(node)};
    mjcf_numbers(&e, "group", &group, 1, 1);
    read_contact(&e, &own);
    bool inferred = sum && group >= m->compiler.groups[0] && group <= m->compiler.groups[1];
    read_solid(&e, inferred, &own, &mass);
    read_colour(&e, own.colour);
    if (r->status != HAND_OK) return;
    own.pose = pose_product(&place->frame, &own.pose);
    if (inferred && mass.mass > 0) {
        mass_in_outer(&place->frame, &mass, &moved);
        mass_add(sum, &moved);
    }
    own.name = reader_name(r, node, "geom", h->geom_count);
    hand_geom *geom = reader_append(r, &h->geoms, &h->geom_count, sizeof *geom);
    if (geom) *geom = own;
}
