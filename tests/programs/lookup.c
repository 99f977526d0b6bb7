/* Looks ODE's functions up in the library itself, where no preloaded library can stand in for them. */
#define _POSIX_C_SOURCE 200809L

#include <dlfcn.h>
#include <stddef.h>
#include <string.h>

static void *library;

static void find(const char *name, void *function)
{
    void *address = dlsym(library, name);
    memcpy(function, &address, sizeof address);
}

int main(void)
{
    library = dlopen("libode.so.8", RTLD_NOW | RTLD_LOCAL);
    if (!library) return 2;
    void (*init)(void), (*end)(void), (*destroy)(void *);
    void *(*create)(void);
    int (*step)(void *world, double h);
    find("dInitODE", &init);
    find("dWorldCreate", &create);
    find("dWorldStep", &step);
    find("dWorldDestroy", &destroy);
    find("dCloseODE", &end);
    init();
    void *world = create();
    int stepped = step(world, 0.01);
    destroy(world);
    end();
    return stepped ? 0 : 1;
}
