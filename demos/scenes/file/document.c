/* Reads a JSON document as a whole, and says where it is none. */
#include "locate.h"
#include "reader.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* A scene has kilobytes. This limit stops /dev/zero. */
static const size_t MAX_FILE_BYTES = (size_t)64 << 20;

static bool refuse_unreadable(scene_reader *reader)
{
    if (errno == ENOMEM) return scene_refuse_memory(reader);
    return scene_refuse_file(reader, " expected a readable %s: %s", reader->what, strerror(errno));
}

/* Reads until the end and not by size, because a document may come out of a pipe. */
static bool read_stream(scene_reader *reader, FILE *stream, char **text)
{
    size_t capacity = 0;
    for (;;) {
        if (reader->length == capacity) {
            capacity = capacity ? 2 * capacity : (size_t)1 << 16;
            char *larger = realloc(*text, capacity);
            if (!larger) return scene_refuse_memory(reader);
            *text = larger;
        }
        size_t got = fread(*text + reader->length, 1, capacity - reader->length, stream);
        if (got == 0) break;
        reader->length += got;
        if (reader->length > MAX_FILE_BYTES)
            return scene_refuse_file(reader, " expected a %s of at most 64 MiB", reader->what);
    }
    reader->text = *text;
    if (ferror(stream)) return refuse_unreadable(reader);
    return true;
}

static bool read_text(scene_reader *reader, char **text)
{
    FILE *stream = fopen(reader->file, "rb");
    if (!stream) return refuse_unreadable(reader);
    bool good = read_stream(reader, stream, text);
    fclose(stream);
    return good;
}

static bool parse(scene_reader *reader, json_t **document)
{
    json_error_t fault;
    *document = json_loadb(reader->text, reader->length, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &fault);
    if (*document) return true;
    char path[256];
    size_t offset = fault.position > 0 ? (size_t)fault.position : 0;
    scene_locate_path(reader->text, reader->length, offset, path, sizeof path);
    const char *where = *path ? path : "(top level)";
    int line = fault.line > 0 ? fault.line : 1;
    switch (json_error_code(&fault)) {
    case json_error_out_of_memory:
        return scene_refuse_memory(reader);
    case json_error_duplicate_key:
        return scene_refuse_file(reader, "%d: %s: expected each key once, got it twice", line, where);
    case json_error_numeric_overflow:
        return scene_refuse_file(reader, "%d: %s: expected a finite number: %s", line, where, fault.text);
    default:
        return scene_refuse_file(reader, "%d: %s: expected valid JSON: %s", line, where, fault.text);
    }
}

bool scene_read_document(scene_reader *reader, char **text, json_t **document)
{
    return read_text(reader, text) && parse(reader, document);
}
