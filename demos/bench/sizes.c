#include "bench.h"

#include <stdio.h>

bool bench_wants_size(const bench_request *o, int size)
{
    return size >= o->min_size && size <= o->max_size;
}

/* Returns the least size in the lists that is larger than this one; 0 where none is. */
static int next_size(const int *const *lists, int count, int size)
{
    int next = 0;
    for (int k = 0; k < count; k++)
        for (const int *s = lists[k]; *s > 0; s++)
            if (*s > size && (next == 0 || *s < next)) next = *s;
    return next;
}

command_status bench_check_sizes(const bench_request *o, const int *const *lists, int count)
{
    char text[160] = "";
    size_t used = 0;
    for (int size = next_size(lists, count, 0); size > 0; size = next_size(lists, count, size)) {
        if (bench_wants_size(o, size)) return COMMAND_DONE;
        int written = snprintf(text + used, sizeof text - used, used > 0 ? ", %d" : "%d", size);
        if (written > 0 && used + (size_t)written < sizeof text) used += (size_t)written;
    }
    command_error("bench", "--min-size and --max-size leave out all sizes of %s, which are %s", o->name, text);
    return COMMAND_BAD_INPUT;
}
