/*
 * Islands with couplings are recorded and replayed: a tendon over three hinges is one row for three bodies, which goes
 * on in rows of its own (pinch_joint_row.continues).
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"

#include <ode/ode.h>

#include <pinch/ode.h>
#include <stdio.h>
#include <string.h>

enum { ARMS = 3, STEPS = 20 };
static const double H = 1e-3;

typedef struct rig {
    dWorldID world;
    pinch_ode *plugin;
    dJointID hinge[ARMS];
    dGeomID tip, ground;
} rig;

/* Arms on hinges of their own, side by side; the tip of the first lies on the ground. */
static void rig_make(rig *r, pinch_ode_record_folder *folder)
{
    r->world = dWorldCreate();
    dWorldSetGravity(r->world, 0, 0, -9.81);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.recorder = pinch_ode_record_into_folder;
    settings.recorder_context = folder;
    settings.record_all = true;
    assert_int_equal(pinch_ode_create(r->world, &settings, &r->plugin), PINCH_OK);
    for (int i = 0; i < ARMS; i++) {
        dMass mass;
        dBodyID body = dBodyCreate(r->world);
        dMassSetBoxTotal(&mass, 0.1, 0.1, 0.02, 0.02);
        dBodySetMass(body, &mass);
        dBodySetPosition(body, 0, 0.1 * i, 0.0199);
        r->hinge[i] = dJointCreateHinge(r->world, NULL);
        dJointAttach(r->hinge[i], body, NULL);
        dJointSetHingeAnchor(r->hinge[i], -0.05, 0.1 * i, 0.0199);
        dJointSetHingeAxis(r->hinge[i], 0, 1, 0);
        assert_int_equal(pinch_ode_note_joint(r->plugin, r->hinge[i]), PINCH_OK);
        if (i > 0) continue;
        r->tip = dCreateSphere(NULL, 0.02);
        dGeomSetBody(r->tip, body);
    }
    r->ground = dCreatePlane(NULL, 0, 0, 1, 0);
}

static void rig_free(rig *r)
{
    pinch_ode_destroy(r->plugin);
    dGeomDestroy(r->tip);
    dGeomDestroy(r->ground);
    dWorldDestroy(r->world);
}

static void rig_step(rig *r)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    contact.surface.mu = 0.5;
    if (dCollide(r->tip, r->ground, 1, &contact.geom, sizeof contact.geom) > 0)
        assert_int_equal(pinch_ode_add_contact(r->plugin, &contact, dGeomGetBody(r->tip), NULL), PINCH_OK);
    assert_int_equal(pinch_ode_step(r->plugin, H), PINCH_OK);
}

/* Every recording replays to the same bits, and parts of a row come back with its force. Returns how many rows went on
 * in others. */
static int replay_all(const char *path, int count)
{
    int parts = 0;
    for (int i = 1; i <= count; i++) {
        char file[512];
        json_error_t error;
        snprintf(file, sizeof file, "%s/island-%06d.json", path, i);
        json_t *recorded = json_load_file(file, 0, &error);
        program_result replayed = PINCH(NULL, "replay", file, "--json");
        assert_int_equal(replayed.status, 0);
        json_t *document = cli_document(&replayed);
        assert_true(json_is_true(cli_at(document, "same_bits")) && json_is_true(cli_at(document, "verified")));
        const json_t *rows = cli_at(recorded, "problem.rows"), *solved = cli_at(document, "joint_rows");
        assert_int_equal(json_array_size(rows), json_array_size(solved));
        for (size_t k = 1; k < json_array_size(rows); k++) {
            if (!json_is_true(json_object_get(json_array_get(rows, k), "continues"))) continue;
            double force = json_number_value(json_object_get(json_array_get(solved, k), "force"));
            assert_true(force == json_number_value(json_object_get(json_array_get(solved, k - 1), "force")));
            assert_true(force != 0);
            parts++;
        }
        json_decref(document);
        json_decref(recorded);
        program_free(&replayed);
    }
    return parts;
}

static void test_replayed_to_the_same_bits(void **state)
{
    (void)state;
    for (int rigid = 0; rigid < 2; rigid++) {
        char *path = program_make_folder();
        pinch_ode_record_folder folder = {.path = path, .most = STEPS};
        rig r;
        int tendon;
        rig_make(&r, &folder);
        pinch_servo law = {.target = 0.2, .kp = rigid ? INFINITY : 3, .kd = rigid ? 0 : 0.05, .max_force = INFINITY};
        const pinch_coupling_term terms[] = {{r.hinge[0], 0, 1}, {r.hinge[1], 0, -0.5}, {r.hinge[2], 0, 0.7}};
        assert_int_equal(pinch_ode_couple(r.plugin, terms, ARMS, &law, &tendon), PINCH_OK);
        for (int step = 0; step < STEPS; step++) rig_step(&r);
        assert_int_equal(pinch_ode_statistics(r.plugin).unconverged_steps, 0);
        rig_free(&r);
        int count = program_count_entries(path);
        assert_true(count >= STEPS / 2);
        assert_true(replay_all(path, count) >= count);
        program_remove_folder(path);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_replayed_to_the_same_bits),
    };
    int failed = cmocka_run_group_tests_name("replay of couplings", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
