/* Counts calls of the allocator. The linker sends the calls of this program and of its static libraries through this
 * file. ODE has handlers of its own for its calls. */
#include "allocations.h"

#include "common/process.h"

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
    void *memory = __wrap_malloc(size);
    if (!memory && size > 0) process_end_without_memory(); /* ODE works with what it gets */
    return memory;
}

static void *ode_realloc(void *old, dsizeint old_size, dsizeint size)
{
    (void)old_size;
    void *memory = __wrap_realloc(old, size);
    if (!memory && size > 0) process_end_without_memory();
    return memory;
}

static void ode_free(void *memory, dsizeint size)
{
    (void)size;
    free(memory);
}

void allocations_count_ode(void)
{
    dSetAllocHandler(ode_malloc);
    dSetReallocHandler(ode_realloc);
    dSetFreeHandler(ode_free);
}

long allocations_counted(void)
{
    return allocations;
}
