/* A library that is preloaded into `pinch`: the allocation whose number is in PINCH_TEST_FAIL_ALLOCATION fails. The
 * numbers start from 1 at the start of the program. What shared libraries allocate before that, when they are loaded,
 * is out of the program's hands. */
#define _GNU_SOURCE

#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>

/* What glibc calls its own functions. They can be called before anything is set up. */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *memory, size_t size);

static atomic_long count;
static atomic_int started;

/* Reads the number on every call, because the first calls come before the environment can be kept. */
static int fails(void)
{
    const char *text = getenv("PINCH_TEST_FAIL_ALLOCATION");
    if (!text || !started || atomic_fetch_add(&count, 1) + 1 != atol(text)) return 0;
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
    if (fails()) return NULL;
    if (!real) *(void **)&real = next("malloc");
    return real ? real(size) : __libc_malloc(size);
}

void *calloc(size_t number, size_t size)
{
    static void *(*real)(size_t number, size_t size);
    if (fails()) return NULL;
    if (!real) *(void **)&real = next("calloc");
    return real ? real(number, size) : __libc_calloc(number, size);
}

void *realloc(void *memory, size_t size)
{
    static void *(*real)(void *memory, size_t size);
    if (fails()) return NULL;
    if (!real) *(void **)&real = next("realloc");
    return real ? real(memory, size) : __libc_realloc(memory, size);
}

/* The C library's start of a program, which comes after the constructors of all shared libraries. */
int __libc_start_main(int (*program)(int, char **, char **), int argc, char **argv, void (*init)(void),
                      void (*fini)(void), void (*loader_fini)(void), void *stack_end);

int __libc_start_main(int (*program)(int, char **, char **), int argc, char **argv, void (*init)(void),
                      void (*fini)(void), void (*loader_fini)(void), void *stack_end)
{
    int (*start)(int (*)(int, char **, char **), int, char **, void (*)(void), void (*)(void), void (*)(void), void *);
    *(void **)&start = dlsym(RTLD_NEXT, "__libc_start_main");
    started = 1;
    return start(program, argc, argv, init, fini, loader_fini, stack_end);
}
