/* Worlds are stepped in different threads at the same time, and another thread destroys some of their geoms. */

#include "support/cmocka_all.h"

#include <pinch/ode_dropin.h>

#include <pthread.h>
#include <string.h>

enum { THREADS = 3, STEPS = 400 };

typedef struct job {
    int number;
    bool good;
} job;

static bool resets; /* the threads reset the statistics now and then */

static void *simulate(void *data)
{
    job *j = data;
    dAllocateODEDataForThread(dAllocateMaskAll);
    dWorldID world = dWorldCreate();
    dWorldSetGravity(world, 0, 0, -9.81);
    /* worlds share ODE's default, which is for one thread at a time */
    dThreadingImplementationID threading = dThreadingAllocateSelfThreadedImplementation();
    dWorldSetStepThreadingImplementation(world, dThreadingImplementationGetFunctions(threading), threading);
    dJointGroupID contacts = dJointGroupCreate(0);
    dBodyID body = dBodyCreate(world);
    dMass mass;
    dMassSetSphereTotal(&mass, 1, 0.5);
    dBodySetMass(body, &mass);
    dBodySetPosition(body, 0, 0, 0.5);
    dGeomID ground = dCreatePlane(NULL, 0, 0, 1, 0), ball = dCreateSphere(NULL, 0.5);
    dGeomSetBody(ball, body);
    j->good = true;
    for (int i = 0; i < STEPS && j->good; i++) {
        if (i % 10 == j->number) { /* another one: all worlds hear of it, stepped or not */
            dGeomDestroy(ball);
            ball = dCreateSphere(NULL, 0.5);
            dGeomSetBody(ball, body);
        }
        dContact contact;
        memset(&contact, 0, sizeof contact);
        contact.surface.mode = dContactApprox1;
        contact.surface.mu = 0.5;
        if (dCollide(ball, ground, 1, &contact.geom, sizeof contact) == 1)
            dJointAttach(dJointCreateContact(world, contacts, &contact), body, NULL);
        j->good = (j->number % 2 ? dWorldStep(world, 0.01) : dWorldQuickStep(world, 0.01)) == 1;
        dJointGroupEmpty(contacts);
        double height = dBodyGetPosition(body)[2];
        long steps = pinch_dropin_statistics().steps;
        j->good = j->good && height > 0.4 && height < 0.6 && (steps > 0 || resets);
        if (resets && i % 7 == j->number) pinch_dropin_reset_statistics();
    }
    dGeomDestroy(ball);
    dGeomDestroy(ground);
    dJointGroupDestroy(contacts);
    dWorldDestroy(world);
    dThreadingFreeImplementation(threading);
    dCleanupODEAllDataForThread();
    return NULL;
}

static void worlds_in_threads(void **state)
{
    (void)state;
    pthread_t threads[THREADS];
    job jobs[THREADS];
    pinch_dropin_stats before = pinch_dropin_statistics();
    for (int i = 0; i < THREADS; i++) {
        jobs[i].number = i;
        assert_int_equal(pthread_create(&threads[i], NULL, simulate, &jobs[i]), 0);
    }
    for (int i = 0; i < THREADS; i++) {
        assert_int_equal(pthread_join(threads[i], NULL), 0);
        assert_true(jobs[i].good);
    }
    pinch_dropin_stats after = pinch_dropin_statistics();
    assert_int_equal(after.steps - before.steps, THREADS * STEPS);
    assert_int_equal(after.worlds - before.worlds, THREADS);
    assert_int_equal(after.steps_refused, before.steps_refused);
    assert_true(after.contacts_offered - before.contacts_offered > STEPS);
}

/* Each thread resets the statistics of all worlds, also of those that the others are just stepping. */
static void statistics_are_reset_meanwhile(void **state)
{
    (void)state;
    pthread_t threads[THREADS];
    job jobs[THREADS];
    resets = true;
    for (int i = 0; i < THREADS; i++) {
        jobs[i].number = i;
        assert_int_equal(pthread_create(&threads[i], NULL, simulate, &jobs[i]), 0);
    }
    for (int i = 0; i < THREADS; i++) {
        assert_int_equal(pthread_join(threads[i], NULL), 0);
        assert_true(jobs[i].good);
    }
    assert_true(pinch_dropin_statistics().steps <= THREADS * STEPS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(worlds_in_threads),
        cmocka_unit_test(statistics_are_reset_meanwhile),
    };
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
