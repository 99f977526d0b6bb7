/* The manual pages, for man(1). They say what --help says, and come from the same tables. */
#define _XOPEN_SOURCE 700

#include "manual.h"
#include "option_values.h"

#include "common/terminal.h"
#include "common/whole_file.h"

#include <pinch/version.h>

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

/* Writes text as roff reads it: a line must not begin with a dot or a quote, and a minus is no hyphen. */
static void put_text(const char *text, FILE *stream)
{
    bool starts = true;
    for (; *text; text++) {
        if (starts && (*text == '.' || *text == '\'')) fputs("\\&", stream);
        if (*text == '\\')
            fputs("\\e", stream);
        else if (*text == '-')
            fputs("\\-", stream);
        else
            fputc(*text, stream);
        starts = *text == '\n';
    }
}

static void put_capitals(const char *text, FILE *stream)
{
    for (; *text; text++) fputc(*text >= 'a' && *text <= 'z' ? *text - 'a' + 'A' : *text, stream);
}

static void put_heading(const char *name, FILE *stream)
{
    fputs(".\\\" made by pinch --manual\n.TH PINCH", stream);
    if (name) fputs("\\-", stream);
    put_capitals(name ? name : "", stream);
    fprintf(stream, " 1 \"\" \"pinch %s\" \"Pinch\"\n.SH NAME\n", pinch_version());
}

/* Notes are paragraphs with empty lines between. */
static void put_notes(const char *notes, FILE *stream)
{
    const char *end;
    for (; (end = strstr(notes, "\n\n")); notes = end + 2) {
        char paragraph[2048];
        snprintf(paragraph, sizeof paragraph, "%.*s", (int)(end - notes), notes);
        fputs(".PP\n", stream);
        put_text(paragraph, stream);
        fputc('\n', stream);
    }
    fputs(".PP\n", stream);
    put_text(notes, stream);
    fputc('\n', stream);
}

static void put_option(const char *name, const char *value, const char *help, FILE *stream)
{
    fputs(".TP\n\\fB\\-\\-", stream);
    put_text(name, stream);
    fputs("\\fR", stream);
    if (value) {
        fputs(" \\fI", stream);
        put_text(value, stream);
        fputs("\\fR", stream);
    }
    fputc('\n', stream);
    put_text(help, stream);
    fputc('\n', stream);
}

static void put_exit_status(FILE *stream)
{
    fputs(".SH EXIT STATUS\n"
          ".TP\n0\ndone and verified\n"
          ".TP\n1\nno verified answer, or a tolerance was broken\n"
          ".TP\n2\nwrong usage or bad input\n"
          ".TP\n3\nthe system failed: memory or disk ran out\n"
          ".TP\n128 + N\nended by signal N; what was done until then is shown\n",
          stream);
}

static void put_command_page(const command *c, FILE *stream)
{
    put_heading(c->name, stream);
    fprintf(stream, "pinch\\-%s \\- ", c->name);
    put_text(c->summary, stream);
    fprintf(stream, "\n.SH SYNOPSIS\n\\fBpinch %s\\fR [\\fIOPTIONS\\fR] ", c->name);
    put_text(c->arguments, stream);
    fputs("\n.SH DESCRIPTION\n.B pinch ", stream);
    fprintf(stream, "%s\n", c->name);
    put_text(c->summary, stream);
    fputs(".\n", stream);
    if (c->notes) put_notes(c->notes, stream);
    fputs(".SH OPTIONS\nA value follows its option, or stands in the same word after an equals sign.\n", stream);
    for (const option_id *id = c->options; *id != OPTION_COUNT; id++) {
        const option_row *row = options_row(*id);
        put_option(row->name, row->value, row->help, stream);
    }
    put_option("help", NULL, "show this text", stream);
    put_option("version", NULL, "show the version", stream);
    if (!c->takes_program) put_exit_status(stream);
    fputs(".SH SEE ALSO\n.BR pinch (1)\n", stream);
}

static void put_main_page(FILE *stream)
{
    put_heading(NULL, stream);
    fputs("pinch \\- simulates and solves robot grasps with compliant fingertips\n.SH SYNOPSIS\n"
          "\\fBpinch\\fR \\fICOMMAND\\fR [\\fIOPTIONS\\fR] ...\n.SH DESCRIPTION\n"
          "Pinch solves compliant fingertip contacts under Coulomb friction, in worlds of the Open Dynamics Engine and "
          "in\n"
          "statics, and verifies every answer.\n.SH COMMANDS\n",
          stream);
    for (const command *const *c = command_table; *c; c++) {
        fprintf(stream, ".TP\n.BR pinch\\-%s (1)\n", (*c)->name);
        put_text((*c)->summary, stream);
        fputc('\n', stream);
    }
    fputs(".SH OPTIONS\n", stream);
    put_option("help", NULL, "list the commands; after a command: show its options", stream);
    put_option("version", NULL, "show the version", stream);
    put_option("manual", "DIR", "write these pages, and completions for bash, zsh and fish, into a folder", stream);
    put_exit_status(stream);
    fputs(".SH FILES\nScenes, robot hands and schemas are in the folder\n.I share/pinch\nbeside the folder of the "
          "command.\n",
          stream);
}

/* Makes all folders on the way to a file. */
static bool make_folders(char *path)
{
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        bool made = mkdir(path, 0777) == 0 || errno == EEXIST;
        *slash = '/';
        if (!made) return false;
    }
    return true;
}

/* Opens FOLDER/NAME. */
static bool open_page(const char *folder, const char *name, whole_file *file)
{
    char path[4096];
    int length = snprintf(path, sizeof path, "%s/%s", folder, name);
    return length < (int)sizeof path && make_folders(path) && whole_file_open(file, path);
}

static bool write_script(const char *folder, const char *name, void (*put)(FILE *stream))
{
    whole_file file;
    if (!open_page(folder, name, &file)) return false;
    put(file.stream);
    return whole_file_close(&file, true);
}

static bool write_command_page(const char *folder, const command *c)
{
    char name[64];
    whole_file file;
    snprintf(name, sizeof name, "man/man1/pinch-%s.1", c->name);
    if (!open_page(folder, name, &file)) return false;
    put_command_page(c, file.stream);
    return whole_file_close(&file, true);
}

command_status manual_write(const char *folder)
{
    bool written = write_script(folder, "man/man1/pinch.1", put_main_page) &&
                   write_script(folder, "bash-completion/completions/pinch", completion_bash) &&
                   write_script(folder, "zsh/site-functions/_pinch", completion_zsh) &&
                   write_script(folder, "fish/vendor_completions.d/pinch.fish", completion_fish);
    for (const command *const *c = command_table; *c && written; c++) written = write_command_page(folder, *c);
    if (written) return COMMAND_DONE;
    terminal_print(stderr, "pinch: --manual: cannot write into %s: %s\n", folder, strerror(errno));
    return COMMAND_SYSTEM;
}
