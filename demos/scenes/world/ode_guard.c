/* ODE checks its own numbers with assertions, which end the process. Scenes whose numbers grow out of range reach them.
 */
#include "world.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static jmp_buf *landing; /* NULL outside of a step */
/* Worlds that ODE left in the middle of a step. ODE can neither destroy them nor be closed any more. */
static world *abandoned;

/* ODE calls this in place of its own handlers, which abort. It must not return. Outside of a step there is nothing to
 * go back to. */
static void give_up(int number, const char *message, va_list arguments)
{
    if (landing) longjmp(*landing, 1);
    fprintf(stderr, "pinch: ODE gave up (error %d): ", number);
    vfprintf(stderr, message, arguments);
    fputc('\n', stderr);
    abort();
}

world_status world_guarded_step(world *w, world_status (*step)(world *w))
{
    jmp_buf here;
    dSetDebugHandler(give_up);
    dSetErrorHandler(give_up);
    if (setjmp(here)) {
        landing = NULL;
        w->next_abandoned = abandoned;
        abandoned = w;
        return WORLD_DIVERGED;
    }
    landing = &here;
    world_status status = step(w);
    landing = NULL;
    return status;
}

bool world_is_abandoned(const world *w)
{
    const world *other = abandoned;
    while (other && other != w) other = other->next_abandoned;
    return other != NULL;
}

void world_close_ode(void)
{
    if (!abandoned) dCloseODE();
}
