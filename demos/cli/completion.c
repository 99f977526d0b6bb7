/* Completions of the command line for bash, zsh and fish. */
#include "manual.h"
#include "option_values.h"

#include <string.h>

/* Writes text with a backslash before every character of `escaped`. */
static void put_escaped(const char *text, const char *escaped, FILE *stream)
{
    for (; *text; text++) {
        if (strchr(escaped, *text)) fputc('\\', stream);
        fputc(*text, stream);
    }
}

/* A word in single quotes, as bash and zsh read it; `escaped` as above. */
static void put_quoted(const char *text, const char *escaped, FILE *stream)
{
    for (; *text; text++) {
        if (*text == '\'') {
            fputs("'\\''", stream);
            continue;
        }
        if (strchr(escaped, *text)) fputc('\\', stream);
        fputc(*text, stream);
    }
}

/* The names that a value can be, with spaces between. */
static void put_words(const option_row *row, FILE *stream)
{
    for (int i = 0; option_word(row, i); i++) fprintf(stream, "%s%s", i ? " " : "", option_word(row, i));
}

static void put_argument_names(const command *c, FILE *stream)
{
    for (int i = 0; c->argument_name && c->argument_name(i); i++)
        fprintf(stream, "%s%s", i ? " " : "", c->argument_name(i));
}

static bool is_file(const option_row *row)
{
    return row->kind == VALUE_INPUT || row->kind == VALUE_OUTPUT || row->kind == VALUE_STREAM;
}

/* ---- bash ---- */

static void put_bash_values(const command *c, FILE *stream)
{
    for (const option_id *id = c->options; *id != OPTION_COUNT; id++) {
        const option_row *row = options_row(*id);
        if (row->kind == VALUE_FLAG) continue;
        fprintf(stream, "    %s.--%s) ", c->name, row->name);
        if (option_word(row, 0)) {
            fputs("words='", stream);
            put_words(row, stream);
            fputs("' ;;\n", stream);
        } else {
            fputs(is_file(row) ? "files='*' ;;\n" : row->kind == VALUE_FOLDER ? "folders=1 ;;\n" : ": ;;\n", stream);
        }
    }
}

static void put_bash_command(const command *c, FILE *stream)
{
    fprintf(stream, "    %s)\n        options='", c->name);
    for (const option_id *id = c->options; *id != OPTION_COUNT; id++) fprintf(stream, "--%s ", options_name(*id));
    fputs("--help --version'\n", stream);
    if (c->argument_name) {
        fputs("        words='", stream);
        put_argument_names(c, stream);
        fputs("'\n", stream);
    }
    if (c->files) {
        fputs("        files='", stream);
        for (const char *p = c->files; *p; p++) fputs(*p == ' ' ? "|" : (char[]){*p, '\0'}, stream);
        fputs("'\n", stream);
    }
    if (c->takes_program) fputs("        programs=1\n", stream);
    fputs("        ;;\n", stream);
}

void completion_bash(FILE *stream)
{
    fputs("# bash completion for pinch; made by pinch --manual\n"
          "_pinch()\n{\n"
          "    local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]}\n"
          "    local words='' files='' folders='' programs='' options='' value=1\n"
          "    COMPREPLY=()\n"
          "    if ((COMP_CWORD == 1)); then\n"
          "        mapfile -t COMPREPLY < <(compgen -W '",
          stream);
    for (const command *const *c = command_table; *c; c++) fprintf(stream, "%s ", (*c)->name);
    fputs("--help --version' -- \"$current\")\n        return\n    fi\n"
          "    # bash takes --name=value for three words\n"
          "    if [[ $current == = ]]; then\n"
          "        current=''\n"
          "    elif [[ $before == = ]]; then\n"
          "        before=${COMP_WORDS[COMP_CWORD - 2]}\n"
          "    fi\n"
          "    case $command.$before in\n",
          stream);
    for (const command *const *c = command_table; *c; c++) put_bash_values(*c, stream);
    fputs("    *) value='' ;;\n    esac\n    [[ $value ]] || case $command in\n", stream);
    for (const command *const *c = command_table; *c; c++) put_bash_command(*c, stream);
    fputs("    *) return ;;\n    esac\n"
          "    if [[ ! $value && $current == -* ]]; then\n"
          "        mapfile -t COMPREPLY < <(compgen -W \"$options\" -- \"$current\")\n"
          "    elif [[ $words ]]; then\n"
          "        mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
          "    elif [[ $programs ]]; then\n"
          "        compopt -o filenames 2>/dev/null\n"
          "        mapfile -t COMPREPLY < <(compgen -c -- \"$current\"; compgen -f -- \"$current\")\n"
          "    elif [[ $folders ]]; then\n"
          "        compopt -o filenames 2>/dev/null\n"
          "        mapfile -t COMPREPLY < <(compgen -d -- \"$current\")\n"
          "    elif [[ $files == '*' ]]; then\n"
          "        compopt -o filenames 2>/dev/null\n"
          "        mapfile -t COMPREPLY < <(compgen -f -- \"$current\")\n"
          "    elif [[ $files ]]; then\n"
          "        compopt -o filenames 2>/dev/null\n"
          "        mapfile -t COMPREPLY < <(compgen -f -- \"$current\" | grep -E \"\\\\.($files)\\$\"; compgen -d -- "
          "\"$current\")\n"
          "    fi\n}\n"
          "complete -F _pinch pinch\n",
          stream);
}

/* ---- zsh ---- */

static void put_zsh_option(const option_row *row, FILE *stream)
{
    fprintf(stream, " \\\n            '--%s%s[", row->name, row->kind == VALUE_FLAG ? "" : "=");
    put_quoted(row->help, "[]:\\", stream);
    fputc(']', stream);
    if (row->kind != VALUE_FLAG) {
        fputc(':', stream);
        put_quoted(row->value, ":\\", stream);
        fputc(':', stream);
        if (option_word(row, 0)) {
            fputc('(', stream);
            put_words(row, stream);
            fputc(')', stream);
        } else {
            fputs(is_file(row) ? "_files" : row->kind == VALUE_FOLDER ? "_files -/" : " ", stream);
        }
    }
    fputc('\'', stream);
}

static void put_zsh_arguments(const command *c, FILE *stream)
{
    fputs(" \\\n            ", stream);
    if (c->takes_program) {
        fputs("'*::program:_normal'", stream);
        return;
    }
    fputs(c->max_arguments == 1 ? "'1:" : "'*:", stream);
    put_quoted(c->arguments, ":\\", stream);
    fputc(':', stream);
    if (c->argument_name) {
        fputc('(', stream);
        put_argument_names(c, stream);
        fputs(")'", stream);
        return;
    }
    /* parentheses around one ending would be qualifiers to zsh */
    bool several = c->files && strchr(c->files, ' ');
    fputs(several ? "_files -g \"*.(" : "_files -g \"*.", stream);
    for (const char *p = c->files ? c->files : "*"; *p; p++) fputc(*p == ' ' ? '|' : *p, stream);
    fputs(several ? ")\"'" : "\"'", stream);
}

void completion_zsh(FILE *stream)
{
    fputs("#compdef pinch\n# zsh completion for pinch; made by pinch --manual\n"
          "_pinch() {\n    local -a commands\n    commands=(\n",
          stream);
    for (const command *const *c = command_table; *c; c++) {
        fprintf(stream, "        '%s:", (*c)->name);
        put_quoted((*c)->summary, ":\\", stream);
        fputs("'\n", stream);
    }
    fputs("    )\n    if (( CURRENT == 2 )); then\n        _describe command commands\n        return\n    fi\n"
          "    local command=$words[2]\n    shift words\n    (( CURRENT-- ))\n    case $command in\n",
          stream);
    for (const command *const *c = command_table; *c; c++) {
        fprintf(stream, "    %s)\n        _arguments -s", (*c)->name);
        for (const option_id *id = (*c)->options; *id != OPTION_COUNT; id++) put_zsh_option(options_row(*id), stream);
        fputs(" \\\n            '--help[show this text]' '--version[show the version]'", stream);
        put_zsh_arguments(*c, stream);
        fputs(" ;;\n", stream);
    }
    fputs("    esac\n}\n_pinch \"$@\"\n", stream);
}

/* ---- fish ---- */

static void put_fish_option(const command *c, const option_row *row, FILE *stream)
{
    fprintf(stream, "complete -c pinch -n '__fish_seen_subcommand_from %s' -l %s", c->name, row->name);
    if (row->kind != VALUE_FLAG) fputs(is_file(row) ? " -r -F" : " -x", stream);
    if (option_word(row, 0)) {
        fputs(" -a '", stream);
        put_words(row, stream);
        fputc('\'', stream);
    }
    if (row->kind == VALUE_FOLDER) fputs(" -a '(__fish_complete_directories)'", stream);
    fputs(" -d '", stream);
    put_escaped(row->help, "'\\", stream);
    fputs("'\n", stream);
}

static void put_fish_arguments(const command *c, FILE *stream)
{
    const char *condition = "complete -c pinch -n '__fish_seen_subcommand_from %s' -a '";
    if (c->takes_program) {
        fprintf(stream, condition, c->name);
        fputs("(__fish_complete_subcommand)'\n", stream);
    }
    if (c->argument_name) {
        fprintf(stream, condition, c->name);
        put_argument_names(c, stream);
        fputs("'\n", stream);
    }
    if (!c->files) return;
    fprintf(stream, condition, c->name);
    fputs("(__fish_complete_path (commandline -ct) | string match -r -e \"(/|\\.(", stream);
    for (const char *p = c->files; *p; p++) fputc(*p == ' ' ? '|' : *p, stream);
    fputs("))(\\t|\\$)\")'\n", stream);
}

void completion_fish(FILE *stream)
{
    fputs("# fish completion for pinch; made by pinch --manual\ncomplete -c pinch -f\n", stream);
    for (const command *const *c = command_table; *c; c++) {
        fprintf(stream, "complete -c pinch -n __fish_use_subcommand -a %s -d '", (*c)->name);
        put_escaped((*c)->summary, "'\\", stream);
        fputs("'\n", stream);
        for (const option_id *id = (*c)->options; *id != OPTION_COUNT; id++)
            put_fish_option(*c, options_row(*id), stream);
        put_fish_arguments(*c, stream);
    }
    fputs("complete -c pinch -l help -d 'show this text'\ncomplete -c pinch -l version -d 'show the version'\n",
          stream);
}
