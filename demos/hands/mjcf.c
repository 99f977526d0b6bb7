/* MJCF: includes, the compiler's settings, and the sections of a file in the order in which they need each other. */

#include "mjcf.h"

#include "formats.h"

#include <stdlib.h>

/* ---- Includes. ---- */

enum { MOST_FILES = 100 };

typedef struct includes {
    hand_reader *r;
    const char *files[MOST_FILES];
    int count;
} includes;

/* Puts the elements of the file in the place of <include>. Its path starts at the first file, as in MuJoCo, and a file
 * is included once: a circle of includes ends there. */
static void insert(includes *in, xmlNode *node)
{
    hand_reader *r = in->r;
    const char *name = reader_required(r, node, "file");
    char *file = name ? reader_path(r, r->h->file, name) : NULL;
    if (!file) return;
    for (int i = 0; i < in->count; i++)
        if (strcmp(in->files[i], file) == 0) {
            reader_refuse(r, node, "expected a file that is not included twice");
            return;
        }
    if (in->count == MOST_FILES) {
        reader_refuse(r, node, "expected at most %d files", MOST_FILES);
        return;
    }
    in->files[in->count++] = file;
    xmlDoc *document = reader_document(r, node, file);
    if (!document) return;
    xmlNode *root = xmlDocGetRootElement(document);
    for (xmlNode *n = xml_child(root, NULL); n && r->status == HAND_OK; n = xml_next(n, NULL)) {
        xmlNode *copy = xmlDocCopyNode(n, node->doc, 1);
        if (!copy || !xmlAddPrevSibling(node, copy)) {
            if (copy) xmlFreeNode(copy);
            reader_no_memory(r);
            break;
        }
        xml_set_file(copy, file);
    }
    xmlFreeDoc(document);
}

/* An included element may stand right behind another <include>, so the search starts again at the first child. */
static void expand(includes *in, xmlNode *node, int depth)
{
    if (depth > 300) reader_refuse(in->r, node, "expected elements that are nested less deeply");
    for (xmlNode *n = xml_child(node, "include"); n && in->r->status == HAND_OK; n = xml_child(node, "include")) {
        insert(in, n);
        xmlUnlinkNode(n);
        xmlFreeNode(n);
    }
    for (xmlNode *n = xml_child(node, NULL); n && in->r->status == HAND_OK; n = xml_next(n, NULL))
        expand(in, n, depth + 1);
}

/* ---- Settings. ---- */

static void read_compiler(mjcf *m, const xmlNode *node)
{
    hand_reader *r = m->r;
    mjcf_compiler *c = &m->compiler;
    mjcf_element e = mjcf_alone(m, node);
    reader_only(
        r, node,
        "autolimits boundmass boundinertia settotalmass balanceinertia strippath coordinate angle fitaabb eulerseq "
        "meshdir texturedir discardvisual usethread fusestatic inertiafromgeom inertiagrouprange saveinertial "
        "assetdir alignfree conflict convexhull exactmeshinertia");
    c->degrees = mjcf_word(&e, "angle", "radian degree", c->degrees) == 1;
    c->autolimits = mjcf_word(&e, "autolimits", "false true", c->autolimits) == 1;
    c->balance = mjcf_word(&e, "balanceinertia", "false true", c->balance) == 1;
    c->strip = mjcf_word(&e, "strippath", "false true", c->strip) == 1;
    c->from_geoms = mjcf_word(&e, "inertiafromgeom", "false true auto", c->from_geoms);
    if (mjcf_word(&e, "coordinate", "local global", 0) == 1)
        reader_refuse(r, node, "global coordinates are not supported");
    if (mjcf_word(&e, "fitaabb", "false true", 0) == 1) reader_refuse(r, node, "fitaabb is not supported");
    reader_number(r, node, "boundmass", &c->bound_mass);
    reader_number(r, node, "boundinertia", &c->bound_inertia);
    reader_number(r, node, "settotalmass", &c->total_mass);
    reader_numbers(r, node, "inertiagrouprange", c->groups, 2, 2);
    if (xml_text(node, "assetdir")) c->meshes = xml_text(node, "assetdir");
    if (xml_text(node, "meshdir")) c->meshes = xml_text(node, "meshdir");
    const char *sequence = xml_text(node, "eulerseq");
    if (!sequence) return;
    double q[4], none[3] = {0};
    if (strlen(sequence) != 3 || !geometry_euler(none, sequence, q))
        reader_refuse(r, node, "expected three of the letters x, y, z, X, Y, Z in eulerseq");
    else
        memcpy(c->sequence, sequence, 4);
}

static void set_total_mass(hand *h, double total)
{
    double sum = 0;
    for (size_t i = 0; i < h->link_count; i++) sum += h->links[i].mass.mass;
    if (!(total > 0) || !(sum > 0)) return;
    for (size_t i = 0; i < h->link_count; i++) {
        h->links[i].mass.mass *= total / sum;
        for (int k = 0; k < 9; k++) h->links[i].mass.inertia[k] *= total / sum;
    }
}

/* ---- Sections. ---- */

typedef void section_reader(mjcf *m, const xmlNode *section);

static void read_sections(mjcf *m, const char *name, section_reader *read)
{
    for (const xmlNode *n = xml_child(m->root, name); n && m->r->status == HAND_OK; n = xml_next(n, name)) read(m, n);
}

static void check_sections(mjcf *m)
{
    static const char read[] = "compiler default asset worldbody contact equality tendon actuator";
    static const char ignored[] = "option size statistic visual custom sensor keyframe extension";
    for (const xmlNode *n = xml_child(m->root, NULL); n && m->r->status == HAND_OK; n = xml_next(n, NULL)) {
        if (xml_listed(ignored, (const char *)n->name))
            reader_ignore(m->r, n, (const char *)n->name);
        else if (xml_is(n, "body"))
            reader_refuse(m->r, n, "expected it in a <worldbody>; a file that has it here is for another to include");
        else if (!xml_listed(read, (const char *)n->name))
            reader_refuse(m->r, n, "not supported; there are %s, and ignored are %s", read, ignored);
    }
}

void mjcf_read(hand_reader *r, xmlNode *root)
{
    includes in = {.r = r, .files = {r->h->file}, .count = 1};
    mjcf m = {.r = r, .root = root};
    m.compiler = (mjcf_compiler){
        .degrees = true, .autolimits = true, .sequence = "xyz", .meshes = "", .from_geoms = 2, .groups = {0, 5}};
    const char *name = xml_text(root, "model");
    r->h->is_mjcf = true;
    r->h->name = reader_text(r, "%s", name ? name : "");
    expand(&in, root, 0);
    if (r->status == HAND_OK) check_sections(&m);
    read_sections(&m, "compiler", read_compiler);
    mjcf_replicate(&m);
    if (r->status == HAND_OK) mjcf_read_defaults(&m);
    if (r->status == HAND_OK) mjcf_read_assets(&m);
    mjcf_count_outermost(&m);
    read_sections(&m, "worldbody", mjcf_read_world);
    if (r->status == HAND_OK) set_total_mass(r->h, m.compiler.total_mass);
    read_sections(&m, "contact", mjcf_read_contacts);
    read_sections(&m, "tendon", mjcf_read_tendons);
    read_sections(&m, "equality", mjcf_read_equalities);
    read_sections(&m, "actuator", mjcf_read_actuators);
    free(m.classes);
    free(m.defaults);
    free(m.meshes);
    free(m.sites);
}
