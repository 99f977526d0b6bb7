#define _POSIX_C_SOURCE 200809L

#include "support/program.h"

#include <dirent.h>
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static void require(int good, const char *what)
{
    if (good) return;
    perror(what);
    abort();
}

static char *read_stream(FILE *stream)
{
    size_t length = 0, capacity = 4096;
    char *text = malloc(capacity);
    require(text != NULL, "malloc");
    rewind(stream);
    for (;;) {
        size_t got = fread(text + length, 1, capacity - length - 1, stream);
        length += got;
        if (got == 0) break;
        if (length + 1 < capacity) continue;
        capacity *= 2;
        text = realloc(text, capacity);
        require(text != NULL, "realloc");
    }
    text[length] = '\0';
    return text;
}

program_result program_run(const char *folder, char *const argv[])
{
    /* files, not pipes: whatever the program writes, it cannot block on us */
    FILE *out = tmpfile(), *err = tmpfile();
    require(out && err, "tmpfile");
    pid_t child = fork();
    require(child >= 0, "fork");
    if (child == 0) {
        if (folder && chdir(folder) != 0) _exit(126);
        if (dup2(fileno(out), STDOUT_FILENO) < 0 || dup2(fileno(err), STDERR_FILENO) < 0) _exit(126);
        execv(argv[0], argv);
        _exit(127);
    }
    int status;
    require(waitpid(child, &status, 0) == child, "waitpid");
    program_result result = {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_stream(out),
                             read_stream(err)};
    fclose(out);
    fclose(err);
    return result;
}

void program_free(program_result *result)
{
    free(result->out);
    free(result->err);
}

static char *join(const char *folder, const char *name)
{
    size_t size = strlen(folder) + strlen(name) + 2;
    char *path = malloc(size);
    require(path != NULL, "malloc");
    snprintf(path, size, "%s/%s", folder, name);
    return path;
}

char *program_make_folder(void)
{
    const char *base = getenv("TMPDIR");
    char *path = join(base && *base ? base : "/tmp", "pinch-test-XXXXXX");
    require(mkdtemp(path) != NULL, "mkdtemp");
    return path;
}

/* calls for every entry but . and ..; returns how many there were */
static int each_entry(const char *folder, void (*act)(const char *path))
{
    DIR *stream = opendir(folder);
    require(stream != NULL, folder);
    int count = 0;
    struct dirent *entry;
    while ((entry = readdir(stream))) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) continue;
        count++;
        char *path = join(folder, entry->d_name);
        if (act) act(path);
        free(path);
    }
    closedir(stream);
    return count;
}

static void remove_path(const char *path)
{
    require(remove(path) == 0, path);
}

void program_remove_folder(char *folder)
{
    each_entry(folder, remove_path);
    remove_path(folder);
    free(folder);
}

int program_count_entries(const char *folder)
{
    return each_entry(folder, NULL);
}

char *program_write_file(const char *folder, const char *name, const char *text)
{
    char *path = join(folder, name);
    FILE *stream = fopen(path, "wb");
    require(stream && fputs(text, stream) >= 0 && fclose(stream) == 0, path);
    return path;
}

char *program_read_file(const char *path)
{
    FILE *stream = fopen(path, "rb");
    require(stream != NULL, path);
    char *text = read_stream(stream);
    fclose(stream);
    return text;
}

const char *const *shipped_scenes(void)
{
    enum { LEAST = 10 };
    static glob_t found; /* ends with NULL */
    if (found.gl_pathv) return (const char *const *)found.gl_pathv;
    require(glob(PINCH_SOURCE_DIR "/assets/scenes/*.json", 0, NULL, &found) == 0, "glob");
    require(found.gl_pathc >= LEAST, "the shipped scenes");
    return (const char *const *)found.gl_pathv;
}

const char *file_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}
