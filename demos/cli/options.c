/* The table of all options, and reading the command line. */
#include "command.h"
#include "option_values.h"

#include "common/terminal.h"

#include <limits.h>
#include <string.h>

static const char *const contact_solver_names[] = {"pinch", "quickstep", "worldstep", NULL};
static const char *const scope_names[] = {"all", "soft", "material", NULL};
static const char *const contacts_names[] = {"ode", "pinch", NULL};
static const char *const exec_solver_names[] = {"nsnmgk", "nsngrk", "newton", NULL}; /* as in pinch_solver */

#define OPTION_FIELD(field) offsetof(options, field)
static const option_row table[OPTION_COUNT] = {
    [OPTION_SOLVER] = {"solver", VALUE_SOLVER, OPTION_FIELD(solver), "NAME", "nsnmgk, nsngrk, newton, lemke or pgs"},
    [OPTION_FORMULATION] = {"formulation", VALUE_FORMULATION, OPTION_FIELD(formulation), "NAME",
                            "coulomb (exact cone) or lcp (linearized cone)"},
    [OPTION_TOLERANCE] = {"tolerance", VALUE_POSITIVE, OPTION_FIELD(tolerance), "X", "residual to reach, > 0"},
    [OPTION_MAX_ITERATIONS] = {"max-iterations", VALUE_INTEGER, OPTION_FIELD(max_iterations), "N",
                               "iterations a solve may take", 1, INT_MAX},
    [OPTION_FACES] = {"faces", VALUE_INTEGER, OPTION_FIELD(faces), "N", "faces of the linearized cone", SCENE_MIN_FACES,
                      SCENE_MAX_FACES},
    [OPTION_SEED] = {"seed", VALUE_SEED, OPTION_FIELD(seed), "N", "seed of everything random (default 1)"},
    [OPTION_DURATION] = {"duration", VALUE_NOT_NEGATIVE, OPTION_FIELD(duration), "S", "simulated time in seconds"},
    [OPTION_STEP] = {"step", VALUE_POSITIVE, OPTION_FIELD(step), "S", "time step in seconds"},
    [OPTION_CONTACT_SOLVER] = {"contact-solver", VALUE_NAME, OPTION_FIELD(contact_solver), "NAME",
                               "pinch (default), quickstep or worldstep", .names = contact_solver_names},
    [OPTION_NO_NEWTON] = {"no-newton", VALUE_FLAG, OPTION_FIELD(no_newton), NULL,
                          "run nsnmgk without its Newton finish"},
    [OPTION_FAITHFUL] = {"faithful", VALUE_FLAG, OPTION_FIELD(faithful), NULL, "use the paper's own settings"},
    [OPTION_UNIT] = {"unit", VALUE_FLAG, OPTION_FIELD(unit), NULL, "with --faithful: non-dimensionalize first"},
    [OPTION_ONE_STEP] = {"one-step", VALUE_FLAG, OPTION_FIELD(one_step), NULL,
                         "apply all loads at once, instead of closing first and the wrench after"},
    [OPTION_INSCRIBED] = {"inscribed", VALUE_FLAG, OPTION_FIELD(inscribed), NULL,
                          "put the friction pyramid inside the cone instead of around it"},
    [OPTION_PRINT] = {"print", VALUE_FLAG, OPTION_FIELD(print), NULL,
                      "print the scene with every default filled in; study: of trial 0, or of --trial K"},
    [OPTION_JSON] = {"json", VALUE_FLAG, OPTION_FIELD(json), NULL, "print one JSON document on standard output"},
    [OPTION_CSV] = {"csv", VALUE_OUTPUT, OPTION_FIELD(csv), "FILE", "write a table to this file"},
    [OPTION_PLOT] = {"plot", VALUE_FOLDER, OPTION_FIELD(plot), "DIR", "write plots into this directory"},
    [OPTION_QUIET] = {"quiet", VALUE_FLAG, OPTION_FIELD(quiet), NULL, "print no tables and no remarks"},
    [OPTION_ONLY] = {"only", VALUE_NAME, OPTION_FIELD(only), "WHICH",
                     "all (default), soft (contacts with a soft CFM) or material (none without a material)",
                     .names = scope_names},
    [OPTION_KT_RATIO] = {"kt-ratio", VALUE_RATIO, OPTION_FIELD(kt_ratio), "X",
                         "tangential over normal stiffness of contacts, > 0 and <= 10 (default 2/3)"},
    [OPTION_CONFIG] = {"config", VALUE_INPUT, OPTION_FIELD(config), "FILE",
                       "read these options from a JSON file, as \"kt_ratio\": 0.8"},
    [OPTION_STATS] = {"stats", VALUE_STREAM, OPTION_FIELD(stats), "FILE",
                      "write statistics as JSON; - for standard error"},
    [OPTION_QUICKSTEP_ITERATIONS] = {"quickstep-iterations", VALUE_COUNTS, OPTION_FIELD(quickstep_iterations), "N,...",
                                     "run quickstep with each of these numbers (default 20,50,200)"},
    [OPTION_CONTACTS] = {"contacts", VALUE_NAME, OPTION_FIELD(contacts), "WHOSE",
                         "contact points that ODE's solvers get: ode (the collider's, default) or pinch (manifolds)",
                         .names = contacts_names},
    [OPTION_POINTS] = {"points", VALUE_INTEGER, OPTION_FIELD(points), "N",
                       "at most N points of a pair in Pinch's manifolds, 1 to 8 (default 8)", 1, 8},
    [OPTION_COLD_START] = {"cold-start", VALUE_FLAG, OPTION_FIELD(cold_start), NULL,
                           "Pinch starts every solve without what it knew before"},
    [OPTION_SAMPLES] = {"samples", VALUE_INTEGER, OPTION_FIELD(samples), "N",
                        "steps that are compared with the exact answer, 0 to 256 (default 24)", 0, 256},
    [OPTION_SAVE] = {"save", VALUE_OUTPUT, OPTION_FIELD(save), "FILE", "write the metrics to this file as a baseline"},
    [OPTION_CHECK] = {"check", VALUE_INPUT, OPTION_FIELD(check), "FILE",
                      "compare the metrics with a baseline; exit status 1 where one has moved"},
    [OPTION_REPORT] = {"report", VALUE_OUTPUT, OPTION_FIELD(report), "FILE.html",
                       "write a page for people to this file"},
    [OPTION_PICTURE] = {"picture", VALUE_OUTPUT, OPTION_FIELD(picture), "FILE.svg",
                        "draw one scene with its forces and friction cones, and how far the object turns"},
    [OPTION_GLTF] = {"gltf", VALUE_OUTPUT, OPTION_FIELD(gltf), "FILE.glb",
                     "write the run, or the hand, as a 3-D scene (glTF 2.0), for Blender and others"},
    [OPTION_VIEW] = {"view", VALUE_OUTPUT, OPTION_FIELD(view), "FILE.html",
                     "write a page that plays the run in 3-D beside quickstep's, with charts; it needs no network"},
    [OPTION_FPS] = {"fps", VALUE_INTEGER, OPTION_FIELD(fps), "N",
                    "with --view or --gltf: pictures a second of simulated time (default 60)", 1, 1000},
    [OPTION_OUT] = {"out", VALUE_OUTPUT, OPTION_FIELD(out), "FILE.sqlite", "write the results to this database"},
    [OPTION_TRIAL] = {"trial", VALUE_INTEGER, OPTION_FIELD(trial), "K",
                      "run this trial again, alone, as pinch run does", 0, INT_MAX},
    [OPTION_LIMIT] = {"limit", VALUE_INTEGER, OPTION_FIELD(limit), "N",
                      "run at most N trials of those that are missing", 1, INT_MAX},
    [OPTION_BESIDE] = {"beside", VALUE_INPUT, OPTION_FIELD(beside), "FILE.sqlite",
                       "compare the verdicts with these results of the same study, made by another solver or step"},
    [OPTION_REFINE] = {"refine", VALUE_INTEGER, OPTION_FIELD(refine), "N",
                       "with --beside: halve the step of the first N trials that differ until the verdicts stay", 1,
                       INT_MAX},
    [OPTION_STUDY_RESUME] = {"resume", VALUE_FLAG, OPTION_FIELD(study_resume), NULL,
                             "go on with results that are there already"},
    [OPTION_EXEC_SOLVER] = {"solver", VALUE_NAME, OPTION_FIELD(solver), "NAME",
                            "nsnmgk (default), newton, or nsngrk, which solves joints alone and no contacts",
                            .names = exec_solver_names},
    [OPTION_CHECKPOINT] = {"checkpoint", VALUE_OUTPUT, OPTION_FIELD(checkpoint), "FILE",
                           "write the state of the run to this file from time to time, for --resume"},
    [OPTION_EVERY] = {"every", VALUE_INTEGER, OPTION_FIELD(every), "N",
                      "with --checkpoint: every N steps (default 1000), and at an interrupt", 1, INT_MAX},
    [OPTION_RESUME] = {"resume", VALUE_INPUT, OPTION_FIELD(resume), "FILE",
                       "go on from this checkpoint of the same run, to the same bits; files get what comes after it"},
    [OPTION_JOBS] = {"jobs", VALUE_INTEGER, OPTION_FIELD(jobs), "N", "processes at a time (default one per processor)",
                     1, 1024},
    [OPTION_MIN_SIZE] = {"min-size", VALUE_INTEGER, OPTION_FIELD(min_size), "N", "leave out smaller sizes", 1, INT_MAX},
    [OPTION_MAX_SIZE] = {"max-size", VALUE_INTEGER, OPTION_FIELD(max_size), "N", "leave out larger sizes", 1, INT_MAX},
    [OPTION_TIME] = {"time", VALUE_NOT_NEGATIVE, OPTION_FIELD(time), "S",
                     "solve for what the schedule applies at this time (default: its first entry)"},
    [OPTION_AT_END] = {"at-end", VALUE_FLAG, OPTION_FIELD(at_end), NULL,
                       "solve for what the schedule applies at the end of the run"},
    [OPTION_NO_RESERVES] =
        {"no-reserves", VALUE_FLAG, OPTION_FIELD(no_reserves), NULL,
         "leave out the searches for the least friction and closing, the largest load, and the quality"},
    [OPTION_DIRECTIONS] = {"directions", VALUE_FLAG, OPTION_FIELD(directions), NULL,
                           "find the reserves for the same force along each axis, too"},
    [OPTION_FAIL_ON] =
        {"fail-on", VALUE_EVENTS, OPTION_FIELD(fail_on), "EVENT,...",
         "exit status 1 where one of these happened: crush, slip (of fingers that have damage), dropped, limit"},
    [OPTION_BUDGET] =
        {"budget", VALUE_POSITIVE, OPTION_FIELD(budget), "S",
         "seconds of measuring by size, or row of paper (default 1; piles 2, threads 4; collide: in all)"},
    [OPTION_THREADS] = {"threads", VALUE_INTEGER, OPTION_FIELD(threads), "N",
                        "threads that solve islands (default 1; bench threads: the most that it tries)", 1,
                        OPTIONS_MOST_THREADS},
    [OPTION_RECORD] = {"record", VALUE_FOLDER, OPTION_FIELD(record), "DIR",
                       "write islands that the solver fails on into this folder, for pinch replay; 100 at most"},
    [OPTION_RECORD_ALL] = {"record-all", VALUE_FLAG, OPTION_FIELD(record_all), NULL,
                           "with --record: write every solve of an island, 100 at most"},
    [OPTION_AT] = {"at", VALUE_TEXT, OPTION_FIELD(at), "JOINT=X,...",
                   "positions of joints (rad or m) at which the links are shown"},
    [OPTION_PACKAGE] = {"package", VALUE_TEXT, OPTION_FIELD(package), "NAME=DIR,...",
                        "where package://NAME/ in a URDF file leads (default: a directory above the file)"},
};

/* ---- The command line. ---- */

static bool has(const option_id *list, option_id id)
{
    for (; *list != OPTION_COUNT; list++)
        if (*list == id) return true;
    return false;
}

bool options_takes(const command *c, option_id id)
{
    return has(c->options, id);
}

option_id options_beyond(const options *o, const option_id *list)
{
    for (int i = 0; i < OPTION_COUNT; i++)
        if (o->given[i] && !has(list, (option_id)i)) return (option_id)i;
    return OPTION_COUNT;
}

const char *options_name(option_id id)
{
    return table[id].name;
}

void options_list(const option_id *list, char *text, size_t size)
{
    size_t used = 0;
    for (const option_id *own = list; *own != OPTION_COUNT && used < size; own++) {
        int n = snprintf(text + used, size - used, " --%s", table[*own].name);
        used += n > 0 ? (size_t)n : 0;
    }
    snprintf(text + (used < size ? used : size - 1), size - (used < size ? used : size - 1), " --help --version");
}

bool options_store(options *o, option_id id, const char *text, char *expected, size_t size)
{
    const option_row *op = &table[id];
    if (option_store(op, text, (char *)o + op->offset)) return true;
    option_expected(op, expected, size);
    return false;
}

bool options_is_number(option_id id)
{
    value_kind kind = table[id].kind;
    return kind == VALUE_POSITIVE || kind == VALUE_NOT_NEGATIVE || kind == VALUE_RATIO || kind == VALUE_INTEGER ||
           kind == VALUE_SEED;
}

const option_row *options_row(option_id id)
{
    return &table[id];
}

bool options_is_output(option_id id)
{
    return table[id].kind == VALUE_OUTPUT || table[id].kind == VALUE_STREAM;
}

bool options_is_input(option_id id)
{
    return table[id].kind == VALUE_INPUT;
}

option_id options_find(const command *c, const char *key)
{
    for (const option_id *own = c->options; *own != OPTION_COUNT; own++) {
        const char *name = table[*own].name;
        size_t k = 0;
        while (name[k] && key[k] == (name[k] == '-' ? '_' : name[k])) k++;
        if (!name[k] && !key[k]) return *own;
    }
    return OPTION_COUNT;
}

/* The option of an argument "--name" or "--name=value", of several with this name the one that the command takes.
 * OPTION_COUNT where there is no such option. */
static option_id find(const command *c, const char *argument, const char **value)
{
    size_t length = strcspn(argument, "=");
    option_id found = OPTION_COUNT;
    *value = argument[length] ? argument + length + 1 : NULL;
    for (int i = 0; i < OPTION_COUNT; i++)
        if (strlen(table[i].name) + 2 == length && strncmp(argument + 2, table[i].name, length - 2) == 0 &&
            (found == OPTION_COUNT || options_takes(c, (option_id)i)))
            found = (option_id)i;
    return found;
}

static options_outcome refuse_option(const command *c, const char *argument)
{
    char known[512];
    options_list(c->options, known, sizeof known);
    command_error(c->name, "unknown option %.*s; it takes%s", (int)strcspn(argument, "="), argument, known);
    return OPTIONS_WRONG;
}

/* Reads the option at argv[*i], and its value where that is the next argument. */
static options_outcome take_option(const command *c, int argc, char **argv, int *i, options *o)
{
    char *argument = argv[*i];
    if (strcmp(argument, "--help") == 0 || strcmp(argument, "-h") == 0) return OPTIONS_HELP;
    if (strcmp(argument, "--version") == 0) return OPTIONS_VERSION;
    const char *value;
    option_id id = strncmp(argument, "--", 2) == 0 ? find(c, argument, &value) : OPTION_COUNT;
    if (id == OPTION_COUNT || !options_takes(c, id)) return refuse_option(c, argument);
    const option_row *op = &table[id];
    if (op->kind == VALUE_FLAG && value) {
        command_error(c->name, "--%s takes no value", op->name);
        return OPTIONS_WRONG;
    }
    const char *text = value;
    if (op->kind != VALUE_FLAG && !text) {
        if (++*i >= argc) {
            command_error(c->name, "--%s: expected a value (%s)", op->name, op->help);
            return OPTIONS_WRONG;
        }
        text = argv[*i];
    }
    char expected[160];
    if (!options_store(o, id, text, expected, sizeof expected)) {
        command_error(c->name, "--%s: expected %s, got \"%s\"", op->name, expected, text);
        return OPTIONS_WRONG;
    }
    o->given[id] = true;
    o->text[id] = text;
    return OPTIONS_RUN;
}

options_outcome options_parse(const command *c, int argc, char **argv, options *o)
{
    *o = (options){.command = c, .seed = 1, .fps = 60, .arguments = argv};
    bool open = true;
    for (int i = 0; i < argc; i++) {
        if (open && strcmp(argv[i], "--") == 0) {
            open = false;
        } else if (open && argv[i][0] == '-' && argv[i][1]) {
            options_outcome outcome = take_option(c, argc, argv, &i, o);
            if (outcome != OPTIONS_RUN) return outcome;
        } else {
            open = open && !c->takes_program;
            o->arguments[o->argument_count++] = argv[i];
        }
    }
    if (o->argument_count >= c->min_arguments && o->argument_count <= c->max_arguments) return OPTIONS_RUN;
    command_error(c->name, "expected %s, got %d argument%s; see pinch %s --help", c->arguments, o->argument_count,
                  o->argument_count == 1 ? "" : "s", c->name);
    return OPTIONS_WRONG;
}

static void describe_option(const char *name, const char *value, const char *help, FILE *stream)
{
    char left[64];
    snprintf(left, sizeof left, "--%s%s%s", name, value ? " " : "", value ? value : "");
    fprintf(stream, "  %-31s %s\n", left, help);
}

void options_describe(const command *c, FILE *stream)
{
    for (const option_id *own = c->options; *own != OPTION_COUNT; own++)
        describe_option(table[*own].name, table[*own].value, table[*own].help, stream);
    describe_option("help", NULL, "show this text", stream);
    describe_option("version", NULL, "show the version", stream);
}

void options_print_word(const char *word, FILE *stream)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./,=+:@%-";
    if (*word && word[strspn(word, plain)] == '\0') {
        fputs(word, stream);
        return;
    }
    bool obeyed = !terminal_shows(word);
    fputs(obeyed ? "$'" : "'", stream);
    for (; *word; word++) {
        char letter[2] = {*word, '\0'};
        if (obeyed && (*word == '\'' || *word == '\\'))
            fprintf(stream, "\\%c", *word);
        else if (*word == '\'')
            fputs("'\\''", stream);
        else if (obeyed)
            terminal_text(letter, stream);
        else
            fputc(*word, stream);
    }
    fputc('\'', stream);
}

void options_print(const options *o, option_id left_out, const char *const *arguments, int count, FILE *stream)
{
    fprintf(stream, "pinch %s", o->command->name);
    for (const option_id *own = o->command->options; *own != OPTION_COUNT; own++) {
        if (!o->given[*own] || *own == left_out) continue;
        fprintf(stream, " --%s", table[*own].name);
        if (!o->text[*own]) continue;
        fputc(' ', stream);
        options_print_word(o->text[*own], stream);
    }
    for (int i = 0; i < count; i++) {
        fputs(i == 0 && arguments[i][0] == '-' ? " -- " : " ", stream);
        options_print_word(arguments[i], stream);
    }
}
