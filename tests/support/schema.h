#ifndef PINCH_TEST_SCHEMA_H
#define PINCH_TEST_SCHEMA_H

#include <jansson.h>

/* Prints where `document` does not follow the JSON Schema, and returns in how many places. It knows as much of the
 * language as this project's schemas use: $ref into $defs, anyOf, const, enum, type, properties, required,
 * additionalProperties, items. */
int schema_faults(const json_t *schema, const json_t *document);

#endif
