#include "support/cli.h"

#include "support/cmocka_all.h"

#include <stdio.h>
#include <string.h>

program_result cli_run(const char *folder, const char *const arguments[])
{
    char executable[] = PINCH_EXECUTABLE, text[12][512];
    char *argv[13] = {executable};
    int count = 0;
    for (; arguments[count]; count++) {
        assert_true(count < 11);
        snprintf(text[count], sizeof text[count], "%s", arguments[count]);
        argv[1 + count] = text[count];
    }
    argv[1 + count] = NULL;
    return program_run(folder, argv);
}

json_t *cli_document(const program_result *r)
{
    json_error_t error;
    json_t *document = json_loads(r->out, 0, &error);
    if (!document) fail_msg("%s\n%s", error.text, r->out);
    assert_true(json_is_object(document));
    return document;
}

void cli_refused(program_result r, int status, const char *says)
{
    if (r.status != status || *r.out || !strstr(r.err, says))
        fail_msg("status %d (wanted %d), said \"%s\" (wanted \"%s\"), printed \"%s\"", r.status, status, r.err, says,
                 r.out);
    program_free(&r);
}

const json_t *cli_at(const json_t *document, const char *path)
{
    char key[64];
    const char *dot = strchr(path, '.');
    if (!dot) return json_object_get(document, path);
    snprintf(key, sizeof key, "%.*s", (int)(dot - path), path);
    return cli_at(json_object_get(document, key), dot + 1);
}

bool cli_is_vector(const json_t *value, size_t length)
{
    if (json_array_size(value) != length) return false;
    for (size_t i = 0; i < length; i++)
        if (!json_is_number(json_array_get(value, i))) return false;
    return true;
}
