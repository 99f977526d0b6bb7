#include "support/schema.h"

#include "support/cmocka_all.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static int faults(const json_t *root, const json_t *schema, const json_t *value, const char *place, bool quiet);

static int fault(const char *place, const char *what, bool quiet)
{
    if (!quiet) print_error("%s: %s\n", place, what);
    return 1;
}

static bool has_type(const char *type, const json_t *value)
{
    if (strcmp(type, "object") == 0) return json_is_object(value);
    if (strcmp(type, "array") == 0) return json_is_array(value);
    if (strcmp(type, "string") == 0) return json_is_string(value);
    if (strcmp(type, "number") == 0) return json_is_number(value);
    if (strcmp(type, "integer") == 0) return json_is_integer(value);
    if (strcmp(type, "boolean") == 0) return json_is_boolean(value);
    return strcmp(type, "null") == 0 && json_is_null(value);
}

static bool type_fits(const json_t *type, const json_t *value)
{
    if (!type) return true;
    if (json_is_string(type)) return has_type(json_string_value(type), value);
    for (size_t i = 0; i < json_array_size(type); i++)
        if (has_type(json_string_value(json_array_get(type, i)), value)) return true;
    return false;
}

static bool is_one_of(const json_t *list, const json_t *value)
{
    for (size_t i = 0; i < json_array_size(list); i++)
        if (json_equal(json_array_get(list, i), value)) return true;
    return false;
}

static int object_faults(const json_t *root, const json_t *schema, const json_t *value, const char *place, bool quiet)
{
    const json_t *properties = json_object_get(schema, "properties"), *required = json_object_get(schema, "required"),
                 *others = json_object_get(schema, "additionalProperties");
    const char *key;
    json_t *member;
    char at[1024];
    int count = 0;
    for (size_t i = 0; i < json_array_size(required); i++)
        if (!json_object_get(value, json_string_value(json_array_get(required, i))))
            count += fault(place, json_string_value(json_array_get(required, i)), quiet);
    json_object_foreach((json_t *)value, key, member)
    {
        const json_t *known = json_object_get(properties, key);
        snprintf(at, sizeof at, "%.900s.%.100s", place, key);
        if (known)
            count += faults(root, known, member, at, quiet);
        else if (json_is_false(others))
            count += fault(at, "is not documented", quiet);
        else if (json_is_object(others))
            count += faults(root, others, member, at, quiet);
    }
    return count;
}

static int faults(const json_t *root, const json_t *schema, const json_t *value, const char *place, bool quiet)
{
    static const char DEFS[] = "#/$defs/";
    const char *reference = json_string_value(json_object_get(schema, "$ref"));
    if (reference) {
        assert_true(strncmp(reference, DEFS, strlen(DEFS)) == 0);
        const json_t *definition = json_object_get(json_object_get(root, "$defs"), reference + strlen(DEFS));
        assert_non_null(definition);
        return faults(root, definition, value, place, quiet);
    }
    const json_t *any = json_object_get(schema, "anyOf"), *constant = json_object_get(schema, "const"),
                 *list = json_object_get(schema, "enum"), *items = json_object_get(schema, "items");
    for (size_t i = 0; i < json_array_size(any); i++)
        if (faults(root, json_array_get(any, i), value, place, true) == 0) return 0;
    if (any) return fault(place, "is none of those allowed", quiet);
    if (constant && !json_equal(constant, value)) return fault(place, "is not the constant", quiet);
    if (list && !is_one_of(list, value)) return fault(place, "is not in the list", quiet);
    if (!type_fits(json_object_get(schema, "type"), value)) return fault(place, "has another type", quiet);
    if (json_is_object(value)) return object_faults(root, schema, value, place, quiet);
    int count = 0;
    for (size_t i = 0; i < json_array_size(value) && items; i++) {
        char at[1024];
        snprintf(at, sizeof at, "%.900s[%zu]", place, i);
        count += faults(root, items, json_array_get(value, i), at, quiet);
    }
    return count;
}

int schema_faults(const json_t *schema, const json_t *document)
{
    return faults(schema, schema, document, "$", false);
}
