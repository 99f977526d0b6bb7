/* A library that is preloaded into `pinch`: the allocation whose number is in PINCH_TEST_FAIL_ALLOCATION fails. The
 * numbers start from 1 at the start of the program. What shared libraries allocate before that, when they are loaded,
 * is out of the program's hands. */
#define _GNU_SOURCE

#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>

/* What glibc calls its own functions; unlike dlsym, they can be called before anything is set up. */
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

void *malloc(size_t size)
{
    return fails() ? NULL : __libc_malloc(size);
}

void *calloc(size_t number, size_t size)
{
    return fails() ? NULL : __libc_calloc(number, size);
}

void *realloc(void *memory, size_t size)
{
    return fails() ? NULL : __libc_realloc(memory, size);
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
