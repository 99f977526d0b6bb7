/* The command `pinch` finds the subcommand, parses its options and runs it. */

#include "command.h"
#include "common/process.h"
#include "common/terminal.h"
#include "manual.h"

#include <pinch/version.h>

#include <string.h>

static void print_help(FILE *stream)
{
    fputs("usage: pinch COMMAND [OPTIONS] ...\n\nPinch solves compliant fingertip contacts. Commands:\n", stream);
    for (const command *const *c = command_table; *c; c++) fprintf(stream, "  %-10s %s\n", (*c)->name, (*c)->summary);
    fputs("\npinch COMMAND --help, or pinch help COMMAND, shows the options of a command, pinch --version shows the "
          "version.\n"
          "pinch --manual DIR writes manual pages and completions for bash, zsh and fish into DIR.\n"
          "Exit status: 0 done and verified, 1 no verified answer or a tolerance broken, 2 usage or bad input, "
          "3 system failure, 128 + N ended by signal N (what was done until then is shown).\n",
          stream);
}

static void print_command_help(const command *c)
{
    printf("usage: pinch %s [OPTIONS] %s\n\n%s\n\n", c->name, c->arguments, c->summary);
    options_describe(c, stdout);
    if (c->notes) printf("\n%s\n", c->notes);
}

static void print_version(void)
{
    printf("pinch %s\n", pinch_version());
}

/* Returns NULL where there is none. */
static const command *command_named(const char *name)
{
    const command *found = NULL;
    for (const command *const *k = command_table; *k; k++)
        if (strcmp(name, (*k)->name) == 0) found = *k;
    return found;
}

static command_status run(int argc, char **argv)
{
    if (argc < 2) {
        print_help(stderr);
        return COMMAND_BAD_INPUT;
    }
    const command *c = command_named(argv[1]), *about = NULL;
    if (!c) {
        bool help = strcmp(argv[1], "help") == 0;
        if (help && argc == 3) about = command_named(argv[2]);
        if (about) {
            print_command_help(about);
        } else if ((help && argc == 2) || strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
            print_help(stdout);
        } else if (strcmp(argv[1], "--version") == 0) {
            print_version();
        } else if (strcmp(argv[1], "--manual") == 0) {
            if (argc == 3) return manual_write(argv[2]);
            terminal_print(stderr, "pinch: --manual takes one folder; pinch --help says more\n");
            return COMMAND_BAD_INPUT;
        } else {
            terminal_print(stderr, "pinch: unknown command \"%s\"; pinch --help lists them\n",
                           argv[help && argc == 3 ? 2 : 1]);
            return COMMAND_BAD_INPUT;
        }
        return COMMAND_DONE;
    }
    options o;
    switch (options_parse(c, argc - 2, argv + 2, &o)) {
    case OPTIONS_RUN: {
        /* a program's options may stand in its configuration, too, which is not read yet */
        command_status status = c->takes_program ? COMMAND_DONE : command_check_needs(&o);
        if (status == COMMAND_DONE) status = command_check_outputs(&o);
        return status == COMMAND_DONE ? c->run(&o) : status;
    }
    case OPTIONS_HELP:
        print_command_help(c);
        return COMMAND_DONE;
    case OPTIONS_VERSION:
        print_version();
        return COMMAND_DONE;
    default:
        return COMMAND_BAD_INPUT;
    }
}

int main(int argc, char **argv)
{
    process_prepare();
    command_status status = run(argc, argv);
    /* A full disk must not pass for a result. */
    if (fflush(stdout) != 0 || ferror(stdout)) {
        fputs("pinch: cannot write to standard output\n", stderr);
        return COMMAND_SYSTEM;
    }
    return status;
}
