#define _XOPEN_SOURCE 700 /* realpath */

#include "exec_library.h"

#include <dlfcn.h>
#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MOST_PATH = 4000, MOST_REASON = 512 };
static const char LIBRARY[] = "libpinch_preload.so";

/* Beside this command, as in the build tree, or where an installation has its libraries. */
static bool find(char *path, size_t size)
{
    char own[MOST_PATH];
    ssize_t length = readlink("/proc/self/exe", own, sizeof own - 1);
    if (length < 0) return false;
    own[length] = '\0';
    char *end = strrchr(own, '/');
    if (end) *end = '\0';
    static const char *const places[] = {"", "/" PINCH_LIBRARY_FROM_COMMAND};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        char place[MOST_PATH + 256];
        snprintf(place, sizeof place, "%s%s/%s", own, places[i], LIBRARY);
        char *real = realpath(place, NULL);
        bool fits = real && strlen(real) < size;
        if (fits) strcpy(path, real);
        free(real);
        if (fits) return true;
    }
    return false;
}

/* Are all parts that a loader maps within the file? It does not ask, and what runs off the end is killed when it gets
 * there, which may be late. What is no such library at all is for the loader to say. */
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

/* In a process of its own, which a damaged file may bring down: loads it, as a program's loader will, writes what it
 * has against it to `stream`, and ends. */
static void try_it(const char *path, int stream)
{
    int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere >= 0) (void)dup2(nowhere, STDERR_FILENO); /* the loader's last words */
    (void)setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    const char *why = library ? NULL : dlerror();
    if (!why) {
        void *ode = dlopen("libode.so.8", RTLD_NOW | RTLD_LOCAL);
        void *step = dlsym(library, "dWorldQuickStep"); /* ODE's own, where the library has none */
        if (!ode || !step || step == dlsym(ode, "dWorldQuickStep")) why = "it is not Pinch's";
    }
    size_t length = why ? strlen(why) : 0;
    _exit(length > 0 && write(stream, why, length) <= (ssize_t)length ? 1 : 0);
}

/* false: memory or processes ran out */
static bool try_apart(const char *path, bool *loads, char reason[MOST_REASON])
{
    int ends[2], status = 0;
    size_t length = 0;
    if (pipe(ends) != 0) return false;
    pid_t child = fork();
    if (child == 0) try_it(path, ends[1]);
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

command_status exec_find_library(char *path, size_t size)
{
    char reason[MOST_REASON] = "it is not whole";
    bool loads = false;
    if (!find(path, size)) {
        command_error("exec", "%s is neither beside this command nor in %s", LIBRARY, PINCH_LIBRARY_FROM_COMMAND);
        return COMMAND_SYSTEM;
    }
    if (is_whole(path) && !try_apart(path, &loads, reason)) {
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
