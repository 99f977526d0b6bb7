/* Counts calls of the allocator. The linker sends the calls of this program and of its static libraries through this
 * file. ODE has handlers of its own for its calls. */
#include "allocations.h"

#include <ode/ode.h>
#include <stdlib.h>

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);

static long allocations;

void *__wrap_malloc(size_t size)
{
    allocations++;
    return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    allocations++;
    return __real_calloc(count, size);
}

void *__wrap_realloc(void *old, size_t size)
{
    allocations++;
    return __real_realloc(old, size);
}

static void *ode_malloc(dsizeint size)
{
    return __wrap_malloc(size);
}

static void *ode_realloc(void *old, dsizeint old_size, dsizeint size)
{
    (void)old_size;
    return __wrap_realloc(old, size);
}

static void ode_free(void *memory, dsizeint size)
{
    (void)size;
    free(memory);
}

void allocations_count_ode(void)
{
    if (dGetAllocHandler())
        return; /* those of the command are in this program: they are counted, and never give NULL */
    dSetAllocHandler(ode_malloc);
    dSetReallocHandler(ode_realloc);
    dSetFreeHandler(ode_free);
}

long allocations_counted(void)
{
    return allocations;
}
