/*
 * Worlds whose numbers leave double precision in the middle of ODE's step, where ODE's assertions would end the
 * process. No scene file may ask for such masses, so that they are set here.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"
#include "support/scene_run.h"

#include "scenes/world/world.h"

#include <sys/wait.h>
#include <unistd.h>

/* Runs the egg with this mass until its end. */
static world_status run_egg(double mass, bool *diverged)
{
    scene *s = scene_shipped("egg.json");
    for (int k = 0; k < 9; k++) s->objects[0].inertia[k] *= mass / s->objects[0].mass;
    s->objects[0].mass = mass;
    world *w = world_of(s);
    world_status status = WORLD_OK;
    while (w->time < s->duration && status == WORLD_OK) status = world_advance(w);
    *diverged = w->diverged;
    world_free(w);
    scene_free(s);
    return status;
}

/* ODE loses the memory of a step that it leaves in the middle, so that this is done in a process of its own. */
static void test_ode_gives_up(void **state)
{
    (void)state;
    static const double masses[] = {6e298, 6e296};
    for (int i = 0; i < 2; i++) {
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            bool diverged;
            if (run_egg(masses[i], &diverged) != WORLD_DIVERGED || !diverged) _exit(1);
            /* what ODE left in the middle does no harm to others */
            _exit(run_egg(0.06, &diverged) != WORLD_OK || diverged ? 2 : 0);
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFEXITED(status));
        assert_int_equal(WEXITSTATUS(status), 0);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_ode_gives_up)};
    int failed = cmocka_run_group_tests_name("divergence", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
