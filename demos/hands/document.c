/* Reading a document, by libxml2. */

#include "common/input_file.h"
#include "reader.h"

#include <libxml/parser.h>
#include <stdlib.h>
#include <string.h>

/* A hand has some hundred elements. */
static const size_t MAX_BYTES = (size_t)64 << 20;

/* libxml2 takes a zero byte for the end, and would pass over all that follows it. Characters of two bytes, which the
 * first two bytes tell, have zero bytes of their own. */
static bool has_zero_byte(const char *text, size_t length)
{
    bool wide =
        length > 1 && (!text[0] || !text[1] || memcmp(text, "\xff\xfe", 2) == 0 || memcmp(text, "\xfe\xff", 2) == 0);
    return !wide && memchr(text, '\0', length);
}

static char *read_all(hand_reader *r, const xmlNode *at, const char *file, size_t *length)
{
    char fault[128], *text = NULL;
    FILE *stream = input_open_regular(file, fault);
    input_status status = *fault ? INPUT_REFUSED : INPUT_NO_MEMORY;
    if (stream) status = input_read(stream, MAX_BYTES, &text, length, fault);
    if (status == INPUT_NO_MEMORY) reader_no_memory(r);
    if (status == INPUT_REFUSED)
        reader_refuse(r, at, "expected a readable file%s%s: %s", at ? " " : "", at ? file : "", fault);
    if (status != INPUT_READ || !has_zero_byte(text, *length)) return text;
    reader_refuse(r, at, "expected an XML document%s%s without a zero byte", at ? " in " : "", at ? file : "");
    free(text);
    return NULL;
}

static void reverse(char *first, char *last)
{
    while (first < last) {
        char c = *first;
        *first++ = *--last;
        *last = c;
    }
}

/* Published files have white space before the XML declaration, or version 0.0 in it, and other readers take both. The
 * declaration goes first, and the white space behind it, so that lines keep their numbers. */
static void mend_declaration(char *text)
{
    static const char BLANK[] = " \t\r\n";
    char *start = text + strspn(text, BLANK), *end = NULL;
    if (strncmp(start, "<?xml", 5) == 0 && strchr(BLANK, start[5])) end = strstr(start, "?>");
    if (!end) return;
    char *version = strstr(start, "version");
    if (version && version < end) {
        version += strlen("version");
        version += strspn(version, BLANK);
        if (*version == '=') version += 1 + strspn(version + 1, BLANK);
        if (strncmp(version, "\"0.0\"", 5) == 0 || strncmp(version, "'0.0'", 5) == 0) version[1] = '1';
    }
    reverse(text, start);
    reverse(start, end + 2);
    reverse(text, end + 2);
}

static void refuse_document(hand_reader *r, const xmlNode *at, const char *file, xmlParserCtxt *parser)
{
    const xmlError *found = xmlCtxtGetLastError(parser);
    const char *message = found && found->message ? found->message : "no document";
    int line = found ? found->line : 0;
    if (found && found->code == XML_ERR_NO_MEMORY)
        reader_no_memory(r);
    else if (at)
        reader_refuse(r, at, "expected an XML document in %s, but line %d has: %s", file, line, message);
    else
        reader_refuse_line(r, line, "expected an XML document: %s", message);
}

xmlDoc *reader_document(hand_reader *r, const xmlNode *at, const char *file)
{
    size_t length;
    char *text = r->status == HAND_OK ? read_all(r, at, file, &length) : NULL;
    if (!text) return NULL;
    mend_declaration(text);
    xmlParserCtxt *parser = xmlNewParserCtxt();
    char *name = reader_text(r, "%s", file),
         **listed = reader_append(r, &r->h->files, &r->h->file_count, sizeof *listed);
    xmlDoc *document = NULL;
    if (listed) *listed = name;
    if (parser && name && listed) {
        /* No network, no files: nothing but this text is read. */
        document = xmlCtxtReadMemory(parser, text, (int)length, NULL, NULL,
                                     XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING | XML_PARSE_NOCDATA |
                                         XML_PARSE_BIG_LINES);
        if (!document) refuse_document(r, at, file, parser);
    } else {
        reader_no_memory(r);
    }
    free(text);
    if (document && (document->intSubset || !xmlDocGetRootElement(document))) {
        reader_refuse(r, at, "expected a document without a document type, in %s", file);
        xmlFreeDoc(document);
        document = NULL;
    }
    if (document) xml_set_file(xmlDocGetRootElement(document), name);
    if (parser) xmlFreeParserCtxt(parser);
    return document;
}
