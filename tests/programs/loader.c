/* Opens a module with local scope and runs its scene, as an interpreter does with its extensions. */
#define _POSIX_C_SOURCE 200809L

#include <dlfcn.h>
#include <string.h>

int main(int argc, char **argv)
{
    void *module = argc == 2 ? dlopen(argv[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    void *address = module ? dlsym(module, "module_run") : NULL;
    int (*run)(int steps);
    if (!address) return 2;
    memcpy(&run, &address, sizeof run);
    return run(40);
}
