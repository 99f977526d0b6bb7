#include "utf8.h"

#include <stdlib.h>
#include <string.h>

int utf8_read(const char *text, unsigned long *character)
{
    static const unsigned long least[] = {1, 0x80, 0x800, 0x10000}; /* shorter ways to write a character exist below */
    const unsigned char *t = (const unsigned char *)text;
    int more = t[0] < 0x80 ? 0 : t[0] < 0xe0 ? 1 : t[0] < 0xf0 ? 2 : 3;
    if (t[0] >= 0x80 && (t[0] < 0xc2 || t[0] > 0xf4)) return 0;
    unsigned long code = more == 0 ? t[0] : t[0] & (0x3fu >> more);
    for (int i = 1; i <= more; i++) {
        if ((t[i] & 0xc0) != 0x80) return 0;
        code = code << 6 | (t[i] & 0x3f);
    }
    bool surrogate = code >= 0xd800 && code < 0xe000;
    if (code < least[more] || code > 0x10ffff || surrogate) return 0;
    *character = code;
    return more + 1;
}

bool utf8_is(const char *text)
{
    unsigned long character;
    for (int length; *text; text += length)
        if (!(length = utf8_read(text, &character))) return false;
    return true;
}

char *utf8_copy(const char *text)
{
    static const char replacement[] = "\xef\xbf\xbd";
    char *copy = malloc(3 * strlen(text) + 1), *end = copy;
    unsigned long character;
    if (!copy) return NULL;
    while (*text) {
        int length = utf8_read(text, &character);
        memcpy(end, length ? text : replacement, length ? (size_t)length : 3);
        end += length ? length : 3;
        text += length ? length : 1;
    }
    *end = '\0';
    return copy;
}
