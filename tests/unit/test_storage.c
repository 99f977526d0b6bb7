/* Tests the arena of a solve, the plugin's item index, and what islands remember. */
#include "support/cmocka_all.h"

#include "islands/island_graph.h"
#include "support/arena.h"
#include "support/draw.h"
#include "util/list.h"

#include <limits.h>
#include <string.h>

static void test_arena_alignment_and_overlap(void **state)
{
    (void)state;
    pinch_arena arena;
    pinch_random random;
    pinch_random_seed(&random, 1);
    pinch_arena_init(&arena);
    for (int round = 0; round < 4; round++) {
        enum { BLOCKS = 200 };
        unsigned char *block[BLOCKS];
        size_t size[BLOCKS];
        pinch_arena_reset(&arena);
        for (int i = 0; i < BLOCKS; i++) {
            size[i] = (size_t)draw_index(&random, 4000);
            block[i] = pinch_arena_get(&arena, size[i]);
            assert_non_null(block[i]);
            assert_int_equal((uintptr_t)block[i] % 16, 0);
            memset(block[i], i, size[i]);
        }
        for (int i = 0; i < BLOCKS; i++) /* nobody wrote into another's block */
            for (size_t k = 0; k < size[i]; k++) assert_int_equal(block[i][k], (unsigned char)i);
        assert_false(arena.failed);
    }
    pinch_arena_free(&arena);
}

static void test_arena_settles(void **state)
{
    (void)state;
    pinch_arena arena;
    pinch_arena_init(&arena);
    for (int round = 0; round < 2; round++) { /* the first round spills, the second has room */
        pinch_arena_reset(&arena);
        for (int i = 0; i < 100; i++) assert_non_null(pinch_arena_get(&arena, 3000));
        assert_true(round == 0 ? arena.spill != NULL : arena.spill == NULL);
    }
    size_t settled = arena.size;
    unsigned char *base = arena.base;
    for (int round = 0; round < 10; round++) {
        pinch_arena_reset(&arena);
        for (int i = 0; i < 100; i++) assert_non_null(pinch_arena_get(&arena, 3000));
        assert_null(arena.spill);
    }
    assert_int_equal(arena.size, settled);
    assert_ptr_equal(arena.base, base);
    assert_true(pinch_arena_high_water(&arena) >= 100 * 3000);
    pinch_arena_free(&arena);
    assert_null(arena.base);
}

/* Growing, an arena asks the system a few times and not for every array. */
static void test_arena_spills_in_parts(void **state)
{
    (void)state;
    enum { ARRAYS = 20000 };
    pinch_arena arena;
    pinch_arena_init(&arena);
    pinch_arena_reset(&arena);
    unsigned char *last = NULL;
    for (int i = 0; i < ARRAYS; i++) {
        unsigned char *array = pinch_arena_get(&arena, 300);
        assert_non_null(array);
        memset(array, i, 300);
        if (last) assert_int_equal(last[299], (unsigned char)(i - 1));
        last = array;
    }
    int blocks = 0;
    for (const pinch_arena_block *block = arena.spill; block; block = block->next) blocks++;
    assert_in_range(blocks, 1, 40);
    assert_true(pinch_arena_high_water(&arena) >= ARRAYS * 300 && pinch_arena_high_water(&arena) < ARRAYS * 320);
    pinch_arena_free(&arena);
}

/* Scratch within the scratch: gone after a rewind, but for the array that stays; in the first round it has spilled. */
static void test_arena_rewinds(void **state)
{
    (void)state;
    enum { ARRAYS = 300, KEPT = 777 };
    pinch_arena arena;
    pinch_arena_init(&arena);
    for (int round = 0; round < 3; round++) {
        pinch_arena_reset(&arena);
        unsigned char *before = pinch_arena_get(&arena, 5000);
        memset(before, 1, 5000);
        pinch_arena_mark mark = pinch_arena_here(&arena);
        unsigned char *array = NULL;
        for (int i = 0; i < ARRAYS; i++) {
            array = pinch_arena_get(&arena, 1000);
            assert_non_null(array);
            memset(array, i, 1000);
        }
        size_t most = arena.used + arena.spilled;
        unsigned char *kept = pinch_arena_rewind_but(&arena, &mark, array, KEPT);
        assert_non_null(kept);
        for (int i = 0; i < KEPT; i++) assert_int_equal(kept[i], (unsigned char)(ARRAYS - 1));
        assert_in_range(arena.used + arena.spilled, 5000 + KEPT, 5000 + KEPT + 64);
        unsigned char *after = pinch_arena_get(&arena, 1000);
        memset(after, 3, 1000);
        for (int i = 0; i < KEPT; i++) assert_int_equal(kept[i], (unsigned char)(ARRAYS - 1));
        pinch_arena_rewind(&arena, &mark);
        for (int i = 0; i < 5000; i++) assert_int_equal(before[i], 1);
        assert_in_range(arena.used + arena.spilled, 5000, 5000 + 64);
        assert_true(pinch_arena_high_water(&arena) >= most);
        assert_true(round == 0 || !arena.spill);
    }
    pinch_arena_free(&arena);
}

/* What was needed once is given back, what is needed again and again is not. */
static void test_arena_is_trimmed(void **state)
{
    (void)state;
    pinch_arena arena;
    pinch_arena_init(&arena);
    pinch_arena_reset(&arena);
    assert_non_null(pinch_arena_get(&arena, 1000000));
    assert_true(pinch_arena_held(&arena) >= 1000000); /* spilled, and held all the same */
    pinch_arena_trim(&arena, 0);
    assert_true(pinch_arena_held(&arena) >= 1000000);
    for (int i = 0; i < 3; i++) {
        pinch_arena_reset(&arena);
        assert_non_null(pinch_arena_get(&arena, i == 1 ? 300000 : 1000));
    }
    pinch_arena_trim(&arena, 0);
    assert_in_range(pinch_arena_held(&arena), 300000, 330000);
    const unsigned char *base = arena.base;
    pinch_arena_reset(&arena);
    assert_non_null(pinch_arena_get(&arena, 280000));
    pinch_arena_trim(&arena, 0); /* too little to be worth it */
    pinch_arena_reset(&arena);
    assert_non_null(pinch_arena_get(&arena, 300000));
    assert_ptr_equal(arena.base, base);
    assert_null(arena.spill);
    pinch_arena_trim(&arena, 0);
    pinch_arena_trim(&arena, 100000);
    assert_int_equal(pinch_arena_held(&arena), 100000);
    assert_true(pinch_arena_high_water(&arena) >= 1000000);
    pinch_arena_free(&arena);
}

static void test_arena_out_of_memory(void **state)
{
    (void)state;
    pinch_arena arena;
    pinch_arena_init(&arena);
    pinch_arena_reset(&arena);
#if !defined(__SANITIZE_ADDRESS__) /* the sanitizer aborts instead of returning NULL */
    assert_null(pinch_arena_get(&arena, SIZE_MAX / 4));
    assert_true(arena.failed);
    pinch_arena_reset(&arena);
#endif
    assert_false(arena.failed);
    assert_non_null(pinch_arena_get(&arena, 16));
    pinch_arena_free(&arena);
}

/* Items that are found by what they have themselves, while their list moves and grows. */
static void test_item_index(void **state)
{
    (void)state;
    enum { ITEMS = 5000 };
    typedef struct item {
        double other;
        uint64_t key;
    } item;
    struct {
        item *items;
    } list = {NULL};
    pinch_item_index index = {0};
    pinch_random random;
    uint64_t none = 1;
    assert_int_equal(pinch_item_index_get(&index, PINCH_ITEM_KEYS(list, item, key), &none), -1); /* without storage */
    for (int round = 0; round < 2; round++) {
        pinch_random_seed(&random, 9);
        for (int i = 0; i < ITEMS; i++) { /* multiples of 16, and pairs of small numbers; 0 is a key like any other */
            uint64_t key = i % 2 ? 0x7f0000000000u + 16 * (uint64_t)i : ((uint64_t)i << 32 | (uint64_t)(i / 2));
            list.items = realloc(list.items, sizeof(item) * (size_t)(i + 1));
            assert_non_null(list.items);
            assert_int_equal(pinch_item_index_get(&index, PINCH_ITEM_KEYS(list, item, key), &key), -1);
            assert_true(pinch_item_index_add(&index, PINCH_ITEM_KEYS(list, item, key), &key, i));
            list.items[i] = (item){.key = key};
        }
        for (int i = 0; i < ITEMS; i++)
            assert_int_equal(pinch_item_index_get(&index, PINCH_ITEM_KEYS(list, item, key), &list.items[i].key), i);
        for (int i = 0; i < ITEMS; i++) { /* hints that are right, those beside, and numbers that are no places */
            int hints[] = {i, i + 1, i - 1, -1, ITEMS, INT_MIN, INT_MAX};
            for (size_t k = 0; k < sizeof hints / sizeof *hints; k++) {
                pinch_item_keys keys = PINCH_ITEM_KEYS(list, item, key);
                assert_int_equal(pinch_item_index_find(&index, keys, &list.items[i].key, &hints[k]), i);
                assert_int_equal(hints[k], i);
            }
        }
        for (int i = 0; i < 1000; i++) {
            none = pinch_random_next(&random) | 1u << 31;
            assert_int_equal(pinch_item_index_get(&index, PINCH_ITEM_KEYS(list, item, key), &none), -1);
        }
        assert_int_equal(index.used, ITEMS);
        assert_true(pinch_item_index_bytes(&index) < 10 * ITEMS);
        pinch_item_index_clear(&index);
        int hint = 1; /* of an item that is still in its place, and no longer in the index */
        assert_int_equal(pinch_item_index_get(&index, PINCH_ITEM_KEYS(list, item, key), &list.items[1].key), -1);
        assert_int_equal(pinch_item_index_find(&index, PINCH_ITEM_KEYS(list, item, key), &list.items[1].key, &hint),
                         -1);
    }
    pinch_item_index_free(&index);
    free(list.items);
}

/* Items that go one by one, each replaced by the last one; all that are left are still found. */
static void test_item_index_remove(void **state)
{
    (void)state;
    enum { ITEMS = 400, ROUNDS = 40 };
    uint64_t list[ITEMS];
    const pinch_item_keys keys = {list, sizeof *list, 0};
    pinch_item_index index = {0};
    pinch_random random;
    pinch_random_seed(&random, 10);
    for (int round = 0; round < ROUNDS; round++) {
        int count = 1 + draw_index(&random, ITEMS), left = round % 2 ? draw_index(&random, count) : 0;
        for (int i = 0; i < count; i++) { /* pointers, numbers in a row, or any */
            uint64_t any = pinch_random_next(&random);
            list[i] = round % 4 == 0 ? 0x7f0000000000u + 16 * (uint64_t)i : round % 4 == 1 ? (uint64_t)i : any;
            assert_true(pinch_item_index_add(&index, keys, &list[i], i));
        }
        while (count > left) {
            int place = draw_index(&random, count);
            uint64_t gone = list[place];
            pinch_item_index_remove(&index, keys, place, count - 1);
            list[place] = list[--count];
            assert_int_equal(index.used, count);
            assert_int_equal(pinch_item_index_get(&index, keys, &gone), -1);
            for (int i = 0; i < count; i++) assert_int_equal(pinch_item_index_get(&index, keys, &list[i]), i);
        }
        pinch_item_index_clear(&index);
    }
    pinch_item_index_free(&index);
}

/* Memories of islands that began with a body that is gone are empty, and the others are as they were. */
static void test_memories_are_forgotten(void **state)
{
    (void)state;
    enum { MEMORIES = 5 };
    const double lu[1] = {2};
    const int pivot[1] = {0};
    const unsigned char states[1] = {0};
    pinch_island_graph graph;
    pinch_key_map gone;
    memset(&graph, 0, sizeof graph);
    memset(&gone, 0, sizeof gone);
    assert_true(PINCH_RESERVE(graph.memories, MEMORIES));
    for (int k = 0; k < MEMORIES; k++) {
        const pinch_step_factors factors = {16 * (uint64_t)(k + 1), 1, 1, lu, pivot, states};
        assert_int_equal(pinch_step_memory_create(&graph.memories.items[k]), PINCH_OK);
        graph.memories.count++;
        assert_int_equal(pinch_step_memory_write(graph.memories.items[k], &factors), PINCH_OK);
    }
    assert_true(pinch_key_map_add(&gone, 32, 1) && pinch_key_map_add(&gone, 80, 1) && pinch_key_map_add(&gone, 96, 1));
    pinch_forget_memories(&graph, &gone);
    for (int k = 0; k < MEMORIES; k++)
        assert_int_equal(pinch_step_memory_read(graph.memories.items[k]).unknowns, k == 1 || k == 4 ? 0 : 1);
    pinch_key_map_free(&gone);
    pinch_island_graph_free(&graph);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_arena_alignment_and_overlap),
        cmocka_unit_test(test_arena_settles),
        cmocka_unit_test(test_arena_spills_in_parts),
        cmocka_unit_test(test_arena_rewinds),
        cmocka_unit_test(test_arena_is_trimmed),
        cmocka_unit_test(test_arena_out_of_memory),
        cmocka_unit_test(test_item_index),
        cmocka_unit_test(test_item_index_remove),
        cmocka_unit_test(test_memories_are_forgotten),
    };
    return cmocka_run_group_tests_name("arena and item index", tests, NULL, NULL);
}
