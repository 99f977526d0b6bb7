#include "canvas.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

struct canvas {
    FILE *stream;
    int width, height;
    bool vector;            /* an SVG picture; else a PNG one: */
    unsigned char *pixels;  /* 3 a pixel, rows from the top */
    unsigned char *covered; /* how much of each pixel the line being drawn covers */
};

/* ---- SVG. ---- */

static void svg_text(const char *text, FILE *stream)
{
    for (const char *start = text; *text; text++) {
        if (*text == '&')
            fputs("&amp;", stream);
        else if (*text == '<')
            fputs("&lt;", stream);
        else if (*text == '^')
            fputs("<tspan dy=\"-0.45em\" font-size=\"72%\">", stream);
        else if (*text == '-' && (text == start || text[-1] == '^'))
            fputs("\xe2\x88\x92", stream); /* as long as a plus */
        else
            fputc(*text, stream);
    }
}

canvas *canvas_svg(FILE *stream, int width, int height, const char *title)
{
    canvas *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    *c = (canvas){.stream = stream, .width = width, .height = height, .vector = true};
    fprintf(stream,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" height=\"%d\" "
            "font-family=\"system-ui, 'DejaVu Sans', sans-serif\" role=\"img\"><title>",
            width, height, width, height);
    svg_text(title, stream);
    fprintf(stream, "</title>\n<rect width=\"%d\" height=\"%d\" fill=\"#ffffff\"/>\n", width, height);
    return c;
}

/* ---- PNG. ---- */

canvas *canvas_png(FILE *stream, int width, int height)
{
    canvas *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    *c = (canvas){.stream = stream, .width = (int)(CANVAS_SCALE * width), .height = (int)(CANVAS_SCALE * height)};
    size_t count = (size_t)c->width * (size_t)c->height;
    c->pixels = malloc(3 * count);
    c->covered = calloc(count, 1);
    if (!c->pixels || !c->covered) {
        free(c->pixels);
        free(c->covered);
        free(c);
        return NULL;
    }
    memset(c->pixels, 255, 3 * count);
    return c;
}

typedef struct box {
    int left, top, right, bottom; /* pixels, the last ones outside */
} box;

static box box_of(const canvas *c, const double a[2], const double b[2], double radius)
{
    box at = {(int)floor(fmin(a[0], b[0]) - radius - 1), (int)floor(fmin(a[1], b[1]) - radius - 1),
              (int)ceil(fmax(a[0], b[0]) + radius + 1), (int)ceil(fmax(a[1], b[1]) + radius + 1)};
    at.left = at.left < 0 ? 0 : at.left;
    at.top = at.top < 0 ? 0 : at.top;
    at.right = at.right > c->width ? c->width : at.right;
    at.bottom = at.bottom > c->height ? c->height : at.bottom;
    return at;
}

/* Covers what is nearer to the segment than the radius, with an edge that is a pixel wide. */
static void cover(canvas *c, const double a[2], const double b[2], double radius)
{
    box at = box_of(c, a, b, radius);
    double along[2] = {b[0] - a[0], b[1] - a[1]}, square = along[0] * along[0] + along[1] * along[1];
    for (int y = at.top; y < at.bottom; y++)
        for (int x = at.left; x < at.right; x++) {
            double from[2] = {x + 0.5 - a[0], y + 0.5 - a[1]};
            double part = square > 0 ? (from[0] * along[0] + from[1] * along[1]) / square : 0;
            part = fmin(fmax(part, 0), 1);
            double distance = hypot(from[0] - part * along[0], from[1] - part * along[1]);
            double covered = 255 * fmin(fmax(radius + 0.5 - distance, 0), 1);
            unsigned char *to = &c->covered[(size_t)y * (size_t)c->width + (size_t)x];
            if (covered > *to) *to = (unsigned char)covered;
        }
}

/* Colours what the segment has covered, and makes it clear again. */
static void colour_in(canvas *c, const double a[2], const double b[2], double radius, const char *colour)
{
    unsigned rgb[3] = {0, 0, 0};
    (void)sscanf(colour, "#%2x%2x%2x", &rgb[0], &rgb[1], &rgb[2]);
    box at = box_of(c, a, b, radius);
    for (int y = at.top; y < at.bottom; y++)
        for (int x = at.left; x < at.right; x++) {
            size_t k = (size_t)y * (size_t)c->width + (size_t)x;
            unsigned part = c->covered[k];
            for (size_t i = 0; i < 3 && part > 0; i++)
                c->pixels[3 * k + i] = (unsigned char)((c->pixels[3 * k + i] * (255 - part) + rgb[i] * part) / 255);
            c->covered[k] = 0;
        }
}

/* Covers the dashes of a segment that begins `done` after the line's start. */
static void cover_dashes(canvas *c, const double a[2], const double b[2], const canvas_pen *pen, double done)
{
    double length = hypot(b[0] - a[0], b[1] - a[1]), period = CANVAS_SCALE * (pen->dash + pen->gap);
    double radius = 0.5 * CANVAS_SCALE * pen->width;
    if (!(pen->dash > 0) || !(length > 0)) {
        cover(c, a, b, radius);
        return;
    }
    for (double start = -fmod(done, period); start < length; start += period) {
        double from = fmax(start, 0) / length, to = fmin(start + CANVAS_SCALE * pen->dash, length) / length;
        if (!(to > from)) continue;
        const double p[2] = {a[0] + from * (b[0] - a[0]), a[1] + from * (b[1] - a[1])};
        const double q[2] = {a[0] + to * (b[0] - a[0]), a[1] + to * (b[1] - a[1])};
        cover(c, p, q, radius);
    }
}

static void png_path(canvas *c, const double (*points)[2], int count, const canvas_pen *pen)
{
    double radius = 0.5 * CANVAS_SCALE * pen->width, done = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int k = 0; k < (count > 1 ? count - 1 : count); k++) {
            int next = count > 1 ? k + 1 : k;
            const double a[2] = {CANVAS_SCALE * points[k][0], CANVAS_SCALE * points[k][1]};
            const double b[2] = {CANVAS_SCALE * points[next][0], CANVAS_SCALE * points[next][1]};
            if (pass == 0)
                cover_dashes(c, a, b, pen, done);
            else
                colour_in(c, a, b, radius, pen->colour);
            done += hypot(b[0] - a[0], b[1] - a[1]);
        }
}

/* Letters of straight strokes. A letter's strokes are pairs of digits x y on a grid with y upwards: the base line is at
 * 2, small letters reach 6, capitals 8. A | begins another stroke. */
static const char *const letters[128] = {
    ['A'] = "022842|1434",
    ['B'] = "020828373625|05253544433202",
    ['C'] = "4738180703123243",
    ['D'] = "02082846442202",
    ['E'] = "48080242|0535",
    ['F'] = "480802|0535",
    ['G'] = "47381807031232434525",
    ['H'] = "0208|4248|0545",
    ['I'] = "0208",
    ['J'] = "3833221203",
    ['K'] = "0208|4804|1542",
    ['L'] = "080242",
    ['M'] = "0208254842",
    ['N'] = "02084248",
    ['O'] = "180703123243473818",
    ['P'] = "02083847463505",
    ['Q'] = "180703123243473818|2442",
    ['R'] = "02083847463505|2542",
    ['S'] = "473818070615354443321203",
    ['T'] = "0848|2822",
    ['U'] = "080312324348",
    ['V'] = "082248",
    ['W'] = "0812263248",
    ['X'] = "0842|0248",
    ['Y'] = "082548|2522",
    ['Z'] = "08480242",
    ['a'] = "3632|3526160503122233",
    ['b'] = "0802|0516263533221203",
    ['c'] = "3526160503122233",
    ['d'] = "3832|3526160503122233",
    ['e'] = "04343526160503122233",
    ['f'] = "28181712|0626",
    ['g'] = "3631201001|3526160503122233",
    ['h'] = "0802|0516263532",
    ['i'] = "0206|0808",
    ['j'] = "161100|1818",
    ['k'] = "0802|3604|1432",
    ['l'] = "080312",
    ['m'] = "0602|05162522|25364542",
    ['n'] = "0602|0516263532",
    ['o'] = "160503122233352616",
    ['p'] = "0600|0516263533221203",
    ['q'] = "3630|3526160503122233",
    ['r'] = "0602|051626",
    ['s'] = "35261605142433221203",
    ['t'] = "181322|0626",
    ['u'] = "0603122233|3632",
    ['v'] = "062246",
    ['w'] = "0612253246",
    ['x'] = "0632|0236",
    ['y'] = "0622|461000",
    ['z'] = "06360232",
    ['0'] = "180703123243473818",
    ['1'] = "162822",
    ['2'] = "0718384746350242",
    ['3'] = "07183847463515|354443321203",
    ['4'] = "32380444",
    ['5'] = "48080516364543321203",
    ['6'] = "473818070312324344351504",
    ['7'] = "084812",
    ['8'] = "15060718384746351504031232434435",
    ['9'] = "031232434738180706153546",
    ['.'] = "0202",
    [','] = "1201",
    [':'] = "0202|0505",
    [';'] = "1201|1515",
    ['-'] = "0535",
    ['+'] = "0545|2723",
    ['('] = "19070301",
    [')'] = "09171301",
    ['/'] = "0139",
    ['\''] = "0807",
    ['='] = "0444|0646",
    ['%'] = "0248|0818170708|3343423233",
    ['_'] = "0141",
    ['<'] = "472543",
    ['~'] = "0415264546",
    ['>'] = "072503",
};

/* NULL for what has no letter. */
static const char *letter_strokes(char letter)
{
    return letter > 0 ? letters[(int)letter] : NULL;
}

/* Grid units to the next letter. */
static int letter_advance(char letter)
{
    const char *strokes = letter_strokes(letter);
    int widest = 1;
    if (!strokes) return 3;
    for (; *strokes; strokes++) {
        if (*strokes == '|') continue;
        if (*strokes - '0' > widest) widest = *strokes - '0';
        strokes++;
    }
    return widest + 2;
}

static double text_width(const char *text, double size)
{
    double width = 0;
    for (; *text; text++) {
        if (*text == '^')
            size *= 0.72;
        else
            width += size / 8.5 * letter_advance(*text);
    }
    return width;
}

static void png_text(canvas *c, const double at[2], const char *text, const canvas_type *type)
{
    double size = type->size, raised = 0, x = 0, points[16][2];
    double shift = type->anchor == CANVAS_START ? 0 : type->anchor == CANVAS_MIDDLE ? 0.5 : 1;
    x -= shift * text_width(text, size);
    canvas_pen pen = {type->colour, type->bold ? 0.13 * size : 0.085 * size, 0, 0};
    for (; *text; text++) {
        if (*text == '^') {
            raised = 0.4 * size;
            size *= 0.72;
            continue;
        }
        const char *strokes = letter_strokes(*text);
        double unit = size / 8.5;
        for (int count = 0; strokes && (*strokes || count > 0);) {
            if (*strokes == '|' || !*strokes) {
                png_path(c, (const double(*)[2])points, count, &pen);
                count = 0;
                if (!*strokes++) break;
                continue;
            }
            double right = x + unit * (strokes[0] - '0'), up = raised + unit * (strokes[1] - '2');
            points[count][0] = at[0] + (type->upwards ? -up : right);
            points[count++][1] = at[1] - (type->upwards ? right : up);
            strokes += 2;
        }
        x += unit * letter_advance(*text);
    }
}

static void put_word(uint32_t word, unsigned char *to)
{
    for (int i = 0; i < 4; i++) to[i] = (unsigned char)(word >> (24 - 8 * i));
}

/* A chunk: its length, its kind and bytes, and the check sum of these two. */
static void write_chunk(const char *kind, const unsigned char *bytes, size_t size, FILE *stream)
{
    unsigned char word[4];
    put_word((uint32_t)size, word);
    fwrite(word, 1, 4, stream);
    fwrite(kind, 1, 4, stream);
    if (size > 0) fwrite(bytes, 1, size, stream);
    uLong sum = crc32(0, (const unsigned char *)kind, 4);
    if (size > 0) sum = crc32(sum, bytes, (uInt)size);
    put_word((uint32_t)sum, word);
    fwrite(word, 1, 4, stream);
}

static bool write_png(const canvas *c)
{
    size_t row = 3 * (size_t)c->width, size = (row + 1) * (size_t)c->height;
    uLongf packed_size = compressBound((uLong)size);
    unsigned char *raw = malloc(size), *packed = malloc(packed_size), head[13] = {0};
    bool done = raw && packed;
    for (int y = 0; y < c->height && done; y++) {
        raw[(size_t)y * (row + 1)] = 0; /* no filter */
        memcpy(raw + (size_t)y * (row + 1) + 1, c->pixels + (size_t)y * row, row);
    }
    done = done && compress2(packed, &packed_size, raw, (uLong)size, Z_BEST_COMPRESSION) == Z_OK;
    if (done) {
        put_word((uint32_t)c->width, head);
        put_word((uint32_t)c->height, head + 4);
        head[8] = 8; /* bits */
        head[9] = 2; /* red, green, blue */
        fwrite("\x89PNG\r\n\x1a\n", 1, 8, c->stream);
        write_chunk("IHDR", head, sizeof head, c->stream);
        write_chunk("IDAT", packed, packed_size, c->stream);
        write_chunk("IEND", NULL, 0, c->stream);
    }
    free(raw);
    free(packed);
    return done;
}

/* ---- Both. ---- */

void canvas_path(canvas *c, const double (*points)[2], int count, const canvas_pen *pen)
{
    if (count < 1) return;
    if (!c->vector) {
        png_path(c, points, count, pen);
        return;
    }
    fputs("<path d=\"", c->stream);
    for (int k = 0; k < count; k++) fprintf(c->stream, "%s%.2f %.2f", k ? "L" : "M", points[k][0], points[k][1]);
    fprintf(c->stream,
            "%s\" fill=\"none\" stroke=\"%s\" stroke-width=\"%g\" stroke-linecap=\"round\" "
            "stroke-linejoin=\"round\"",
            count == 1 ? "h0" : "", pen->colour, pen->width);
    if (pen->dash > 0) fprintf(c->stream, " stroke-dasharray=\"%g %g\"", pen->dash, pen->gap);
    fputs("/>\n", c->stream);
}

void canvas_text(canvas *c, double x, double y, const char *text, const canvas_type *type)
{
    static const char *const anchors[] = {"start", "middle", "end"};
    if (!c->vector) {
        png_text(c, (const double[2]){x, y}, text, type);
        return;
    }
    fprintf(c->stream, "<text x=\"%.1f\" y=\"%.1f\" font-size=\"%g\" fill=\"%s\" text-anchor=\"%s\"", x, y, type->size,
            type->colour, anchors[type->anchor]);
    if (type->bold) fputs(" font-weight=\"600\"", c->stream);
    if (type->upwards) fprintf(c->stream, " transform=\"rotate(-90 %.1f %.1f)\"", x, y);
    fputc('>', c->stream);
    svg_text(text, c->stream);
    fputs(strchr(text, '^') ? "</tspan></text>\n" : "</text>\n", c->stream);
}

bool canvas_close(canvas *c)
{
    bool done = c->vector || write_png(c);
    if (c->vector) fputs("</svg>\n", c->stream);
    free(c->pixels);
    free(c->covered);
    free(c);
    return done;
}
