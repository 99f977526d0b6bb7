#define _POSIX_C_SOURCE 200809L

/* Reads a JSON document as a whole, and says where it is none. */
#include "common/input_file.h"
#include "locate.h"
#include "reader.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

/* A scene has kilobytes. This limit stops /dev/zero. */
static const size_t MAX_FILE_BYTES = (size_t)64 << 20;

/* What a list or an object, and a value in it, take once they are parsed; and how much of that a document may take. */
static const size_t LIST_BYTES = 256, VALUE_BYTES = 64, MAX_VALUE_BYTES = (size_t)1 << 30;

static bool refuse_unreadable(scene_reader *reader, const char *fault)
{
    return scene_refuse_file(reader, " expected a readable %s: %s", reader->what, fault);
}

/* JSON has no byte order mark, but editors write one, and do not show it. */
static void drop_byte_order_mark(char *text, size_t *length)
{
    static const char BYTE_ORDER_MARK[] = "\xEF\xBB\xBF";
    size_t mark = sizeof BYTE_ORDER_MARK - 1;
    if (*length < mark || memcmp(text, BYTE_ORDER_MARK, mark) != 0) return;
    *length -= mark;
    memmove(text, text + mark, *length + 1); /* with the zero byte behind it */
}

/* A copy, as what is opened here is closed again. */
static FILE *open_standard_input(void)
{
    int descriptor = dup(STDIN_FILENO);
    FILE *stream = descriptor < 0 ? NULL : fdopen(descriptor, "rb");
    if (!stream && descriptor >= 0) close(descriptor);
    return stream;
}

static bool read_text(scene_reader *reader, char **text)
{
    char fault[128];
    FILE *stream = reader->is_standard_input ? open_standard_input() : input_open(reader->file);
    if (!stream) return errno == ENOMEM ? scene_refuse_memory(reader) : refuse_unreadable(reader, strerror(errno));
    input_status status = input_read(stream, MAX_FILE_BYTES, text, &reader->length, fault);
    if (status == INPUT_READ) drop_byte_order_mark(*text, &reader->length);
    reader->text = *text;
    if (status == INPUT_NO_MEMORY) return scene_refuse_memory(reader);
    return status == INPUT_READ || refuse_unreadable(reader, fault);
}

/* Lists in lists take two characters each in the file, and a hundred times that in memory. */
static bool check_memory(scene_reader *reader)
{
    size_t need = 0;
    bool in_string = false;
    for (size_t i = 0; i < reader->length; i++) {
        char c = reader->text[i];
        if (c == '"') in_string = !in_string;
        if (c == '\\' && in_string) i++;
        if (!in_string && (c == '[' || c == '{')) need += LIST_BYTES;
        if (!in_string && c == ',') need += VALUE_BYTES;
    }
    if (need <= MAX_VALUE_BYTES) return true;
    return scene_refuse_file(reader, " expected a %s whose lists and values fit into %zu MiB of memory", reader->what,
                             MAX_VALUE_BYTES >> 20);
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
        return scene_refuse_file(reader, "%d: %s: expected valid JSON: %s", line, where, input_json_fault(&fault));
    }
}

bool scene_read_document(scene_reader *reader, char **text, json_t **document)
{
    return read_text(reader, text) && check_memory(reader) && parse(reader, document);
}
