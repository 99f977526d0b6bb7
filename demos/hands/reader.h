#ifndef PINCH_HANDS_READER_H
#define PINCH_HANDS_READER_H

#include "hand.h"
#include "xml.h"

#include <libxml/hash.h>

/* What the readers of URDF and MJCF share: the hand under construction, the first error, and access to the document.
 * After an error every call does nothing and returns nothing, so a reader looks at the status only where it would go on
 * for long. */
typedef struct hand_reader {
    hand *h;
    const hand_package *packages;
    size_t package_count;
    hand_status status;
    hand_error *error;
    xmlHashTable *names; /* of a kind: 1 + the place in its list */
} hand_reader;

/* Appends a zeroed item to a list of the hand; NULL when memory runs out. `items` is the address of the list. */
void *reader_append(hand_reader *r, void *items, size_t *count, size_t size);
/* A text that lives as long as the hand. */
char *reader_text(hand_reader *r, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Sets the error "FILE:LINE: <ELEMENT name="...">: ..." and returns false. */
bool reader_refuse(hand_reader *r, const xmlNode *at, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* "FILE:LINE: ..." for a text that is no document. */
bool reader_refuse_line(hand_reader *r, int line, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* As reader_refuse, for a link that has been read. */
bool reader_refuse_link(hand_reader *r, const hand_link *link, const char *what);
bool reader_no_memory(hand_reader *r);
/* Takes an error back that was found in a part of `at` which changes nothing of the physics: it becomes the remark
 * "WHAT: ..." of what is ignored. Returns whether there was one. */
bool reader_forgive(hand_reader *r, const xmlNode *at, const char *what);

/* The name of the new item `index` of a kind, from the element's attribute; KIND_INDEX where it has none. A name that
 * another item of the kind has is refused. */
char *reader_name(hand_reader *r, const xmlNode *node, const char *kind, size_t index);
/* The item of that kind and name; -1 where there is none. */
int reader_find(hand_reader *r, const char *kind, const char *name);

/* Adds one to the remark `what` about the element; its line where it is new. */
void reader_ignore(hand_reader *r, const xmlNode *at, const char *what);
void reader_unmodelled(hand_reader *r, const xmlNode *at, const char *what);
void reader_unmodelled_link(hand_reader *r, const hand_link *link, const char *what);

/* The document of a file. Its elements know the file, for errors. `at` is the element that asks for it, NULL for the
 * first. NULL after an error. Free it with xmlFreeDoc. */
xmlDoc *reader_document(hand_reader *r, const xmlNode *at, const char *file);
/* attributes.c: the attribute as text, an error where it is not there or empty. */
const char *reader_required(hand_reader *r, const xmlNode *node, const char *name);
/* `least` to `most` numbers in the attribute. Returns how many there are and sets as many values. 0: no attribute. */
size_t reader_numbers(hand_reader *r, const xmlNode *node, const char *name, double *values, size_t least, size_t most);
bool reader_number(hand_reader *r, const xmlNode *node, const char *name, double *value);
/* Refuses an attribute that is not among the words of the list. */
bool reader_only(hand_reader *r, const xmlNode *node, const char *list);
/* The item of the kind that the attribute names. Where it is missing or names none, that is an error, and -1. */
int reader_refer(hand_reader *r, const xmlNode *node, const char *attribute, const char *kind);

/* DIRECTORY of `from` with the path `name`; `name` itself where it is absolute. */
char *reader_path(hand_reader *r, const char *from, const char *name);

#endif
