#ifndef PINCH_HANDS_XML_H
#define PINCH_HANDS_XML_H

#include <libxml/tree.h>
#include <stdbool.h>

/* Elements and attributes of a document that reader_document has read. */

/* The file of the element, and setting it for the element and all in it. */
const char *xml_file(const xmlNode *node);
void xml_set_file(xmlNode *node, char *file);

/* The first child element of that name (NULL: of any), and the next one after `node`. NULL where there is none. */
xmlNode *xml_child(const xmlNode *node, const char *name);
xmlNode *xml_next(const xmlNode *node, const char *name);
bool xml_is(const xmlNode *node, const char *name);
/* Is `name` one of the words of the list, which are separated by blanks? */
bool xml_listed(const char *list, const char *name);

/* The attribute; NULL where it is not there. It lives as long as the document. */
const char *xml_text(const xmlNode *node, const char *name);

#endif
