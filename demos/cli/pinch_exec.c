/* pinch exec: an unmodified ODE program with Pinch as its contact solver. */
#define _XOPEN_SOURCE 700

#include "command.h"
#include "exec_config.h"

#include "common/own_place.h"
#include "common/whole_file.h"
#include "preload/report.h"

#include <pinch/ode_dropin.h>

#include <dlfcn.h>
#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

enum { NOT_EXECUTABLE = 126, NOT_FOUND = 127, MOST_PATH = 4000, MOST_DOCUMENT = 8192 };

/* ---- The library that is loaded before the program's others. ---- */

enum { MOST_REASON = 512 };
#define LIBRARY "libpinch_preload.so"

/* The library is beside this command, as in the build tree, or where an installation has its libraries. */
static const char *const library_places[] = {LIBRARY, PINCH_LIBRARY_FROM_COMMAND "/" LIBRARY, NULL};

/* Are all parts that a loader maps within the file? A loader does not check, and a program that reads past the end is
 * killed then, which may be late. A file that is no such library counts as whole: the loader will say what is wrong
 * with it. */
static bool is_whole(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) return true;
    struct stat status;
    Elf64_Ehdr head;
    bool known = fstat(fileno(file), &status) == 0 && fread(&head, sizeof head, 1, file) == 1 &&
                 memcmp(head.e_ident, ELFMAG, SELFMAG) == 0 && head.e_ident[EI_CLASS] == ELFCLASS64 &&
                 head.e_phentsize == sizeof(Elf64_Phdr);
    bool whole = !known || fseek(file, (long)head.e_phoff, SEEK_SET) == 0;
    for (int i = 0; known && whole && i < head.e_phnum; i++) {
        Elf64_Phdr part;
        whole = fread(&part, sizeof part, 1, file) == 1 &&
                (part.p_type != PT_LOAD || part.p_offset + part.p_filesz <= (Elf64_Xword)status.st_size);
    }
    fclose(file);
    return whole;
}

/* Loads the library as a program's loader will, writes to `stream` what is wrong with it, and ends. It runs in a
 * process of its own, because a damaged file may bring it down. */
static void load_and_report(const char *path, int stream)
{
    int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere >= 0) (void)dup2(nowhere, STDERR_FILENO); /* this hides what the loader prints when it dies */
    (void)setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    const char *why = library ? NULL : dlerror();
    if (!why) {
        void *ode = dlopen("libode.so.8", RTLD_NOW | RTLD_LOCAL);
        void *step = dlsym(library, "dWorldQuickStep"); /* this is ODE's own where the library has none */
        if (!ode || !step || step == dlsym(ode, "dWorldQuickStep")) why = "it is not Pinch's";
    }
    size_t length = why ? strlen(why) : 0;
    _exit(length > 0 && write(stream, why, length) <= (ssize_t)length ? 1 : 0);
}

/* Returns false when memory or processes run out. */
static bool load_in_child(const char *path, bool *loads, char reason[MOST_REASON])
{
    int ends[2], status = 0;
    size_t length = 0;
    if (pipe(ends) != 0) return false;
    pid_t child = fork();
    if (child == 0) load_and_report(path, ends[1]);
    close(ends[1]);
    while (child > 0 && length < MOST_REASON - 1) {
        ssize_t n = read(ends[0], reason + length, MOST_REASON - 1 - length);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        length += (size_t)n;
    }
    close(ends[0]);
    reason[length] = '\0';
    if (child < 0) return false;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return false;
    *loads = status == 0;
    return true;
}

/* Finds the library that `pinch exec` loads before a program's others, and tries it. A loader that cannot load it would
 * say so and run the program without it. Returns COMMAND_SYSTEM, with the reason on standard error, where there is no
 * library or it cannot be loaded. */
static command_status find_library(char *path, size_t size)
{
    char reason[MOST_REASON] = "it is not whole";
    bool loads = false;
    if (!own_place_find(library_places, path, size)) {
        command_error("exec", "%s is neither beside this command nor in %s", LIBRARY, PINCH_LIBRARY_FROM_COMMAND);
        return COMMAND_SYSTEM;
    }
    if (is_whole(path) && !load_in_child(path, &loads, reason)) {
        command_error("exec", "%s cannot be tried: %s", path, strerror(errno));
        return COMMAND_SYSTEM;
    }
    if (loads) return COMMAND_DONE;
    size_t named = strlen(path);
    bool twice = strncmp(reason, path, named) == 0 && strncmp(reason + named, ": ", 2) == 0;
    command_error("exec", "%s cannot be loaded: %s", path,
                  !*reason ? "it is damaged"
                  : twice  ? reason + named + 2
                           : reason);
    return COMMAND_SYSTEM;
}

/* ---- Becoming the program. ---- */

static command_status out_of_memory(void)
{
    command_error("exec", "out of memory");
    return COMMAND_SYSTEM;
}

static command_status preload(void)
{
    char path[MOST_PATH];
    command_status status = find_library(path, sizeof path);
    if (status != COMMAND_DONE) return status;
    if (strpbrk(path, ": ")) {
        command_error("exec", "%s: the loader takes no name with a space or a colon; move Pinch elsewhere", path);
        return COMMAND_SYSTEM;
    }
    const char *others = getenv("LD_PRELOAD");
    size_t size = strlen(path) + (others ? strlen(others) : 0) + 2;
    char *list = malloc(size), process[32];
    if (list) snprintf(list, size, "%s%s%s", path, others && *others ? ":" : "", others ? others : "");
    snprintf(process, sizeof process, "%ld", (long)getpid());
    bool good = list && setenv("LD_PRELOAD", list, 1) == 0 && setenv(PINCH_ENV_PROCESS, process, 1) == 0;
    free(list);
    return good ? COMMAND_DONE : out_of_memory();
}

/* The file that execvp will choose. Returns false where there is none. */
static bool find_program(const char *name, char *path, size_t size)
{
    const char *folders = getenv("PATH");
    if (strchr(name, '/') || !folders) return (size_t)snprintf(path, size, "%s", name) < size;
    while (true) {
        size_t length = strcspn(folders, ":");
        int n = snprintf(path, size, "%.*s%s%s", (int)length, folders, length ? "/" : "", name);
        struct stat status;
        if ((size_t)n < size && access(path, X_OK) == 0 && stat(path, &status) == 0 && S_ISREG(status.st_mode))
            return true;
        if (!folders[length]) return false;
        folders += length + 1;
    }
}

/* Is the program statically linked? Then it names no loader, and nothing can be loaded before it. A file that is not
 * certainly of that kind counts as not static. */
static bool is_static(const char *program)
{
    char path[MOST_PATH];
    FILE *file = find_program(program, path, sizeof path) ? fopen(path, "rb") : NULL;
    if (!file) return false;
    Elf64_Ehdr head;
    bool elf = fread(&head, sizeof head, 1, file) == 1 && memcmp(head.e_ident, ELFMAG, SELFMAG) == 0 &&
               head.e_ident[EI_CLASS] == ELFCLASS64 && head.e_phentsize == sizeof(Elf64_Phdr) &&
               (head.e_type == ET_EXEC || head.e_type == ET_DYN);
    bool loader = !elf || fseek(file, (long)head.e_phoff, SEEK_SET) != 0;
    for (int i = 0; i < head.e_phnum && !loader; i++) {
        Elf64_Phdr part;
        loader = fread(&part, sizeof part, 1, file) != 1 || part.p_type == PT_INTERP;
    }
    fclose(file);
    return elf && !loader;
}

/* ---- What --stats replaces, for the case that there is no program after all. ---- */

typedef struct old_file {
    char *text; /* NULL: there was none */
    size_t length;
} old_file;

/* Returns COMMAND_DONE also where there is no such file. Without its text a file is not replaced: nobody could put it
 * back. */
static command_status read_old(const char *stats, old_file *old)
{
    struct stat status;
    *old = (old_file){NULL, 0};
    if (!stats || stat(stats, &status) != 0 || !S_ISREG(status.st_mode)) return COMMAND_DONE;
    FILE *file = fopen(stats, "rb");
    bool there = !file && errno == EACCES;
    old->text = file ? malloc((size_t)status.st_size + 1) : NULL;
    if (old->text) old->length = fread(old->text, 1, (size_t)status.st_size, file);
    bool whole = old->text && old->length == (size_t)status.st_size;
    if (file) fclose(file);
    if (whole) return COMMAND_DONE;
    free(old->text);
    old->text = NULL;
    command_error("exec", "--stats: %s cannot be read, and would be lost: %s", stats, strerror(errno));
    return there ? COMMAND_BAD_INPUT : COMMAND_SYSTEM;
}

/* Writes the file as a whole or not at all. */
static bool replace_file(const char *path, const char *text, size_t length)
{
    whole_file file;
    if (!whole_file_open(&file, path)) return false;
    (void)fwrite(text, 1, length, file.stream);
    return whole_file_close(&file, true);
}

static void put_back(const char *path, const old_file *old)
{
    if (!*path) return;
    if (!old->text) (void)unlink(path);
    if (old->text && !replace_file(path, old->text, old->length))
        command_error("exec", "--stats: what was in %s could not be put back: %s", path, strerror(errno));
}

/* Writes the statistics of no steps in place of any older ones. The file will be replaced by others of its name, so it
 * must not be a device or a pipe. */
static command_status write_empty_statistics(const char *path)
{
    struct stat status;
    if (stat(path, &status) == 0 && !S_ISREG(status.st_mode)) {
        command_error("exec", "--stats: expected a file, or - for standard error, got \"%s\"", path);
        return COMMAND_BAD_INPUT;
    }
    char text[MOST_DOCUMENT];
    int length = pinch_dropin_write_statistics(text, sizeof text);
    if (length > 0 && length < MOST_DOCUMENT && replace_file(path, text, (size_t)length)) return COMMAND_DONE;
    int error = errno;
    command_error("exec", "--stats: %s cannot be written: %s", path, strerror(error));
    return command_status_of(error);
}

/* `path` becomes the file's absolute name, as the program may change its folder. It is empty for standard error. */
static command_status prepare_stats(const char *stats, char *path, size_t size, const old_file *old)
{
    *path = '\0';
    if (!stats || strcmp(stats, "-") == 0) {
        bool good = stats ? setenv(PINCH_ENV_STATS, stats, 1) == 0 : unsetenv(PINCH_ENV_STATS) == 0;
        return good ? COMMAND_DONE : out_of_memory();
    }
    char folder[MOST_PATH] = "";
    if (*stats != '/' && !getcwd(folder, sizeof folder)) {
        command_error("exec", "--stats: the working folder has no name: %s", strerror(errno));
        return COMMAND_SYSTEM;
    }
    if ((size_t)snprintf(path, size, "%s%s%s", folder, *folder ? "/" : "", stats) >= size) {
        command_error("exec", "--stats: expected a name of less than %zu characters", size);
        return COMMAND_BAD_INPUT;
    }
    command_status status = write_empty_statistics(path);
    if (status != COMMAND_DONE) return status;
    char *real = realpath(path, NULL); /* the file behind a link is replaced, not the link */
    bool good = real && setenv(PINCH_ENV_STATS, real, 1) == 0;
    free(real);
    if (good) return COMMAND_DONE;
    put_back(path, old);
    return out_of_memory();
}

/* Says so where a program gets more rights than its caller has: the loader then loads nothing before its libraries. */
static void warn_of_rights(const char *program)
{
    char path[MOST_PATH];
    struct stat status;
    if (!find_program(program, path, sizeof path) || stat(path, &status) != 0) return;
    bool user = (status.st_mode & S_ISUID) && status.st_uid != getuid();
    bool group = (status.st_mode & S_ISGID) && status.st_gid != getgid();
    bool capable = getuid() != 0 && getxattr(path, "security.capability", NULL, 0) > 0;
    if (user || group || capable)
        command_error("exec", "%s runs with rights of its own (%s): Pinch does not reach it", program,
                      user    ? "set-uid"
                      : group ? "set-gid"
                              : "capabilities");
}

static void report_static(const char *program, const char *stats)
{
    char text[MOST_DOCUMENT];
    if (!stats) return;
    if (strcmp(stats, "-") == 0 && pinch_dropin_write_statistics(text, sizeof text) > 0) fputs(text, stderr);
    command_error("exec", "%s is statically linked: Pinch does not reach it", program);
}

/* Becomes the program arguments[0], with the preloaded library before its others. It returns only where that fails,
 * with the status to exit with (126, 127, 2 or 3) and the reason on standard error. `stats` is a file name, "-" for
 * standard error, or NULL. The file is written with no steps in it before the program runs, so that a program which
 * Pinch does not reach leaves it behind as well. */
static command_status launch(const char *stats, char **arguments, int count)
{
    char path[MOST_PATH];
    old_file old = {NULL, 0};
    command_status status = preload();
    if (status != COMMAND_DONE) return status;
    char **program = calloc((size_t)count + 1, sizeof *program);
    if (!program) return out_of_memory();
    status = read_old(stats, &old);
    if (status == COMMAND_DONE) status = prepare_stats(stats, path, sizeof path, &old);
    if (status != COMMAND_DONE) {
        free(program);
        free(old.text);
        return status;
    }
    memcpy(program, arguments, (size_t)count * sizeof *program);
    if (is_static(program[0])) report_static(program[0], stats);
    warn_of_rights(program[0]);
    (void)fflush(NULL);
    execvp(program[0], program);
    int error = errno;
    put_back(path, &old);
    command_error("exec", "%s: %s", program[0], strerror(error));
    free(old.text);
    free(program);
    return (command_status)(error == ENOENT || error == ENOTDIR ? NOT_FOUND : NOT_EXECUTABLE);
}

/* ---- The options. ---- */

static bool set_text(const char *name, const char *value)
{
    return (value ? setenv(name, value, 1) : unsetenv(name)) == 0;
}

static bool set_number(const char *name, bool given, double value)
{
    char text[64];
    snprintf(text, sizeof text, "%.17g", value);
    return set_text(name, given ? text : NULL);
}

/* A variable whose option was not given is removed, whatever it was before. */
static bool set_environment(const options *o)
{
    static const char *const scopes[] = {"all", "soft", "material"};
    return set_text(PINCH_ENV_SCOPE, o->given[OPTION_ONLY] ? scopes[o->only] : NULL) &&
           set_text(PINCH_ENV_SOLVER, o->given[OPTION_EXEC_SOLVER] ? pinch_solver_name(o->solver) : NULL) &&
           set_number(PINCH_ENV_RATIO, o->given[OPTION_KT_RATIO], o->kt_ratio) &&
           set_number(PINCH_ENV_TOLERANCE, o->given[OPTION_TOLERANCE], o->tolerance) &&
           set_number(PINCH_ENV_MAX_ITERATIONS, o->given[OPTION_MAX_ITERATIONS], o->max_iterations) &&
           set_number(PINCH_ENV_RECORD_MOST, o->given[OPTION_RECORD], COMMAND_MOST_RECORDINGS) &&
           set_text(PINCH_ENV_RECORD_ALL, o->record_all ? "1" : NULL);
}

/* The settings as they are shown in the statistics of a program that Pinch does not reach. */
static void use_settings(const options *o)
{
    pinch_ode_settings settings = pinch_ode_default_settings();
    if (o->given[OPTION_ONLY]) settings.scope = (pinch_ode_scope)o->only;
    if (o->given[OPTION_EXEC_SOLVER]) settings.solver.solver = o->solver;
    if (o->given[OPTION_KT_RATIO]) settings.tangential_ratio = o->kt_ratio;
    if (o->given[OPTION_TOLERANCE]) settings.solver.tolerance = o->tolerance;
    if (o->given[OPTION_MAX_ITERATIONS]) settings.solver.max_iterations = o->max_iterations;
    if (settings.solver.goal > settings.solver.tolerance) settings.solver.goal = settings.solver.tolerance;
    (void)pinch_dropin_set_settings(&settings);
}

static command_status prepare_record(const options *o)
{
    char path[MOST_PATH];
    if (!o->given[OPTION_RECORD]) return unsetenv(PINCH_ENV_RECORD) == 0 ? COMMAND_DONE : out_of_memory();
    command_status status = command_make_folder("exec", o->record, path, sizeof path);
    if (status != COMMAND_DONE) return status;
    return setenv(PINCH_ENV_RECORD, path, 1) == 0 ? COMMAND_DONE : out_of_memory();
}

static command_status run_exec(const options *given)
{
    options o = *given;
    json_t *document = NULL;
    command_status status = o.given[OPTION_CONFIG] ? exec_config_read(&o, &document) : COMMAND_DONE;
    if (status == COMMAND_DONE) status = command_check_needs(&o);
    if (status == COMMAND_DONE) status = prepare_record(&o);
    if (status == COMMAND_DONE) {
        use_settings(&o);
        status = set_environment(&o) ? launch(o.given[OPTION_STATS] ? o.stats : NULL, o.arguments, o.argument_count)
                                     : out_of_memory();
    }
    json_decref(document);
    return status;
}

static const option_id exec_options[] = {OPTION_ONLY,           OPTION_KT_RATIO, OPTION_EXEC_SOLVER, OPTION_TOLERANCE,
                                         OPTION_MAX_ITERATIONS, OPTION_CONFIG,   OPTION_STATS,       OPTION_RECORD,
                                         OPTION_RECORD_ALL,     OPTION_COUNT};

const command command_exec = {
    .name = "exec",
    .arguments = "-- PROGRAM [ARGUMENTS...]",
    .summary = "runs an unmodified ODE program with Pinch as its contact solver",
    .notes = "Pinch stands in for the dynamic symbols of libode.so.8. It does not reach programs that are linked with\n"
             "libode.a or statically as a whole, set-uid programs and those with capabilities, libraries opened with\n"
             "RTLD_DEEPBIND or dlmopen, and programs that look ODE's functions up with dlsym in a library that they\n"
             "opened themselves.\n\n"
             "--config FILE.json may have the keys only, kt_ratio, solver, tolerance, max_iterations, stats and\n"
             "record; the command line goes before it. --stats writes the file about once a second while worlds\n"
             "are stepped, and at the end, also by SIGTERM and SIGINT; it writes to standard error only at the end. "
             "\"steps\": 0 means that\n"
             "no ODE world was stepped. Of several processes that step worlds, the file is from the one that wrote\n"
             "last. --record DIR writes islands on which the solver fails; pinch replay solves them again.\n\n"
             "The exit status is the program's own. It is 127 where there is no such program, 126 where it cannot be\n"
             "run, 2 for wrong options, and 3 where the system fails or the library that Pinch loads is missing or\n"
             "damaged; the program is not run then.",
    .min_arguments = 1,
    .max_arguments = INT_MAX,
    .takes_program = true,
    .options = exec_options,
    .run = run_exec,
};
