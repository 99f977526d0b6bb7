/* A library that is preloaded into `pinch`: the allocation whose number is in PINCH_TEST_FAIL_ALLOCATION fails. The
 * numbers start from 1 at the start of the program. What shared libraries allocate before that, when they are loaded,
 * is out of the program's hands.
 *
 * Where PINCH_TEST_FAIL_FOLDER names a folder, one run serves for all allocations, or for each n-th with
 * PINCH_TEST_FAIL_EVERY=n: at each of them the process forks, the allocation fails in the child, and the parent waits
 * for the child to end and goes on as if nothing had happened. A child neither loads the program again nor repeats what
 * came before the allocation. What child k of process p writes to its standard streams is in FOLDER/p-k.out and
 * FOLDER/p-k.err; of how it ended there is a line "p k status" in FOLDER/ends, with the status of waitpid. Processes
 * that the program forks do the same. Their children end alone: the process that waits for an answer gets it from the
 * one that lost nothing. A program that takes the place of another one in the same process goes on with its numbers.
 *
 * PINCH_TEST_FAIL_IN=NAME:NAME counts those allocations alone that a library asks for whose file name has one of these
 * in it: what ODE does without memory is not Pinch's to say.
 */
#define _GNU_SOURCE

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

/* What glibc calls its own functions. They can be called before anything is set up. */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *memory, size_t size);

static atomic_long count;
static atomic_int started;

/* ---- one run for all allocations ---- */

enum { MOST_FILES = 64, MOST_SECONDS = 120 };

static const char *folder; /* NULL: not asked for, or in a child */
static long every;

/* The harness itself has failed: nothing that the program could say may look like its own end. */
static void give_up(void)
{
    static const char why[] = "starved.c: a child or its files cannot be made\n";
    if (write(STDERR_FILENO, why, sizeof why - 1) < 0) _exit(98);
    _exit(99);
}

/* Puts a file of its own, with what the old one holds until now, in the place of an open file. */
static void replace_file(int file, int by)
{
    char path[64], data[4096];
    struct stat about;
    int closes = fcntl(file, F_GETFD);
    if (by < 0 || fstat(file, &about) != 0) give_up();
    if (S_ISREG(about.st_mode)) {
        off_t place = lseek(file, 0, SEEK_CUR);
        snprintf(path, sizeof path, "/proc/self/fd/%d", file);
        int old = open(path, O_RDONLY);
        ssize_t got;
        while ((got = read(old, data, sizeof data)) > 0)
            if (write(by, data, (size_t)got) != got) give_up();
        if (got < 0 || close(old) != 0 || lseek(by, place, SEEK_SET) != place) give_up();
    }
    if (dup3(by, file, closes & FD_CLOEXEC ? O_CLOEXEC : 0) < 0 || close(by) != 0) give_up();
}

static void keep_stream(int stream, long k, const char *suffix)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%d-%ld.%s", folder, (int)getppid(), k, suffix);
    replace_file(stream, open(path, O_RDWR | O_CREAT | O_EXCL, 0600));
}

/* Parent and child share the open files, and the places in them. The child gets its own. What it writes into a pipe
 * would come between what its parent writes. */
static void own_files(void)
{
    for (int file = STDERR_FILENO + 1; file < MOST_FILES; file++) {
        struct stat about;
        if (fstat(file, &about) != 0) continue;
        if (S_ISREG(about.st_mode)) replace_file(file, memfd_create("own", 0));
        if (S_ISFIFO(about.st_mode) && (fcntl(file, F_GETFL) & O_ACCMODE) == O_WRONLY)
            replace_file(file, open("/dev/null", O_WRONLY));
    }
}

/* Returns 1 in the child, where the allocation is to fail, and 0 in the parent once the child has ended. */
static int fails_in_child(long k)
{
    if (every > 1 && k % every != 1) return 0;
    int before = errno, status;
    pid_t child = fork();
    if (child < 0) give_up();
    if (child == 0) {
        keep_stream(STDOUT_FILENO, k, "out");
        keep_stream(STDERR_FILENO, k, "err");
        own_files();
        alarm(MOST_SECONDS);
        folder = NULL;
        errno = ENOMEM;
        return 1;
    }
    while (waitpid(child, &status, 0) != child)
        if (errno != EINTR) give_up();
    char path[4096], line[64];
    snprintf(path, sizeof path, "%s/ends", folder);
    int length = snprintf(line, sizeof line, "%d %ld %d\n", (int)getpid(), k, status);
    int ends = open(path, O_WRONLY | O_CREAT | O_APPEND, 0600);
    if (ends < 0 || write(ends, line, (size_t)length) != length || close(ends) != 0) give_up();
    errno = before;
    return 0;
}

/* What an earlier program of this process has counted. */
static long counted_before(void)
{
    char path[4096];
    int process, status;
    long k, most = 0;
    snprintf(path, sizeof path, "%s/ends", folder);
    FILE *stream = fopen(path, "r");
    if (!stream) return 0;
    while (fscanf(stream, "%d %ld %d", &process, &k, &status) == 3)
        if (process == getpid() && k > most) most = k;
    fclose(stream);
    return most;
}

static void read_folder(void)
{
    const char *number = getenv("PINCH_TEST_FAIL_EVERY");
    folder = getenv("PINCH_TEST_FAIL_FOLDER");
    every = number ? atol(number) : 1;
    if (folder) count = counted_before();
}

/* ---- the allocator ---- */

static int is_counted(const void *caller)
{
    const char *names = getenv("PINCH_TEST_FAIL_IN");
    Dl_info about;
    if (!names) return 1;
    if (!dladdr(caller, &about) || !about.dli_fname) return 0;
    const char *slash = strrchr(about.dli_fname, '/'), *file = slash ? slash + 1 : about.dli_fname;
    while (*names) {
        char name[64];
        size_t length = strcspn(names, ":");
        snprintf(name, sizeof name, "%.*s", (int)length, names);
        if (strstr(file, name)) return 1;
        names += length + (names[length] == ':');
    }
    return 0;
}

/* Reads the number on every call, because the first calls come before the environment can be kept. */
static int fails(const void *caller)
{
    if (!started || !is_counted(caller)) return 0;
    if (folder) return fails_in_child(atomic_fetch_add(&count, 1) + 1);
    const char *text = getenv("PINCH_TEST_FAIL_ALLOCATION");
    if (!text || atomic_fetch_add(&count, 1) + 1 != atol(text)) return 0;
    errno = ENOMEM;
    return 1;
}

/* The allocator behind this library: glibc's, or that of a leak sanitizer. dlsym itself may allocate. */
static void *next(const char *name)
{
    static _Thread_local int asking;
    if (asking) return NULL;
    asking = 1;
    void *function = dlsym(RTLD_NEXT, name);
    asking = 0;
    return function;
}

void *malloc(size_t size)
{
    static void *(*real)(size_t size);
    if (fails(__builtin_return_address(0))) return NULL;
    if (!real) *(void **)&real = next("malloc");
    return real ? real(size) : __libc_malloc(size);
}

void *calloc(size_t number, size_t size)
{
    static void *(*real)(size_t number, size_t size);
    if (fails(__builtin_return_address(0))) return NULL;
    if (!real) *(void **)&real = next("calloc");
    return real ? real(number, size) : __libc_calloc(number, size);
}

void *realloc(void *memory, size_t size)
{
    static void *(*real)(void *memory, size_t size);
    if (fails(__builtin_return_address(0))) return NULL;
    if (!real) *(void **)&real = next("realloc");
    return real ? real(memory, size) : __libc_realloc(memory, size);
}

/* A process that a program has forked ends without the handlers of exit, of which the leak sanitizer's is one. */
void _exit(int status)
{
    void (*check)(void);
    *(void **)&check = dlsym(RTLD_DEFAULT, "__lsan_do_leak_check");
    if (check && getenv("PINCH_TEST_FAIL_FOLDER")) check();
    syscall(SYS_exit_group, status);
    __builtin_unreachable();
}

/* The C library's start of a program, which comes after the constructors of all shared libraries. */
int __libc_start_main(int (*program)(int, char **, char **), int argc, char **argv, void (*init)(void),
                      void (*fini)(void), void (*loader_fini)(void), void *stack_end);

int __libc_start_main(int (*program)(int, char **, char **), int argc, char **argv, void (*init)(void),
                      void (*fini)(void), void (*loader_fini)(void), void *stack_end)
{
    int (*start)(int (*)(int, char **, char **), int, char **, void (*)(void), void (*)(void), void (*)(void), void *);
    *(void **)&start = dlsym(RTLD_NEXT, "__libc_start_main");
    read_folder();
    started = 1;
    return start(program, argc, argv, init, fini, loader_fini, stack_end);
}
