/*
 * A world that was restored from a snapshot, and the one that went on after it was saved, do the same to the bit: in
 * the same world, in another one, in another process. Damaged and foreign snapshots are refused, and leave everything
 * as it was.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"
#include "support/draw.h"

#include <pinch/ode.h>

#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* Counts allocations down, and fails the last one of the count; 0: none fails. The linker has every call come here. */
static long allocations_until_failure;
void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *block, size_t size);

static bool fails(void)
{
    return allocations_until_failure > 0 && --allocations_until_failure == 0;
}

void *__wrap_malloc(size_t size);
void *__wrap_malloc(size_t size)
{
    return fails() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size)
{
    return fails() ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *block, size_t size);
void *__wrap_realloc(void *block, size_t size)
{
    return fails() ? NULL : __real_realloc(block, size);
}

enum { STEPS = 300, BETWEEN = 100, MOST = 64, STATE = 13 };
static const double STEP = 2e-3;
static const char *self; /* this program's file */

/* A random world: things fall onto the ground and onto each other, hang on joints, and are gripped. */
typedef struct scene {
    dWorldID world;
    dSpaceID space;
    pinch_ode *plugin;
    dBodyID bodies[MOST];
    dGeomID geoms[MOST];
    dJointID joints[MOST];
    int body_count, geom_count, joint_count, hand;
    long step;
    bool servos, driven, handed;
} scene;

static pinch_ode_parts parts_of(const scene *s)
{
    return (pinch_ode_parts){s->bodies, s->geoms, s->joints, s->body_count, s->geom_count, s->joint_count};
}

static void offer(void *data, dGeomID a, dGeomID b)
{
    scene *s = data;
    dContact contact[8];
    dBodyID body1 = dGeomGetBody(a), body2 = dGeomGetBody(b);
    memset(contact, 0, sizeof contact);
    if ((!body1 && !body2) || (body1 && body2 && dAreConnected(body1, body2))) return;
    int count = dCollide(a, b, 8, &contact[0].geom, sizeof contact[0]);
    for (int i = 0; i < count; i++) {
        contact[i].surface.mode = dContactApprox1 | dContactBounce;
        contact[i].surface.mu = 0.4;
        contact[i].surface.bounce = 0.2;
        if (dGeomGetClass(a) == dSphereClass || dGeomGetClass(b) == dSphereClass) {
            contact[i].surface.mode |= dContactRolling;
            contact[i].surface.rho = contact[i].surface.rho2 = 1e-3;
        }
        assert_int_equal(pinch_ode_add_contact(s->plugin, &contact[i], body1, body2), PINCH_OK);
    }
}

static int add_body(scene *s, pinch_random *random, const double position[3])
{
    double size = draw_uniform(random, 0.03, 0.08);
    dMass mass;
    dGeomID geom;
    dBodyID body = s->bodies[s->body_count] = dBodyCreate(s->world);
    switch (draw_index(random, 3)) {
    case 0:
        geom = dCreateBox(s->space, size, 0.8 * size, 1.2 * size);
        dMassSetBox(&mass, 500, size, 0.8 * size, 1.2 * size);
        break;
    case 1:
        geom = dCreateSphere(s->space, 0.5 * size);
        dMassSetSphere(&mass, 500, 0.5 * size);
        break;
    default:
        geom = dCreateCapsule(s->space, 0.4 * size, size);
        dMassSetCapsule(&mass, 500, 3, 0.4 * size, size);
    }
    dBodySetMass(body, &mass);
    dBodySetPosition(body, position[0], position[1], position[2]);
    dGeomSetBody(geom, body);
    s->geoms[s->geom_count++] = geom;
    return s->body_count++;
}

static void add_joint(scene *s, pinch_random *random, int first, int second)
{
    dBodyID a = s->bodies[first], b = s->bodies[second];
    const double *x = dBodyGetPosition(a);
    dJointID joint;
    if (draw_chance(random, 0.5)) {
        joint = dJointCreateHinge(s->world, NULL);
        dJointAttach(joint, a, b);
        dJointSetHingeAnchor(joint, x[0], x[1], x[2] + 0.06);
        dJointSetHingeAxis(joint, 0, 1, 0);
        dJointSetHingeParam(joint, dParamLoStop, -0.6);
        dJointSetHingeParam(joint, dParamHiStop, 0.9);
        pinch_servo servo = pinch_default_servo();
        servo.kp = 0.5, servo.kd = 0.01, servo.target = 0.3, servo.max_force = 0.2;
        if (s->servos) assert_int_equal(pinch_ode_set_servo(s->plugin, joint, 0, &servo), PINCH_OK);
    } else {
        joint = dJointCreateSlider(s->world, NULL);
        dJointAttach(joint, a, b);
        dJointSetSliderAxis(joint, 0, 0, 1);
        dJointSetSliderParam(joint, dParamVel, 0.1);
        dJointSetSliderParam(joint, dParamFMax, draw_uniform(random, 0, 2));
    }
    assert_int_equal(pinch_ode_note_joint(s->plugin, joint), PINCH_OK);
    s->joints[s->joint_count++] = joint;
}

/* Three tips hold a box, one of them by force; all are carried by a kinematic hand. */
static void add_grip(scene *s, pinch_random *random)
{
    static const double SIDE = 0.06, TIP = 0.01;
    double reach = 0.5 * SIDE + TIP - 4e-4;
    pinch_material material = pinch_default_material();
    material.model = PINCH_CONTACT_SOFT;
    material.friction = material.friction_kinetic = draw_uniform(random, 0.3, 1);
    dMass mass;
    dMassSetBoxTotal(&mass, 0.1, SIDE, SIDE, SIDE);
    dBodyID box = s->bodies[s->body_count++] = dBodyCreate(s->world);
    dBodySetMass(box, &mass);
    dBodySetPosition(box, 2, 0, 0.5);
    dGeomID geom = s->geoms[s->geom_count++] = dCreateBox(s->space, SIDE, SIDE, SIDE);
    dGeomSetBody(geom, box);
    s->hand = s->body_count;
    for (int k = 0; k < 3; k++) {
        dBodyID base = s->bodies[s->body_count++] = dBodyCreate(s->world);
        dBodySetKinematic(base);
        dBodySetPosition(base, k < 2 ? 2 - reach : 2 + reach, k == 0 ? 0.01 : k == 1 ? -0.01 : 0, 0.5);
        dGeomID tip = s->geoms[s->geom_count++] = dCreateSphere(s->space, TIP);
        dGeomSetBody(tip, base);
        assert_int_equal(pinch_ode_set_material(s->plugin, tip, &material), PINCH_OK);
        if (k == 2 && s->driven) {
            const double axis[3] = {-1, 0, 0};
            assert_int_equal(pinch_ode_set_drive(s->plugin, base, axis, 6), PINCH_OK);
        }
    }
}

static scene make(int seed)
{
    pinch_random random;
    scene s = {.hand = -1};
    pinch_random_seed(&random, (uint64_t)seed + 1);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = seed % 2 ? PINCH_ODE_QUICKSTEP : PINCH_ODE_WORLDSTEP;
    settings.threads = 1 + seed % 3 / 2;
    if (seed % 7 == 6) settings.faces = 8;
    s.world = dWorldCreate();
    s.space = seed % 4 == 3 ? dHashSpaceCreate(NULL) : dSimpleSpaceCreate(NULL);
    s.servos = seed % 3 != 1;
    s.handed = seed % 4 == 1; /* islands of joints alone are solved, too */
    s.driven = seed % 3 == 0; /* then ODE solves the contacts without a material */
    dWorldSetGravity(s.world, 0, 0, -9.81);
    assert_int_equal(pinch_ode_create(s.world, &settings, &s.plugin), PINCH_OK);
    s.geoms[s.geom_count++] = dCreatePlane(s.space, 0, 0, 1, 0);
    dGeomID block = s.geoms[s.geom_count++] = dCreateBox(s.space, 0.2, 0.2, 0.2);
    dGeomSetPosition(block, 0.1, 0, 0);
    int count = 4 + draw_index(&random, 12);
    for (int i = 0; i < count; i++) {
        double x[3] = {draw_uniform(&random, -0.2, 0.2), draw_uniform(&random, -0.2, 0.2), 0.15 + 0.07 * i};
        int body = add_body(&s, &random, x);
        if (i > 0 && draw_chance(&random, 0.4)) add_joint(&s, &random, body, body - 1);
    }
    if (seed % 5 != 4) add_grip(&s, &random);
    return s;
}

static void destroy(scene *s)
{
    pinch_ode_destroy(s->plugin);
    for (int i = 0; i < s->geom_count; i++) dGeomDestroy(s->geoms[i]);
    dSpaceDestroy(s->space);
    dWorldDestroy(s->world);
}

/* The hand and a geom without a body move as functions of time. */
static void steer(scene *s)
{
    double time = (double)s->step * STEP;
    dGeomSetPosition(s->geoms[1], 0.1, 0.05 * sin(3 * time), 0.1 * sin(6 * time)); /* faster than overlaps part */
    for (int k = 0; k < 3 && s->hand >= 0; k++)
        dBodySetLinearVel(s->bodies[s->hand + k], 0, 0, s->step < 200 ? 0 : 0.1 * sin(20 * (time - 200 * STEP)));
}

static void run_to(scene *s, long end)
{
    for (; s->step < end; s->step++) {
        steer(s);
        dSpaceCollide(s->space, s, offer);
        for (int i = 0; i < s->body_count && s->handed; i++)
            assert_int_equal(pinch_ode_add_body(s->plugin, s->bodies[i]), PINCH_OK);
        assert_int_equal(pinch_ode_step(s->plugin, STEP), PINCH_OK);
    }
}

static uint64_t mix(uint64_t hash, const void *data, size_t size)
{
    for (size_t i = 0; i < size; i++) hash = (hash ^ ((const unsigned char *)data)[i]) * 0x100000001b3u;
    return hash;
}

/* Returns a hash of all bodies' states, and of the forces of the last step. */
static uint64_t hash_of(const scene *s)
{
    const pinch_ode_contact *contacts;
    int count;
    uint64_t hash = 0xcbf29ce484222325u;
    for (int i = 0; i < s->body_count; i++) {
        dBodyID b = s->bodies[i];
        hash = mix(hash, dBodyGetPosition(b), 3 * sizeof(double));
        hash = mix(hash, dBodyGetQuaternion(b), 4 * sizeof(double));
        hash = mix(hash, dBodyGetLinearVel(b), 3 * sizeof(double));
        hash = mix(hash, dBodyGetAngularVel(b), 3 * sizeof(double));
    }
    assert_int_equal(pinch_ode_contacts(s->plugin, &contacts, &count), PINCH_OK);
    for (int k = 0; k < count; k++) {
        hash = mix(hash, contacts[k].position, sizeof contacts[k].position);
        hash = mix(hash, contacts[k].force, sizeof contacts[k].force);
        hash = mix(hash, contacts[k].elastic, sizeof contacts[k].elastic);
    }
    pinch_ode_stats stats = pinch_ode_statistics(s->plugin);
    hash = mix(hash, &stats.steps, sizeof stats.steps);
    hash = mix(hash, &stats.contacts_solved, sizeof stats.contacts_solved);
    hash = mix(hash, &stats.islands_at_rest, sizeof stats.islands_at_rest);
    return mix(hash, &stats.iterations, sizeof stats.iterations);
}

typedef struct snapshot {
    unsigned char *data;
    size_t size;
    long step;
} snapshot;

static snapshot save(scene *s)
{
    pinch_ode_parts parts = parts_of(s);
    snapshot kept = {.step = s->step};
    assert_int_equal(pinch_ode_save(s->plugin, &parts, NULL, &kept.size), PINCH_OK);
    kept.data = malloc(kept.size);
    assert_non_null(kept.data);
    assert_int_equal(pinch_ode_save(s->plugin, &parts, kept.data, &kept.size), PINCH_OK);
    return kept;
}

static void restore(scene *s, const snapshot *kept)
{
    pinch_ode_parts parts = parts_of(s);
    assert_int_equal(pinch_ode_restore(s->plugin, &parts, kept->data, kept->size), PINCH_OK);
    s->step = kept->step;
}

/* ---- to the same bits ---- */

/* What another process comes to, which makes the world of this seed, reads the snapshot and goes on for as long. */
static uint64_t hash_of_another_process(int seed, const snapshot *kept)
{
    char path[] = "/tmp/pinch-test-XXXXXX", command[4096];
    unsigned long long hash = 0;
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_true(write(fd, kept->data, kept->size) == (ssize_t)kept->size);
    close(fd);
    snprintf(command, sizeof command, "'%s' --resume %d '%s' %ld", self, seed, path, kept->step);
    FILE *other = popen(command, "r");
    assert_non_null(other);
    assert_int_equal(fscanf(other, "%llx", &hash), 1);
    assert_int_equal(pclose(other), 0);
    unlink(path);
    return hash;
}

/* The other process. */
static int resume(char *const *words)
{
    scene s = make(atoi(words[0]));
    FILE *file = fopen(words[1], "rb");
    snapshot kept = {.data = malloc(1 << 22), .step = atol(words[2])};
    if (!file || !kept.data) return 1;
    kept.size = fread(kept.data, 1, 1 << 22, file);
    fclose(file);
    restore(&s, &kept);
    run_to(&s, kept.step + BETWEEN);
    printf("%016llx\n", (unsigned long long)hash_of(&s));
    free(kept.data);
    destroy(&s);
    return 0;
}

static void check_world(int seed)
{
    scene first = make(seed), other = make(seed);
    run_to(&other, 37); /* whatever it did before does not matter */
    for (long at = BETWEEN; at < STEPS; at += BETWEEN) {
        run_to(&first, at);
        snapshot kept = save(&first);
        run_to(&first, at + BETWEEN);
        uint64_t wanted = hash_of(&first);

        scene fresh = make(seed);
        restore(&fresh, &kept);
        run_to(&fresh, at + BETWEEN);
        if (hash_of(&fresh) != wanted) fail_msg("seed %d: a fresh world goes another way from step %ld", seed, at);
        destroy(&fresh);

        restore(&other, &kept);
        run_to(&other, at + BETWEEN);
        if (hash_of(&other) != wanted) fail_msg("seed %d: a used world goes another way from step %ld", seed, at);

        restore(&first, &kept);
        run_to(&first, at + BETWEEN);
        if (hash_of(&first) != wanted) fail_msg("seed %d: the same world goes another way from step %ld", seed, at);

        if (hash_of_another_process(seed, &kept) != wanted)
            fail_msg("seed %d: another process goes another way from step %ld", seed, at);
        free(kept.data);
    }
    destroy(&first);
    destroy(&other);
}

static void test_restored_worlds_go_on_to_the_same_bits(void **state)
{
    (void)state;
    int count = draw_full() ? 100 : 10;
    for (int seed = 0; seed < count; seed++) check_world(seed);
}

static void test_saving_changes_nothing(void **state)
{
    (void)state;
    for (int seed = 0; seed < (draw_full() ? 100 : 10); seed++) {
        dRandSetSeed(0);
        scene saved = make(seed);
        for (long at = 25; at <= STEPS; at += 25) {
            run_to(&saved, at);
            free(save(&saved).data);
        }
        dRandSetSeed(0);
        scene plain = make(seed);
        run_to(&plain, STEPS);
        if (hash_of(&saved) != hash_of(&plain)) fail_msg("seed %d: saving has changed the world", seed);
        destroy(&saved);
        destroy(&plain);
    }
}

/* ---- what is refused ---- */

static void refuse(scene *s, const void *data, size_t size)
{
    pinch_ode_parts parts = parts_of(s);
    assert_int_equal(pinch_ode_restore(s->plugin, &parts, data, size), PINCH_INVALID_ARGUMENT);
}

static void test_damaged_snapshots_are_refused(void **state)
{
    (void)state;
    enum { FLIPS = 10000 };
    pinch_random random;
    pinch_random_seed(&random, 5);
    scene s = make(0), untouched = make(0);
    run_to(&s, BETWEEN);
    run_to(&untouched, BETWEEN);
    snapshot kept = save(&s);
    free(save(&untouched).data);
    for (int i = 0; i < FLIPS; i++) {
        size_t at = pinch_random_next(&random) % kept.size;
        unsigned char bit = (unsigned char)(1u << draw_index(&random, 8));
        kept.data[at] ^= bit;
        refuse(&s, kept.data, kept.size);
        kept.data[at] ^= bit;
    }
    for (size_t size = 0; size < kept.size; size += 1 + kept.size / 500) refuse(&s, kept.data, size);
    run_to(&s, STEPS);
    run_to(&untouched, STEPS);
    assert_true(hash_of(&s) == hash_of(&untouched));
    restore(&s, &kept);
    free(kept.data);
    destroy(&s);
    destroy(&untouched);
}

/* Numbers that no snapshot has are refused even where the checksum is right: it is made anew after each change. */
static uint64_t sum_of(const unsigned char *bytes, size_t size)
{
    uint64_t sum = 0x9e3779b97f4a7c15u + 1;
    for (size_t at = 0; at < size; at += 8) {
        uint64_t word = 0;
        memcpy(&word, bytes + at, size - at < 8 ? size - at : 8);
        sum = (sum ^ word) * 0xff51afd7ed558ccdu;
        sum ^= sum >> 32;
    }
    return sum;
}

static void test_forged_snapshots_do_no_harm(void **state)
{
    (void)state;
    int count = draw_full() ? 20000 : 400, refused = 0;
    pinch_random random;
    pinch_random_seed(&random, 6);
    scene s = make(6);
    run_to(&s, BETWEEN);
    snapshot kept = save(&s);
    unsigned char *forged = malloc(kept.size);
    pinch_ode_parts parts = parts_of(&s);
    for (int i = 0; i < count; i++) {
        memcpy(forged, kept.data, kept.size);
        size_t at = pinch_random_next(&random) % (kept.size - 16);
        int32_t value =
            draw_chance(&random, 0.5) ? draw_index(&random, 200) - 100 : (int32_t)pinch_random_next(&random);
        memcpy(forged + at, &value, sizeof value);
        uint64_t sum = sum_of(forged, kept.size - 8);
        memcpy(forged + kept.size - 8, &sum, 8);
        pinch_status status = pinch_ode_restore(s.plugin, &parts, forged, kept.size);
        assert_true(status == PINCH_OK || status == PINCH_INVALID_ARGUMENT);
        refused += status != PINCH_OK;
    }
    assert_true(refused > count / 20);
    /* Steps that have not been made yet: a pair of such a step would keep its number of contacts through the next. */
    const int64_t last = BETWEEN - 1, next = BETWEEN;
    refused = 0;
    for (size_t at = 0; at + 16 < kept.size; at++) {
        if (memcmp(kept.data + at, &last, sizeof last) != 0) continue;
        memcpy(forged, kept.data, kept.size);
        memcpy(forged + at, &next, sizeof next);
        uint64_t sum = sum_of(forged, kept.size - 8);
        memcpy(forged + kept.size - 8, &sum, 8);
        refused += pinch_ode_restore(s.plugin, &parts, forged, kept.size) == PINCH_INVALID_ARGUMENT;
    }
    assert_true(refused > 0);
    restore(&s, &kept); /* and none of them is left */
    scene fresh = make(6);
    restore(&fresh, &kept);
    run_to(&s, STEPS);
    run_to(&fresh, STEPS);
    assert_true(hash_of(&s) == hash_of(&fresh));
    free(forged);
    free(kept.data);
    destroy(&s);
    destroy(&fresh);
}

/* Where memory runs out, save and restore say so, and everything is as before. */
static void test_memory_that_runs_out(void **state)
{
    (void)state;
    scene s = make(0), untouched = make(0);
    run_to(&s, BETWEEN);
    snapshot kept = save(&s);
    pinch_ode_parts parts = parts_of(&s);
    run_to(&s, BETWEEN + 20);
    run_to(&untouched, BETWEEN);
    free(save(&untouched).data);
    run_to(&untouched, BETWEEN + 20);
    pinch_status status = PINCH_OUT_OF_MEMORY;
    long k = 1;
    for (; status != PINCH_OK && k < 10000; k++) {
        size_t size = 0;
        allocations_until_failure = k;
        status = pinch_ode_save(s.plugin, &parts, NULL, &size);
        allocations_until_failure = 0;
        assert_true(status == PINCH_OK || status == PINCH_OUT_OF_MEMORY);
    }
    assert_true(k > 3 && status == PINCH_OK);
    run_to(&s, BETWEEN + 40);
    run_to(&untouched, BETWEEN + 40);
    assert_true(hash_of(&s) == hash_of(&untouched));
    status = PINCH_OUT_OF_MEMORY;
    for (k = 1; status != PINCH_OK && k < 10000; k++) {
        uint64_t before = hash_of(&s);
        allocations_until_failure = k;
        status = pinch_ode_restore(s.plugin, &parts, kept.data, kept.size);
        allocations_until_failure = 0;
        assert_true(status == PINCH_OK || (status == PINCH_OUT_OF_MEMORY && hash_of(&s) == before));
    }
    assert_true(k > 10 && status == PINCH_OK);
    s.step = kept.step;
    restore(&untouched, &kept);
    run_to(&s, STEPS);
    run_to(&untouched, STEPS);
    assert_true(hash_of(&s) == hash_of(&untouched));
    free(kept.data);
    destroy(&s);
    destroy(&untouched);
}

static void test_other_parts_are_refused(void **state)
{
    (void)state;
    scene s = make(0);
    run_to(&s, BETWEEN);
    snapshot kept = save(&s);
    pinch_ode_parts parts = parts_of(&s), fewer = parts;
    size_t size = kept.size;
    fewer.body_count--; /* the last one is a finger's */
    assert_int_equal(pinch_ode_save(s.plugin, &fewer, NULL, &size), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_restore(s.plugin, &fewer, kept.data, kept.size), PINCH_INVALID_ARGUMENT);
    fewer = parts;
    fewer.geom_count--;
    assert_int_equal(pinch_ode_save(s.plugin, &fewer, NULL, &size), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_restore(s.plugin, &fewer, kept.data, kept.size), PINCH_INVALID_ARGUMENT);
    dBodyID twice[MOST];
    memcpy(twice, s.bodies, sizeof twice);
    twice[1] = twice[0];
    fewer = parts;
    fewer.bodies = twice;
    assert_int_equal(pinch_ode_save(s.plugin, &fewer, NULL, &size), PINCH_INVALID_ARGUMENT);
    twice[1] = NULL;
    assert_int_equal(pinch_ode_restore(s.plugin, &fewer, kept.data, kept.size), PINCH_INVALID_ARGUMENT);
    size = kept.size - 1;
    assert_int_equal(pinch_ode_save(s.plugin, &parts, kept.data, &size), PINCH_INVALID_ARGUMENT);
    assert_int_equal(size, kept.size);
    restore(&s, &kept);
    free(kept.data);
    destroy(&s);
}

static void test_only_between_steps(void **state)
{
    (void)state;
    scene s = make(0);
    run_to(&s, BETWEEN);
    snapshot kept = save(&s);
    pinch_ode_parts parts = parts_of(&s);
    size_t size = kept.size;
    dSpaceCollide(s.space, &s, offer);
    assert_int_equal(pinch_ode_save(s.plugin, &parts, kept.data, &size), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_restore(s.plugin, &parts, kept.data, kept.size), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_solve(s.plugin, STEP), PINCH_OK);
    assert_int_equal(pinch_ode_save(s.plugin, &parts, kept.data, &size), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_restore(s.plugin, &parts, kept.data, kept.size), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_advance(s.plugin, STEP), PINCH_OK);
    restore(&s, &kept);
    assert_int_equal(pinch_ode_save(NULL, &parts, NULL, &size), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_save(s.plugin, NULL, NULL, &size), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_save(s.plugin, &parts, NULL, NULL), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_restore(s.plugin, &parts, NULL, 100), PINCH_INVALID_ARGUMENT);
    free(kept.data);
    destroy(&s);
}

static dReal flat(void *data, int x, int z)
{
    (void)data, (void)x, (void)z;
    return 0;
}

/* A heightfield may have no pose, and ODE ends a program that asks for it. */
static void test_heightfields_without_a_pose(void **state)
{
    (void)state;
    for (int placeable = 0; placeable < 2; placeable++) {
        scene s = {.hand = -1, .world = dWorldCreate(), .space = dSimpleSpaceCreate(NULL)};
        const pinch_ode_settings settings = pinch_ode_default_settings();
        dHeightfieldDataID field = dGeomHeightfieldDataCreate();
        dMass mass;
        dWorldSetGravity(s.world, 0, -9.81, 0);
        assert_int_equal(pinch_ode_create(s.world, &settings, &s.plugin), PINCH_OK);
        dGeomHeightfieldDataBuildCallback(field, NULL, flat, 10, 10, 11, 11, 1, 0, 0.5, 0);
        dGeomHeightfieldDataSetBounds(field, -1, 1);
        s.geoms[s.geom_count++] = dCreateHeightfield(s.space, field, placeable);
        s.geoms[s.geom_count++] = dCreateBox(s.space, 0.2, 0.2, 0.2);
        s.bodies[s.body_count++] = dBodyCreate(s.world);
        dMassSetSphereTotal(&mass, 1, 0.1);
        dBodySetMass(s.bodies[0], &mass);
        dGeomSetBody(s.geoms[s.geom_count++] = dCreateSphere(s.space, 0.1), s.bodies[0]);
        dBodySetPosition(s.bodies[0], 2, 0.12, 2);
        run_to(&s, 50);
        snapshot kept = save(&s);
        run_to(&s, STEPS);
        uint64_t hash = hash_of(&s);
        assert_close(dBodyGetPosition(s.bodies[0])[1], 0.1, 1e-5);
        restore(&s, &kept);
        run_to(&s, STEPS);
        assert_true(hash_of(&s) == hash);
        free(kept.data);
        destroy(&s);
        dGeomHeightfieldDataDestroy(field);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_restored_worlds_go_on_to_the_same_bits),
        cmocka_unit_test(test_saving_changes_nothing),
        cmocka_unit_test(test_damaged_snapshots_are_refused),
        cmocka_unit_test(test_forged_snapshots_do_no_harm),
        cmocka_unit_test(test_memory_that_runs_out),
        cmocka_unit_test(test_other_parts_are_refused),
        cmocka_unit_test(test_only_between_steps),
        cmocka_unit_test(test_heightfields_without_a_pose),
    };
    self = argv[0];
    dInitODE2(0);
    int failed =
        argc == 5 && strcmp(argv[1], "--resume") == 0 ? resume(argv + 2) : cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
