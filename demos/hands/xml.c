/* Elements and attributes of a document. */

#include "xml.h"

#include <string.h>

const char *xml_file(const xmlNode *node)
{
    return node->_private ? node->_private : "";
}

bool xml_is(const xmlNode *node, const char *name)
{
    return strcmp((const char *)node->name, name) == 0;
}

static xmlNode *first_element(xmlNode *node, const char *name)
{
    while (node && (node->type != XML_ELEMENT_NODE || (name && !xml_is(node, name)))) node = node->next;
    return node;
}

xmlNode *xml_child(const xmlNode *node, const char *name)
{
    return first_element(node->children, name);
}

xmlNode *xml_next(const xmlNode *node, const char *name)
{
    return first_element(node->next, name);
}

bool xml_listed(const char *list, const char *name)
{
    size_t length = strlen(name);
    for (const char *at = list; length && (at = strstr(at, name)); at++)
        if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0')) return true;
    return false;
}

/* Without a document type an attribute has a single text, or none where it is empty. */
const char *xml_text(const xmlNode *node, const char *name)
{
    for (const xmlAttr *a = node->properties; a; a = a->next)
        if (strcmp((const char *)a->name, name) == 0)
            return a->children && a->children->content ? (const char *)a->children->content : "";
    return NULL;
}

/* The depth is that of the document, which libxml2 bounds. */
void xml_set_file(xmlNode *node, char *file)
{
    node->_private = file;
    for (xmlNode *child = xml_child(node, NULL); child; child = xml_next(child, NULL)) xml_set_file(child, file);
}
