#ifndef PINCH_TEST_SCHEMA_H
#define PINCH_TEST_SCHEMA_H

#include <jansson.h>

/* Does `document` follow the JSON Schema? As much of the language as this project's schemas use: $ref into $defs,
 * anyOf, const, enum, type, properties, required, additionalProperties, items. Prints what does not; returns how many.
 */
int schema_faults(const json_t *schema, const json_t *document);

#endif
