/* <replicate>: parts of the tree that stand several times, each time moved and turned further. */

#include "mjcf.h"

/* Replicates in replicates multiply; a hand has some hundred elements. */
enum { MOST_ELEMENTS = 100000 };

typedef struct replication {
    mjcf *m;
    size_t elements; /* that all replicates have made */
    /* These belong to the <replicate> that is being copied. */
    const char *separator;
    int count, digits;
    xmlHashTable *names; /* names of a kind that get a suffix in its copies */
} replication;

static const char *suffix_of(replication *t, int index)
{
    return reader_text(t->m->r, "%s%0*d", t->separator, t->digits, index);
}

/* The kind of names that an attribute refers to; NULL: none. */
static const char *kind_of_reference(const char *attribute)
{
    static const char *const kinds[][2] = {{"body", "body body1 body2"},
                                           {"joint", "joint joint1 joint2 jointinparent"},
                                           {"geom", "geom geom1 geom2"},
                                           {"site", "site site1 site2 sidesite cranksite slidersite refsite"},
                                           {"tendon", "tendon tendon1 tendon2"}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (xml_listed(kinds[i][1], attribute)) return kinds[i][0];
    return NULL;
}

static bool is_reference(const replication *t, const xmlNode *node, const xmlAttr *attribute)
{
    const char *name = (const char *)attribute->name, *kind = kind_of_reference(name);
    return kind && xmlHashLookup2(t->names, (const xmlChar *)xml_text(node, name), (const xmlChar *)kind);
}

static bool refers(const replication *t, const xmlNode *node)
{
    for (const xmlAttr *a = node->properties; a; a = a->next)
        if (is_reference(t, node, a)) return true;
    for (const xmlNode *n = xml_child(node, NULL); n; n = xml_next(n, NULL))
        if (refers(t, n)) return true;
    return false;
}

static void add_name(replication *t, const xmlNode *node, const char *kind)
{
    const xmlChar *name = (const xmlChar *)xml_text(node, "name");
    /* A name that stands twice is refused when its copies are read. */
    if (name && !xmlHashLookup2(t->names, name, (const xmlChar *)kind) &&
        xmlHashAddEntry2(t->names, name, (const xmlChar *)kind, t) != 0)
        reader_no_memory(t->m->r);
}

static void collect_names(replication *t, const xmlNode *node)
{
    for (const xmlNode *n = xml_child(node, NULL); n; n = xml_next(n, NULL)) {
        add_name(t, n, (const char *)n->name);
        collect_names(t, n);
    }
}

static void add_suffix(replication *t, xmlNode *node, const char *attribute, const char *suffix)
{
    const char *text = reader_text(t->m->r, "%s%s", xml_text(node, attribute), suffix);
    if (text && !xmlSetProp(node, (const xmlChar *)attribute, (const xmlChar *)text)) reader_no_memory(t->m->r);
}

/* Gives the copy and what is in it the file and the names that it has as a replica. */
static void complete_copy(replication *t, const xmlNode *from, xmlNode *to, const char *suffix)
{
    hand_reader *r = t->m->r;
    to->_private = from->_private;
    if (++t->elements > MOST_ELEMENTS)
        reader_refuse(r, from, "expected replicates of at most %d elements in all", MOST_ELEMENTS);
    for (const xmlAttr *a = to->properties; a && r->status == HAND_OK; a = a->next)
        if (strcmp((const char *)a->name, "name") == 0 || is_reference(t, to, a))
            add_suffix(t, to, (const char *)a->name, suffix);
    const xmlNode *of = xml_child(from, NULL);
    for (xmlNode *n = xml_child(to, NULL); n && of && r->status == HAND_OK; n = xml_next(n, NULL)) {
        complete_copy(t, of, n, suffix);
        of = xml_next(of, NULL);
    }
}

/* Takes the node, which may be NULL, for a place in the document: the last in `parent`, or before `next`. */
static bool place(replication *t, xmlNode *node, xmlNode *parent, xmlNode *next)
{
    if (node && (parent ? xmlAddChild(parent, node) : xmlAddPrevSibling(next, node))) return true;
    if (node) xmlFreeNode(node);
    return reader_no_memory(t->m->r);
}

/* Elements that refer to something in the copies become copies, too, and so does what refers to such a tendon. */
static void replicate_references(replication *t)
{
    static const char *const sections[] = {"tendon", "contact", "equality", "actuator"};
    hand_reader *r = t->m->r;
    for (size_t k = 0; k < sizeof sections / sizeof *sections; k++)
        for (xmlNode *s = xml_child(t->m->root, sections[k]); s; s = xml_next(s, sections[k]))
            for (xmlNode *n = xml_child(s, NULL), *after; n && r->status == HAND_OK; n = after) {
                after = xml_next(n, NULL);
                if (!refers(t, n)) continue;
                for (int i = 0; i < t->count && r->status == HAND_OK; i++) {
                    const char *suffix = suffix_of(t, i);
                    xmlNode *copy = suffix ? xmlDocCopyNode(n, n->doc, 1) : NULL;
                    if (place(t, copy, NULL, n)) complete_copy(t, n, copy, suffix);
                }
                if (k == 0) add_name(t, n, "tendon");
                xmlUnlinkNode(n);
                xmlFreeNode(n);
            }
}

/* A frame with what stands in the <replicate>. */
static void add_replica(replication *t, xmlNode *node, const hand_pose *pose, int index)
{
    hand_reader *r = t->m->r;
    const double *p = pose->position, *q = pose->orientation;
    const char *suffix = suffix_of(t, index), *at = reader_text(r, "%.17g %.17g %.17g", p[0], p[1], p[2]);
    const char *turn = reader_text(r, "%.17g %.17g %.17g %.17g", q[0], q[1], q[2], q[3]);
    xmlNode *frame = turn ? xmlNewDocNode(node->doc, NULL, (const xmlChar *)"frame", NULL) : NULL;
    if (!place(t, frame, NULL, node)) return;
    frame->line = node->line;
    frame->_private = node->_private;
    if (!xmlSetProp(frame, (const xmlChar *)"pos", (const xmlChar *)at) ||
        !xmlSetProp(frame, (const xmlChar *)"quat", (const xmlChar *)turn))
        reader_no_memory(r);
    for (xmlNode *n = xml_child(node, NULL); n && r->status == HAND_OK; n = xml_next(n, NULL)) {
        xmlNode *copy = xmlDocCopyNode(n, n->doc, 1);
        if (place(t, copy, frame, NULL)) complete_copy(t, n, copy, suffix);
    }
}

/* The replica after `index` is further by the offset, as this one sees it. The angles add up, as in MuJoCo: that is one
 * turn after the other only where they are about the same axis. */
static void move_on(mjcf *m, const xmlNode *node, int index, hand_pose *pose)
{
    double offset[3] = {0}, turn[3] = {0}, part = m->compiler.degrees ? SCENE_PI / 180 : 1, moved[3];
    reader_numbers(m->r, node, "offset", offset, 3, 3);
    reader_numbers(m->r, node, "euler", turn, 3, 3);
    pose_point(pose, offset, moved);
    scene_copy(moved, pose->position);
    for (int i = 0; i < 3; i++) turn[i] *= part * (index + 1);
    geometry_euler(turn, m->compiler.sequence, pose->orientation);
}

static void replicate(replication *t, xmlNode *node)
{
    hand_reader *r = t->m->r;
    double count = 0;
    reader_only(r, node, "count sep offset euler");
    if (!reader_number(r, node, "count", &count)) reader_required(r, node, "count");
    if (r->status == HAND_OK && !(count >= 1 && count <= MOST_ELEMENTS && count == floor(count)))
        reader_refuse(r, node, "expected a whole count from 1 to %d, not %g", MOST_ELEMENTS, count);
    hand_pose pose = pose_identity();
    if (r->status != HAND_OK) return;
    t->separator = xml_text(node, "sep") ? xml_text(node, "sep") : "";
    t->count = (int)count;
    t->digits = 1;
    for (int rest = t->count; rest >= 10; rest /= 10) t->digits++;
    t->names = xmlHashCreate(0);
    if (t->names)
        collect_names(t, node);
    else
        reader_no_memory(r);
    for (int i = 0; i < t->count && r->status == HAND_OK; i++) {
        add_replica(t, node, &pose, i);
        move_on(t->m, node, i, &pose);
    }
    if (r->status == HAND_OK) replicate_references(t);
    if (t->names) xmlHashFree(t->names, NULL);
    xmlUnlinkNode(node);
    xmlFreeNode(node);
}

/* The innermost come first, so that their suffixes do. */
static void replicate_below(replication *t, xmlNode *node)
{
    for (xmlNode *n = xml_child(node, NULL), *after; n && t->m->r->status == HAND_OK; n = after) {
        after = xml_next(n, NULL);
        replicate_below(t, n);
        if (t->m->r->status == HAND_OK && xml_is(n, "replicate")) replicate(t, n);
    }
}

void mjcf_replicate(mjcf *m)
{
    replication t = {.m = m};
    for (xmlNode *w = xml_child(m->root, "worldbody"); w; w = xml_next(w, "worldbody")) replicate_below(&t, w);
}
