/* Compares assets/schema/pinch-scene-1.json with what the loader takes. */

#include "support/cmocka_all.h"

#include "scenes/file/reader.h"

#include <jansson.h>
#include <string.h>

static json_t *load_schema(void)
{
    json_error_t error;
    json_t *schema =
        json_load_file(PINCH_SOURCE_DIR "/assets/schema/pinch-scene-1.json", JSON_REJECT_DUPLICATES, &error);
    if (!schema) fail_msg("line %d: %s", error.line, error.text);
    return schema;
}

static bool is_required(const json_t *definition, const char *name)
{
    size_t i;
    json_t *entry;
    json_array_foreach(json_object_get(definition, "required"), i, entry)
    {
        if (strcmp(json_string_value(entry), name) == 0) return true;
    }
    return false;
}

static void test_keys_agree(void **state)
{
    (void)state;
    json_t *schema = load_schema();
    for (size_t i = 0; i < scene_kind_count(); i++) {
        const scene_kind *kind = scene_kind_at(i);
        json_t *definition =
            strcmp(kind->name, "scene") == 0 ? schema : json_object_get(json_object_get(schema, "$defs"), kind->name);
        json_t *properties = json_object_get(definition, "properties");
        if (!properties) fail_msg("the schema does not define %s", kind->name);
        if (json_object_size(properties) != kind->count) fail_msg("%s: not as many keys as the schema", kind->name);
        size_t required = 0;
        for (size_t k = 0; k < kind->count; k++) {
            const scene_key *key = &kind->keys[k];
            if (!json_object_get(properties, key->name)) fail_msg("%s.%s: not in the schema", kind->name, key->name);
            if (is_required(definition, key->name) != key->required)
                fail_msg("%s.%s: required in one of schema and loader", kind->name, key->name);
            required += key->required;
        }
        assert_int_equal(json_array_size(json_object_get(definition, "required")), required);
    }
    json_decref(schema);
}

/* the other way around: every closed object of the schema is one the loader knows */
static void test_no_other_objects(void **state)
{
    (void)state;
    json_t *schema = load_schema();
    const char *name;
    json_t *definition;
    json_object_foreach(json_object_get(schema, "$defs"), name, definition)
    {
        bool is_object = json_object_get(definition, "properties") && json_object_get(definition, "type");
        if (is_object && !scene_kind_named(name)) fail_msg("the loader knows no %s", name);
    }
    json_decref(schema);
}

/* What an object is made of hangs together: a key that the loader refuses alone needs the same one by the schema. */
static void test_material_of_an_object(void **state)
{
    (void)state;
    static const char *const keys[] = {"damping", "friction"};
    json_t *schema = load_schema(), *object = json_object_get(json_object_get(schema, "$defs"), "object"),
           *needs = json_object_get(object, "dependentRequired");
    assert_int_equal(json_object_size(needs), 2);
    for (int i = 0; i < 2; i++) {
        const json_t *needed = json_object_get(needs, keys[i]);
        assert_string_equal(json_string_value(json_array_get(needed, 0)), "stiffness");
        json_t *value = i == 0 ? json_object() : json_real(0.2);
        json_t *document = json_pack("{s:s, s:{s:{s:s, s:f}, s:f, s:o}, s:[{s:s, s:[f,f,f], s:[f,f,f], s:s, s:{s:f}}]}",
                                     "format", "pinch-scene/1", "object", "shape", "type", "sphere", "radius", 1.0,
                                     "mass", 1.0, keys[i], value, "fingers", "name", "f", "point", 0.0, 0.0, 1.0,
                                     "normal", 0.0, 0.0, -1.0, "model", "frictionless", "stiffness", "normal", 1.0);
        scene *s;
        scene_error error;
        assert_int_equal(scene_load_document("s", "", 0, document, &s, &error), SCENE_BAD_INPUT);
        assert_non_null(strstr(error.text, "object.stiffness: expected this key with damping or friction"));
        assert_int_equal(
            json_object_set_new(json_object_get(document, "object"), "stiffness", json_pack("{s:f}", "normal", 1.0)),
            0);
        assert_int_equal(scene_load_document("s", "", 0, document, &s, &error), SCENE_OK);
        scene_free(s);
        json_decref(document);
    }
    json_decref(schema);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_keys_agree),
        cmocka_unit_test(test_no_other_objects),
        cmocka_unit_test(test_material_of_an_object),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
