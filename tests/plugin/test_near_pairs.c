/*
 * The pairs of geoms that pinch_ode_each_pair finds are all whose boxes overlap, whatever a program does to its geoms
 * between two calls, and their order does not depend on what has moved. dSpaceCollide finds the same, but for pairs
 * that ODE's hash space loses (plugin/contacts/README.md).
 */
#include "support/cmocka_all.h"
#include "support/sanitized.h"

#include <pinch/ode.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_GEOMS = 400, MOST_PAIRS = 100000, ROUNDS = SANITIZED ? 40 : 150 };

typedef struct found_pairs {
    dGeomID geom[MOST_PAIRS][2];
    int count;
} found_pairs;

typedef struct crowd {
    dWorldID world;
    dSpaceID space;
    pinch_ode *plugin;
    dGeomID geoms[MOST_GEOMS];
    double speed[MOST_GEOMS]; /* m a round, at most */
    int count;
    unsigned long seed;
} crowd;

static double uniform(crowd *c, double from, double to)
{
    c->seed = (c->seed * 6364136223846793005u + 1442695040888963407u) & 0xffffffffffffffffu;
    return from + (to - from) * (double)(c->seed >> 33) / 2147483648.0;
}

static bool chance(crowd *c, double of)
{
    return uniform(c, 0, 1) < of;
}

/* ---- an own class of geoms, which says that it is apart from all whose boxes begin above its middle ---- */

static int shy_class = -1;

static void shy_box(dGeomID geom, dReal aabb[6])
{
    const dReal *x = dGeomGetPosition(geom);
    for (int k = 0; k < 6; k++) aabb[k] = x[k / 2] + (k % 2 ? 0.3 : -0.3);
}

static int shy_test(dGeomID geom, dGeomID other, dReal box[6])
{
    (void)other;
    return box[4] <= dGeomGetPosition(geom)[2];
}

static dColliderFn *no_collider(int number)
{
    (void)number;
    return NULL;
}

static int make_class(void **state)
{
    (void)state;
    dInitODE2(0);
    dGeomClass class = {.collider = no_collider, .aabb = shy_box, .aabb_test = shy_test};
    shy_class = dCreateGeomClass(&class);
    return shy_class < 0;
}

static int close_ode(void **state)
{
    (void)state;
    dCloseODE();
    return 0;
}

/* ---- the crowd ---- */

static void place(crowd *c, dGeomID geom)
{
    dQuaternion q;
    if (dGeomGetClass(geom) == dPlaneClass) return;
    dGeomSetPosition(geom, uniform(c, -2, 2), uniform(c, -2, 2), uniform(c, -2, 2));
    dQFromAxisAndAngle(q, uniform(c, -1, 1), uniform(c, -1, 1), 1, uniform(c, 0, 6));
    dGeomSetQuaternion(geom, q);
}

static dGeomID make_geom(crowd *c, dSpaceID space)
{
    double size = exp(uniform(c, log(0.02), log(1.0)));
    switch ((int)uniform(c, 0, 8)) {
    case 0:
        return dCreateSphere(space, size);
    case 1:
        return dCreateCapsule(space, 0.2 * size, size);
    case 2:
        return dCreateRay(space, 3 * size);
    case 3:
        return dCreateBox(space, 20 * size, size, 0.01);
    case 4:
        return chance(c, 0.1) ? dCreatePlane(space, uniform(c, -1, 1), 0, 1, 0) : dCreateSphere(space, size);
    case 5: {
        dGeomID shy = dCreateGeom(shy_class);
        dSpaceAdd(space, shy);
        return shy;
    }
    default:
        return dCreateBox(space, size, 0.5 * size, size);
    }
}

static void add_geom(crowd *c)
{
    if (c->count == MOST_GEOMS) return;
    dSpaceID space = c->space;
    bool inner = chance(c, 0.03);
    if (inner) space = dHashSpaceCreate(c->space);
    dGeomID geom = make_geom(c, space);
    if (!inner && chance(c, 0.5) && dGeomGetClass(geom) != dPlaneClass) {
        dBodyID body = c->count > 0 && chance(c, 0.3) ? dGeomGetBody(c->geoms[c->count - 1]) : NULL;
        dGeomSetBody(geom, body ? body : dBodyCreate(c->world));
    }
    place(c, geom);
    for (int k = 0; k < 3 && inner; k++) place(c, dCreateSphere(space, 0.1));
    c->speed[c->count] = chance(c, 0.5) ? 0 : exp(uniform(c, log(1e-4), log(1.0)));
    c->geoms[c->count++] = inner ? (dGeomID)space : geom;
}

static void drop_geom(crowd *c)
{
    if (c->count == 0) return;
    int k = (int)uniform(c, 0, c->count);
    dGeomDestroy(c->geoms[k]);
    c->count--;
    for (; k < c->count; k++) c->geoms[k] = c->geoms[k + 1], c->speed[k] = c->speed[k + 1];
}

static void move(crowd *c, int k)
{
    dGeomID geom = c->geoms[k];
    if (c->speed[k] == 0) return;
    for (int i = 0; dGeomIsSpace(geom) && i < dSpaceGetNumGeoms((dSpaceID)geom); i++)
        place(c, dSpaceGetGeom((dSpaceID)geom, i));
    if (dGeomIsSpace(geom) || dGeomGetClass(geom) == dPlaneClass) return;
    const dReal *x = dGeomGetPosition(geom);
    double to[3];
    for (int i = 0; i < 3; i++) to[i] = x[i] + uniform(c, -0.3, 1) * c->speed[k];
    for (int i = 0; i < 3; i++) to[i] -= to[i] > 2 ? 4 : 0;
    dGeomSetPosition(geom, to[0], to[1], to[2]);
}

/* What else changes who collides with whom. */
static void meddle(crowd *c)
{
    if (c->count == 0) return;
    dGeomID geom = c->geoms[(int)uniform(c, 0, c->count)];
    switch ((int)uniform(c, 0, 6)) {
    case 0:
        dGeomIsEnabled(geom) ? dGeomDisable(geom) : dGeomEnable(geom);
        break;
    case 1:
        dGeomSetCategoryBits(geom, (unsigned long)uniform(c, 0, 8));
        break;
    case 2:
        dGeomSetCollideBits(geom, (unsigned long)uniform(c, 0, 8));
        break;
    case 3:
        if (dGeomGetClass(geom) == dSphereClass) dGeomSphereSetRadius(geom, uniform(c, 0.01, 1.5));
        break;
    case 4:
        if (!dGeomIsSpace(geom) && dGeomGetClass(geom) != dPlaneClass) dGeomSetBody(geom, NULL);
        break;
    default:
        dSpaceRemove(c->space, geom);
        dSpaceAdd(c->space, geom);
    }
}

static void note_pair(void *data, dGeomID a, dGeomID b)
{
    found_pairs *found = data;
    assert_true(found->count < MOST_PAIRS);
    found->geom[found->count][0] = a;
    found->geom[found->count++][1] = b;
}

static int by_address(const void *a, const void *b)
{
    const dGeomID *one = a, *other = b;
    for (int k = 0; k < 2; k++)
        if (one[k] != other[k]) return (uintptr_t)one[k] < (uintptr_t)other[k] ? -1 : 1;
    return 0;
}

static void sort(found_pairs *found)
{
    for (int k = 0; k < found->count; k++) {
        dGeomID *pair = found->geom[k], first = pair[0];
        if ((uintptr_t)first < (uintptr_t)pair[1]) continue;
        pair[0] = pair[1];
        pair[1] = first;
    }
    qsort(found->geom, (size_t)found->count, sizeof *found->geom, by_address);
}

static void start(crowd *c, dSpaceID space, unsigned long seed)
{
    memset(c, 0, sizeof *c);
    c->seed = seed;
    c->space = space;
    c->world = dWorldCreate();
    const pinch_ode_settings settings = pinch_ode_default_settings();
    assert_int_equal(pinch_ode_create(c->world, &settings, &c->plugin), PINCH_OK);
}

static void finish(crowd *c)
{
    pinch_ode_destroy(c->plugin);
    dSpaceDestroy(c->space);
    dWorldDestroy(c->world);
}

static bool boxes_overlap(dGeomID a, dGeomID b)
{
    dReal one[6], other[6];
    dGeomGetAABB(a, one);
    dGeomGetAABB(b, other);
    for (int k = 0; k < 6; k += 2)
        if (one[k] > other[k + 1] || other[k] > one[k + 1]) return false;
    return true;
}

/* A geom that is shy keeps away from other geoms, not from spaces. */
static bool keeps_away(dGeomID shy, dGeomID other)
{
    dReal box[6];
    dGeomGetAABB(other, box);
    return dGeomGetClass(shy) == shy_class && !dGeomIsSpace(other) && !shy_test(shy, other, box);
}

static void find_one_by_one(const crowd *c, found_pairs *found)
{
    for (int i = 0; i < c->count; i++) {
        for (int k = 0; k < i; k++) {
            dGeomID a = c->geoms[i], b = c->geoms[k];
            if (!dGeomIsEnabled(a) || !dGeomIsEnabled(b) || !boxes_overlap(a, b)) continue;
            if (dGeomGetBody(a) && dGeomGetBody(a) == dGeomGetBody(b)) continue;
            if (!(dGeomGetCategoryBits(a) & dGeomGetCollideBits(b)) &&
                !(dGeomGetCategoryBits(b) & dGeomGetCollideBits(a)))
                continue;
            if (!keeps_away(a, b) && !keeps_away(b, a)) note_pair(found, a, b);
        }
    }
}

/* Leaves out those that ODE asks the geom's class about, and Pinch does not. */
static void leave_out_spaces(found_pairs *found)
{
    int kept = 0;
    for (int k = 0; k < found->count; k++) {
        if (dGeomIsSpace(found->geom[k][0]) || dGeomIsSpace(found->geom[k][1])) continue;
        memmove(found->geom[kept++], found->geom[k], sizeof *found->geom);
    }
    found->count = kept;
}

static void check_same(const found_pairs *ours, const found_pairs *others)
{
    assert_int_equal(ours->count, others->count);
    assert_memory_equal(ours->geom, others->geom, (size_t)ours->count * sizeof *ours->geom);
}

static void check_crowd(dSpaceID space, unsigned long seed)
{
    static found_pairs ours, others;
    crowd c;
    long pairs = 0;
    bool is_quadtree = dSpaceGetClass(space) == dQuadTreeSpaceClass; /* it asks for each pair of spaces twice */
    start(&c, space, seed);
    for (int k = 0; k < MOST_GEOMS / 2; k++) add_geom(&c);
    for (int round = 0; round < ROUNDS; round++) {
        if (round % 5 == 4) chance(&c, 0.5) ? add_geom(&c) : drop_geom(&c);
        if (round % 3 == 2) meddle(&c);
        for (int k = 0; k < c.count; k++) move(&c, k);
        ours.count = others.count = 0;
        assert_int_equal(pinch_ode_each_pair(c.plugin, c.space, &ours, note_pair), PINCH_OK);
        sort(&ours);
        if (!is_quadtree) {
            find_one_by_one(&c, &others);
            sort(&others);
            check_same(&ours, &others);
        }
        pairs += ours.count;
        /* ODE puts what has moved to the front of its lists, as in programs that cast rays; not in all rounds. */
        if (round % 4 == 3) continue;
        others.count = 0;
        dSpaceCollide(c.space, &others, note_pair);
        leave_out_spaces(&ours);
        leave_out_spaces(&others);
        sort(&others);
        if (dSpaceGetClass(space) != dHashSpaceClass) check_same(&ours, &others);
    }
    assert_true(pairs > 100 * ROUNDS);
    finish(&c);
}

static void test_all_pairs_are_found(void **state)
{
    const dVector3 center = {0, 0, 0}, extents = {4, 4, 4};
    (void)state;
    for (unsigned long seed = 1; seed <= (SANITIZED ? 1 : 3); seed++) {
        check_crowd(dHashSpaceCreate(NULL), seed);
        check_crowd(dSimpleSpaceCreate(NULL), seed + 10);
        check_crowd(dSweepAndPruneSpaceCreate(NULL, dSAP_AXES_XYZ), seed + 20);
        check_crowd(dQuadTreeSpaceCreate(NULL, center, extents, 3), seed + 30);
    }
}

/* Two cells of a metre, one above the other at the origin, are far from each other in the table of ODE's hash space. */
static void test_a_pair_that_hash_spaces_lose(void **state)
{
    (void)state;
    static found_pairs found;
    crowd c;
    start(&c, dHashSpaceCreate(NULL), 1);
    dGeomSetPosition(dCreateSphere(c.space, 0.45), 0.5, 0.5, 0.5);
    dGeomSetPosition(dCreateBox(c.space, 0.2, 0.2, 0.2), 0.5, 0.5, 0.05);
    found.count = 0;
    assert_int_equal(pinch_ode_each_pair(c.plugin, c.space, &found, note_pair), PINCH_OK);
    assert_int_equal(found.count, 1);
    finish(&c);
}

/* ---- order ---- */

typedef struct ordered {
    dGeomID geoms[MOST_GEOMS];
    int count, last[2], pairs;
} ordered;

static int number_of(const ordered *o, dGeomID geom)
{
    for (int k = 0; k < o->count; k++)
        if (o->geoms[k] == geom) return k;
    return -1;
}

static void check_order(void *data, dGeomID a, dGeomID b)
{
    ordered *o = data;
    int one = number_of(o, a), other = number_of(o, b);
    assert_true(one >= 0 && one < other);
    assert_true(one > o->last[0] || (one == o->last[0] && other > o->last[1]));
    o->last[0] = one;
    o->last[1] = other;
    o->pairs++;
}

static void test_the_oldest_comes_first(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        crowd c;
        start(&c, kind ? dHashSpaceCreate(NULL) : dSimpleSpaceCreate(NULL), 7);
        static ordered o;
        o.count = 0;
        for (int k = 0; k < MOST_GEOMS; k++) {
            o.geoms[o.count++] = c.geoms[c.count++] = dCreateSphere(c.space, 0.2);
            c.speed[k] = k % 2 ? 0.01 : 0;
            place(&c, c.geoms[k]);
        }
        for (int round = 0; round < 50; round++) {
            for (int k = 0; k < c.count; k++) move(&c, k);
            if (round % 10 == 9) { /* the newest goes, and comes back */
                dSpaceRemove(c.space, o.geoms[o.count - 1]);
                dSpaceAdd(c.space, o.geoms[o.count - 1]);
            }
            if (round % 3 == 0) dSpaceClean(c.space);
            o.last[0] = o.last[1] = -1;
            o.pairs = 0;
            assert_int_equal(pinch_ode_each_pair(c.plugin, c.space, &o, check_order), PINCH_OK);
            assert_true(o.pairs > MOST_GEOMS / 2);
        }
        finish(&c);
    }
}

/* ---- snapshots ---- */

typedef struct sequence {
    const dGeomID *geoms;
    int count;
    uint64_t hash; /* of the numbers of the geoms of each pair, in their order */
} sequence;

static uint64_t number_in(const sequence *q, dGeomID geom)
{
    for (int k = 0; k < q->count; k++)
        if (q->geoms[k] == geom) return (uint64_t)k;
    return (uint64_t)q->count; /* an inner space */
}

static void add_to_sequence(void *data, dGeomID a, dGeomID b)
{
    sequence *q = data;
    q->hash = (q->hash ^ number_in(q, a)) * 1099511628211u;
    q->hash = (q->hash ^ number_in(q, b)) * 1099511628211u;
}

/* Some geoms come and go, and some are in an inner space. */
static void fill(crowd *c)
{
    enum { GEOMS = 120, INSIDE = 10 };
    dSpaceID inner = NULL;
    for (int k = 0; k < GEOMS; k++) {
        if (k == GEOMS / 2) inner = dSimpleSpaceCreate(c->space);
        c->geoms[c->count] = dCreateSphere(inner && k < GEOMS / 2 + INSIDE ? inner : c->space, 0.3);
        c->speed[c->count] = k % 2 ? 0.05 : 0;
        place(c, c->geoms[c->count++]);
    }
}

static uint64_t look(crowd *c)
{
    sequence q = {c->geoms, c->count, 14695981039346656037u};
    for (int k = 0; k < c->count; k++) move(c, k);
    assert_int_equal(pinch_ode_each_pair(c->plugin, c->space, &q, add_to_sequence), PINCH_OK);
    return q.hash;
}

static pinch_ode_parts parts_of(const crowd *c)
{
    return (pinch_ode_parts){.geoms = c->geoms, .geom_count = c->count};
}

/* Saving has ODE's spaces put what has moved first. The order of pairs goes on as it was, where the snapshot was taken
 * and where it is restored. */
static void test_snapshots_keep_the_order(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        crowd a, b, untouched;
        crowd *const all[] = {&a, &b, &untouched};
        for (int i = 0; i < 3; i++) {
            start(all[i], kind ? dHashSpaceCreate(NULL) : dSimpleSpaceCreate(NULL), 11);
            fill(all[i]);
        }
        void *bytes = NULL;
        for (int round = 0; round < 20; round++) {
            assert_true(look(&a) == look(&untouched));
            if (round % 6 != 5) continue;
            pinch_ode_parts parts = parts_of(&a);
            size_t size = 0;
            free(bytes);
            assert_int_equal(pinch_ode_save(a.plugin, &parts, NULL, &size), PINCH_OK);
            bytes = malloc(size);
            assert_int_equal(pinch_ode_save(a.plugin, &parts, bytes, &size), PINCH_OK);
            parts = parts_of(&b);
            assert_int_equal(pinch_ode_restore(b.plugin, &parts, bytes, size), PINCH_OK);
            b.seed = a.seed;
        }
        b.seed = untouched.seed = a.seed;
        size_t size = 0;
        pinch_ode_parts of_a = parts_of(&a), of_b = parts_of(&b);
        free(bytes);
        assert_int_equal(pinch_ode_save(a.plugin, &of_a, NULL, &size), PINCH_OK);
        bytes = malloc(size);
        assert_int_equal(pinch_ode_save(a.plugin, &of_a, bytes, &size), PINCH_OK);
        assert_int_equal(pinch_ode_restore(b.plugin, &of_b, bytes, size), PINCH_OK);
        /* what was restored is saved and restored once more */
        assert_int_equal(pinch_ode_save(b.plugin, &of_b, bytes, &size), PINCH_OK);
        assert_int_equal(pinch_ode_restore(b.plugin, &of_b, bytes, size), PINCH_OK);
        for (int round = 0; round < 20; round++) {
            uint64_t hash = look(&a);
            assert_true(look(&b) == hash && look(&untouched) == hash);
        }
        free(bytes);
        for (int i = 0; i < 3; i++) finish(all[i]);
    }
}

/* ---- what was far away once ---- */

/* A geom that was put elsewhere for a step has no reach through all the others. */
static void test_a_jump_does_not_last(void **state)
{
    (void)state;
    enum { FAR = 50 };
    crowd c;
    start(&c, dHashSpaceCreate(NULL), 1);
    for (int k = 0; k < MOST_GEOMS; k++) {
        c.geoms[c.count++] = dCreateSphere(c.space, 0.1);
        dGeomSetPosition(c.geoms[k], k, 0, 0);
    }
    static found_pairs found;
    assert_int_equal(pinch_ode_each_pair(c.plugin, c.space, &found, note_pair), PINCH_OK);
    size_t before = pinch_ode_statistics(c.plugin).memory;
    for (int round = 0; round < 4; round++) { /* all, there and back */
        for (int k = 0; k < MOST_GEOMS; k++) dGeomSetPosition(c.geoms[k], k + (round % 2 ? 0 : FAR), 0, 0);
        assert_int_equal(pinch_ode_each_pair(c.plugin, c.space, &found, note_pair), PINCH_OK);
    }
    assert_int_equal(found.count, 0);
    assert_true(pinch_ode_statistics(c.plugin).memory < before + 100 * MOST_GEOMS);
    finish(&c);
}

/* ---- calls ---- */

static void disable_both(void *data, dGeomID a, dGeomID b)
{
    crowd *c = data;
    dGeomDisable(a);
    dGeomDisable(b);
    c->count++;
}

static void test_near_may_disable_geoms(void **state)
{
    (void)state;
    crowd c;
    start(&c, dHashSpaceCreate(NULL), 3);
    for (int k = 0; k < 5; k++) dCreateSphere(c.space, 1);
    assert_int_equal(pinch_ode_each_pair(c.plugin, c.space, &c, disable_both), PINCH_OK);
    assert_int_equal(c.count, 2);
    finish(&c);
}

static void collide_again(void *data, dGeomID a, dGeomID b)
{
    crowd *c = data;
    (void)a, (void)b;
    assert_int_equal(pinch_ode_each_pair(c->plugin, c->space, c, collide_again), PINCH_INVALID_ARGUMENT);
    c->count++;
}

static void test_wrong_calls_are_refused(void **state)
{
    (void)state;
    crowd c;
    start(&c, dHashSpaceCreate(NULL), 3);
    assert_int_equal(pinch_ode_each_pair(NULL, c.space, &c, collide_again), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_each_pair(c.plugin, NULL, &c, collide_again), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_each_pair(c.plugin, c.space, &c, NULL), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_each_pair(c.plugin, c.space, &c, collide_again), PINCH_OK); /* it is empty */
    assert_int_equal(c.count, 0);
    for (int k = 0; k < 3; k++) dCreateSphere(c.space, 1);
    assert_int_equal(pinch_ode_each_pair(c.plugin, c.space, &c, collide_again), PINCH_OK);
    assert_int_equal(c.count, 3);
    assert_int_equal(pinch_ode_solve(c.plugin, 1e-3), PINCH_OK);
    assert_int_equal(pinch_ode_each_pair(c.plugin, c.space, &c, collide_again), PINCH_INVALID_ARGUMENT);
    finish(&c);
}

/* More spaces than are kept at once, of which some are destroyed. */
static void test_many_spaces(void **state)
{
    (void)state;
    enum { SPACES = 20 };
    crowd c;
    dSpaceID spaces[SPACES];
    start(&c, dHashSpaceCreate(NULL), 5);
    for (int round = 0; round < 5; round++) {
        for (int k = 0; k < SPACES; k++) {
            if (round == 0 || k % 3 == 0) {
                if (round > 0) dSpaceDestroy(spaces[k]);
                spaces[k] = dSimpleSpaceCreate(NULL);
                for (int i = 0; i < k; i++) dCreateSphere(spaces[k], 1);
            }
            static found_pairs found;
            found.count = 0;
            assert_int_equal(pinch_ode_each_pair(c.plugin, spaces[k], &found, note_pair), PINCH_OK);
            assert_int_equal(found.count, k * (k - 1) / 2);
        }
    }
    for (int k = 0; k < SPACES; k++) dSpaceDestroy(spaces[k]);
    finish(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_pairs_are_found),     cmocka_unit_test(test_a_pair_that_hash_spaces_lose),
        cmocka_unit_test(test_the_oldest_comes_first),  cmocka_unit_test(test_snapshots_keep_the_order),
        cmocka_unit_test(test_a_jump_does_not_last),    cmocka_unit_test(test_near_may_disable_geoms),
        cmocka_unit_test(test_wrong_calls_are_refused), cmocka_unit_test(test_many_spaces),
    };
    return cmocka_run_group_tests(tests, make_class, close_ode);
}
