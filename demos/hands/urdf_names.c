/* Names in a URDF file that URDF does not have, and elements that stand twice. */

#include "formats.h"

#include <stdlib.h>

/* The attributes of an element. Where some may be left out, one that URDF does not have may be meant for one of these.
 * `more` are in use, and say more of the physics than is modelled, unless they are 0. */
typedef struct urdf_element {
    const char *name, *attributes, *more;
    bool may_be_left_out;
} urdf_element;

static const urdf_element elements[] = {
    {"robot", "name version", "", false},
    {"link", "name", "", false},
    {"joint", "name type", "", false},
    {"inertial", "", "", false},
    {"collision", "name", "", false},
    {"visual", "name", "", false},
    {"geometry", "", "", false},
    {"parent", "link", "", false},
    {"child", "link", "", false},
    {"axis", "xyz", "", false},
    {"mass", "value", "", false},
    {"inertia", "ixx ixy ixz iyy iyz izz", "", false},
    {"box", "size", "", false},
    {"sphere", "radius", "", false},
    {"cylinder", "radius length", "", false},
    {"capsule", "radius length", "", false},
    {"origin", "xyz rpy", "", true},
    {"mesh", "filename scale", "", true},
    {"limit", "lower upper effort velocity", "acceleration deceleration jerk", true},
    {"dynamics", "damping friction", "spring_stiffness", true},
    {"mimic", "joint multiplier offset", "", true},
};

static const urdf_element *find_element(const xmlNode *node)
{
    for (size_t i = 0; i < sizeof elements / sizeof *elements; i++)
        if (xml_is(node, elements[i].name)) return &elements[i];
    return NULL;
}

/* What is in a picture, and what says how a fixed joint moves, changes nothing. */
static bool changes_the_physics(const xmlNode *node)
{
    const xmlNode *outer = node->parent;
    if (xml_is(outer, "joint") && !xml_is(node, "origin")) {
        const char *type = xml_text(outer, "type");
        return !type || strcmp(type, "fixed") != 0;
    }
    for (; outer && outer->type == XML_ELEMENT_NODE; outer = outer->parent)
        if (xml_is(outer, "visual")) return false;
    return true;
}

static void check_attribute(hand_reader *r, const xmlNode *node, const urdf_element *element, const xmlAttr *attribute)
{
    const char *name = (const char *)attribute->name;
    if (attribute->ns || strchr(name, ':') || xml_listed(element->attributes, name)) return;
    bool rest = xml_is(node, "dynamics") && strcmp(name, "spring_reference") == 0; /* nothing without a stiffness */
    bool matters = element->may_be_left_out && !rest && changes_the_physics(node);
    const char *text = reader_text(r, "attribute %s of <%s>", name, element->name);
    if (!text) return;
    if (matters && xml_listed(element->more, name)) {
        if (strtod(xml_text(node, name), NULL) != 0) reader_unmodelled(r, node, text);
    } else if (matters) {
        reader_refuse(r, node, "unknown attribute %.60s; there are %s", name, element->attributes);
    } else {
        reader_ignore(r, node, text);
    }
}

/* Elements of other names have attributes of their own, which are not looked at. The depth is that of the document,
 * which libxml2 bounds. */
void urdf_check_attributes(hand_reader *r, const xmlNode *node)
{
    const urdf_element *element = find_element(node);
    if (!element) return;
    for (const xmlAttr *a = node->properties; a && r->status == HAND_OK; a = a->next)
        check_attribute(r, node, element, a);
    for (const xmlNode *child = xml_child(node, NULL); child && r->status == HAND_OK; child = xml_next(child, NULL))
        urdf_check_attributes(r, child);
}

void urdf_list_rest(hand_reader *r, const xmlNode *node, const char *names)
{
    for (const xmlNode *child = xml_child(node, NULL); child && r->status == HAND_OK; child = xml_next(child, NULL))
        if (!xml_listed(names, (const char *)child->name)) reader_ignore(r, child, (const char *)child->name);
    urdf_list_repeated(r, node, names);
}

void urdf_list_repeated(hand_reader *r, const xmlNode *node, const char *names)
{
    for (const xmlNode *child = xml_child(node, NULL); child && r->status == HAND_OK; child = xml_next(child, NULL)) {
        const char *name = (const char *)child->name;
        bool again = xml_listed(names, name) && xml_child(node, name) != child;
        const char *text = again ? reader_text(r, "second %s", name) : NULL;
        if (text) reader_ignore(r, child, text);
    }
}
