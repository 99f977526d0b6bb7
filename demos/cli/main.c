/* The command `pinch` finds the subcommand, parses its options and runs it. */

#include "command.h"
#include "common/process.h"

#include <pinch/version.h>

#include <string.h>

/* The table of subcommands, in the order of the help. A row NAME stands for the `command_NAME` that NAME.c defines. */
#define COMMAND_TABLE(ROW)                                                                                             \
    ROW(solve) ROW(run) ROW(compare) ROW(validate) ROW(hand) ROW(lcp) ROW(replay) ROW(bench) ROW(exec)

#define DECLARE(name) extern const command command_##name;
#define ADDRESS(name) &command_##name,
COMMAND_TABLE(DECLARE)
static const command *const commands[] = {COMMAND_TABLE(ADDRESS)};
enum { COMMANDS = sizeof commands / sizeof commands[0] };

static void print_help(FILE *stream)
{
    fputs("usage: pinch COMMAND [OPTIONS] ...\n\nPinch solves compliant fingertip contacts. Commands:\n", stream);
    for (int i = 0; i < COMMANDS; i++) fprintf(stream, "  %-10s %s\n", commands[i]->name, commands[i]->summary);
    fputs("\npinch COMMAND --help shows the options of a command, pinch --version shows the version.\n"
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

static command_status run(int argc, char **argv)
{
    if (argc < 2) {
        print_help(stderr);
        return COMMAND_BAD_INPUT;
    }
    const command *c = NULL;
    for (int i = 0; i < COMMANDS; i++)
        if (strcmp(argv[1], commands[i]->name) == 0) c = commands[i];
    if (!c) {
        if (strcmp(argv[1], "--help") == 0) {
            print_help(stdout);
        } else if (strcmp(argv[1], "--version") == 0) {
            print_version();
        } else {
            fprintf(stderr, "pinch: unknown command \"%s\"; pinch --help lists them\n", argv[1]);
            return COMMAND_BAD_INPUT;
        }
        return COMMAND_DONE;
    }
    options o;
    switch (options_parse(c, argc - 2, argv + 2, &o)) {
    case OPTIONS_RUN: {
        command_status status = command_check_outputs(&o);
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
