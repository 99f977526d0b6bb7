#define _XOPEN_SOURCE 700 /* realpath */

#include "exec_launch.h"

#include "exec_library.h"
#include "preload/report.h"

#include <pinch/ode_dropin.h>

#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NOT_EXECUTABLE = 126, NOT_FOUND = 127, MOST_PATH = 4000, MOST_DOCUMENT = 8192 };

static command_status preload(void)
{
    char path[MOST_PATH];
    command_status status = exec_find_library(path, sizeof path);
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
    if (!good) command_error("exec", "out of memory");
    return good ? COMMAND_DONE : COMMAND_SYSTEM;
}

/* execvp's choice, to look at before; false: there is none */
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

/* An executable that names no loader: nothing can be loaded before it. What is not such a file for sure is none. */
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

/* The document of no steps, in place of any older one. The file will be replaced by others of its name, which a device
 * or a pipe must not be. */
static command_status start_file(const char *path)
{
    struct stat status;
    if (stat(path, &status) == 0 && !S_ISREG(status.st_mode)) {
        command_error("exec", "--stats: expected a file, or - for standard error, got \"%s\"", path);
        return COMMAND_BAD_INPUT;
    }
    char text[MOST_DOCUMENT];
    int length = pinch_dropin_write_statistics(text, sizeof text);
    FILE *file = fopen(path, "w");
    if (!file) {
        command_error("exec", "--stats: %s cannot be written: %s", path, strerror(errno));
        return COMMAND_BAD_INPUT;
    }
    bool good = length > 0 && length < MOST_DOCUMENT && fputs(text, file) >= 0;
    if (fclose(file) == 0 && good) return COMMAND_DONE;
    command_error("exec", "--stats: %s cannot be written", path);
    return COMMAND_SYSTEM;
}

/* `path`: the file's absolute name, as the program may change its folder; empty for standard error. */
static command_status prepare_stats(const char *stats, char *path, size_t size)
{
    *path = '\0';
    if (!stats || strcmp(stats, "-") == 0) {
        bool good = stats ? setenv(PINCH_ENV_STATS, stats, 1) == 0 : unsetenv(PINCH_ENV_STATS) == 0;
        return good ? COMMAND_DONE : COMMAND_SYSTEM;
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
    command_status status = start_file(path);
    char *real = status == COMMAND_DONE ? realpath(path, NULL) : NULL; /* a link stays one */
    if (status == COMMAND_DONE && (!real || setenv(PINCH_ENV_STATS, real, 1) != 0)) status = COMMAND_SYSTEM;
    free(real);
    return status;
}

static void tell_static(const char *program, const char *stats)
{
    char text[MOST_DOCUMENT];
    if (!stats) return;
    if (strcmp(stats, "-") == 0 && pinch_dropin_write_statistics(text, sizeof text) > 0) fputs(text, stderr);
    command_error("exec", "%s is statically linked: Pinch does not reach it", program);
}

command_status exec_launch(const char *stats, char **arguments, int count)
{
    char path[MOST_PATH];
    char **program = calloc((size_t)count + 1, sizeof *program);
    command_status status = program ? preload() : COMMAND_SYSTEM;
    if (status == COMMAND_DONE) status = prepare_stats(stats, path, sizeof path);
    if (status != COMMAND_DONE) {
        free(program);
        return status;
    }
    memcpy(program, arguments, (size_t)count * sizeof *program);
    if (is_static(program[0])) tell_static(program[0], stats);
    (void)fflush(NULL);
    execvp(program[0], program);
    int error = errno;
    if (*path) (void)unlink(path);
    command_error("exec", "%s: %s", program[0], strerror(error));
    free(program);
    return (command_status)(error == ENOENT || error == ENOTDIR ? NOT_FOUND : NOT_EXECUTABLE);
}
