/* The parent steps 20 times and then --after times; its child steps --child times, or does nothing. */
#define _POSIX_C_SOURCE 200809L

#include "sim.h"

#include <sys/wait.h>
#include <unistd.h>

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 20);
    sim_ground(s);
    sim_box(s, 1, 0.5, 0.5, 0.5, 0, 0, 0.25);
    sim_run(s);
    pid_t child = fork();
    if (child < 0) return 3;
    s->steps += (long)sim_value(s, child == 0 ? "child" : "after", 0);
    int status = 0;
    if (child > 0 && waitpid(child, &status, 0) != child) return 3;
    sim_run(s);
    if (child == 0) return 0;
    sim_print(s, "forks");
    return sim_close(s);
}
