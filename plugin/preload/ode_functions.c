#define _GNU_SOURCE /* RTLD_NEXT */

#include "preload/ode_functions.h"

#include <dlfcn.h>
#include <stddef.h>

#define PLACE(name) __attribute__((visibility("hidden"), used)) void *pinch_place_of_##name;
PINCH_ODE_FUNCTIONS(PLACE)

/* A jump leaves all arguments and results where they are, whatever their types. */
#if defined(__x86_64__)
#define JUMP(name) "endbr64\n\tjmp *pinch_place_of_" #name "(%rip)\n"
#elif defined(__aarch64__)
#define JUMP(name)                                                                                                     \
    "hint #34\n\tadrp x16, pinch_place_of_" #name "\n\tldr x16, [x16, #:lo12:pinch_place_of_" #name "]\n\tbr x16\n"
#else
#error "pinch exec: what does a jump through a pointer look like on this processor?"
#endif

#define FUNCTION(name)                                                                                                 \
    __asm__(".text\n.globl " #name "\n.hidden " #name "\n.type " #name ", %function\n" #name                           \
            ":\n\t" JUMP(name) ".size " #name ", . - " #name "\n");
PINCH_ODE_FUNCTIONS(FUNCTION)

const char *pinch_ode_functions_find(void *library)
{
#define FIND(name)                                                                                                     \
    if (!(pinch_place_of_##name = dlsym(library, #name))) return #name;
    PINCH_ODE_FUNCTIONS(FIND)
    return NULL;
}
