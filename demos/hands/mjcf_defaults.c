/* Default classes, and attributes that may come from them. */

#include "mjcf.h"

static int find_class(const mjcf *m, const char *name)
{
    for (size_t i = 0; i < m->class_count; i++)
        if (strcmp(m->classes[i].name, name) == 0) return (int)i;
    return -1;
}

static void read_class(mjcf *m, xmlNode *node, int parent)
{
    hand_reader *r = m->r;
    const char *name = xml_text(node, "class");
    reader_only(r, node, "class");
    if (r->status != HAND_OK) return;
    int class = 0;
    if (parent < 0) {
        if (name && strcmp(name, "main") != 0 && *name) {
            reader_refuse(r, node, "expected the outermost class to be called \"main\", not \"%.100s\"", name);
            return;
        }
    } else {
        if (!name || !*name || find_class(m, name) >= 0) {
            reader_refuse(r, node, "expected an attribute class with a name that no other class has");
            return;
        }
        class = (int)m->class_count;
        mjcf_class *item = reader_append(r, &m->classes, &m->class_count, sizeof *item);
        if (item) *item = (mjcf_class){.name = name, .parent = parent};
    }
    for (xmlNode *child = xml_child(node, NULL); child && r->status == HAND_OK; child = xml_next(child, NULL)) {
        if (xml_is(child, "default")) continue;
        mjcf_default *item = reader_append(r, &m->defaults, &m->default_count, sizeof *item);
        if (item) *item = (mjcf_default){.class = class, .node = child};
    }
    for (xmlNode *child = xml_child(node, "default"); child && r->status == HAND_OK; child = xml_next(child, "default"))
        read_class(m, child, class);
}

void mjcf_read_defaults(mjcf *m)
{
    mjcf_class *main_class = reader_append(m->r, &m->classes, &m->class_count, sizeof *main_class);
    if (main_class) *main_class = (mjcf_class){.name = "main", .parent = -1};
    for (xmlNode *n = xml_child(m->root, "default"); n && m->r->status == HAND_OK; n = xml_next(n, "default"))
        read_class(m, n, -1);
}

mjcf_element mjcf_alone(mjcf *m, const xmlNode *node)
{
    return (mjcf_element){.m = m, .node = node, .levels = {node}, .count = 1};
}

/* The levels of a class: those of the class above it first. */
static bool add_levels(mjcf_element *e, int class, const char *tags)
{
    mjcf *m = e->m;
    int chain[MJCF_MOST_LEVELS], length = 0;
    for (; class >= 0; class = m->classes[class].parent) {
        if (length == MJCF_MOST_LEVELS) return false;
        chain[length++] = class;
    }
    while (length-- > 0)
        for (size_t i = 0; i < m->default_count; i++) {
            const mjcf_default *d = &m->defaults[i];
            if (d->class != chain[length] || !xml_listed(tags, (const char *)d->node->name)) continue;
            if (e->count == MJCF_MOST_LEVELS - 1) return false;
            e->levels[e->count++] = d->node;
        }
    return true;
}

bool mjcf_open(mjcf *m, const xmlNode *node, const char *childclass, const char *tags, mjcf_element *e)
{
    const char *name = xml_text(node, "class");
    *e = (mjcf_element){.m = m, .node = node};
    if (m->r->status != HAND_OK) return false;
    if (!name) name = childclass;
    int class = name ? find_class(m, name) : 0;
    if (class < 0) return reader_refuse(m->r, node, "expected the name of a default class, not \"%.100s\"", name);
    if (!add_levels(e, class, tags))
        return reader_refuse(m->r, node, "expected fewer defaults: at most %d apply to one element", MJCF_MOST_LEVELS);
    e->levels[e->count++] = node;
    return true;
}

bool mjcf_only(const mjcf_element *e, const char *list)
{
    for (int i = 0; i < e->count; i++)
        if (!reader_only(e->m->r, e->levels[i], list)) return false;
    return true;
}

const char *mjcf_text(const mjcf_element *e, const char *name)
{
    for (int i = e->count - 1; i >= 0; i--) {
        const char *text = xml_text(e->levels[i], name);
        if (text) return text;
    }
    return NULL;
}

size_t mjcf_numbers(const mjcf_element *e, const char *name, double *values, size_t least, size_t most)
{
    size_t longest = 0;
    for (int i = 0; i < e->count; i++) {
        const char *text = xml_text(e->levels[i], name);
        /* MuJoCo takes an attribute without a number for one that is not there. */
        if (text && !text[strspn(text, " \t\r\n")]) continue;
        size_t count = reader_numbers(e->m->r, e->levels[i], name, values, least, most);
        if (count > longest) longest = count;
    }
    return longest;
}

int mjcf_word(const mjcf_element *e, const char *name, const char *list, int otherwise)
{
    const char *text = mjcf_text(e, name);
    if (!text) return otherwise;
    int place = 0;
    for (const char *word = list; *word; place++) {
        size_t length = strcspn(word, " ");
        if (strlen(text) == length && strncmp(word, text, length) == 0) return place;
        word += length + (word[length] == ' ');
    }
    reader_refuse(e->m->r, e->node, "expected one of %s in %s, not \"%.100s\"", list, name, text);
    return otherwise;
}

bool mjcf_is_limited(const mjcf_element *e, const char *limited, bool has_range, const double range[2])
{
    int word = mjcf_word(e, limited, "false true auto", 2);
    bool whole = has_range && (range[0] != 0 || range[1] != 0);
    if (word == 2 && whole && !e->m->compiler.autolimits)
        reader_refuse(e->m->r, e->node,
                      "expected %s=\"true\" or \"false\" beside the range: the compiler's autolimits is "
                      "false",
                      limited);
    if (word == 2 && range[0] > range[1]) reader_ignore(e->m->r, e->node, "range with the larger number first");
    if (word == 2) return whole && range[0] < range[1];
    if (word == 1 && !(range[0] < range[1]))
        reader_refuse(e->m->r, e->node, "expected a range with the lower number first, because %s is true", limited);
    return word == 1;
}
