/*
 * The library that `pinch exec` loads before a program's others is damaged in many ways. The program must never run
 * without it.
 */

#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"

#include <elf.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char LIBRARY[] = "libpinch_preload.so";

/* A folder with the command, and with whatever is put there as its library. */
typedef struct place {
    char *folder;
    char command[1024], library[1024];
} place;

typedef struct bytes {
    unsigned char *data;
    size_t size;
} bytes;

static bytes read_bytes(const char *path)
{
    struct stat status;
    assert_int_equal(stat(path, &status), 0);
    bytes b = {malloc((size_t)status.st_size), (size_t)status.st_size};
    FILE *file = fopen(path, "rb");
    assert_true(b.data && file);
    assert_int_equal(fread(b.data, 1, b.size, file), b.size);
    fclose(file);
    return b;
}

static void write_bytes(const char *path, const unsigned char *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(chmod(path, 0755), 0);
}

static place make_place(void)
{
    place p = {.folder = program_make_folder()};
    snprintf(p.command, sizeof p.command, "%s/pinch", p.folder);
    snprintf(p.library, sizeof p.library, "%s/%s", p.folder, LIBRARY);
    bytes command = read_bytes(PINCH_EXECUTABLE);
    write_bytes(p.command, command.data, command.size);
    free(command.data);
    return p;
}

static bytes good_library(void)
{
    char path[1024];
    snprintf(path, sizeof path, "%s", PINCH_EXECUTABLE);
    char *end = strrchr(path, '/');
    assert_non_null(end);
    snprintf(end, sizeof path - (size_t)(end - path), "/%s", LIBRARY);
    return read_bytes(path);
}

static program_result run(place *p)
{
    return program_run(
        NULL, (char *[]){p->command, "exec", "--stats", "-", "--", exec_program("stack"), "--steps", "3", NULL});
}

/* One message that names the library, exit status 3, and the program not run. */
static void expect_refused(place *p, const char *what)
{
    program_result r = run(p);
    const char *first = strchr(r.err, '\n');
    bool one = first && first[1] == '\0';
    if (r.status != 3 || !strstr(r.err, LIBRARY) || !one || *r.out)
        fail_msg("%s: status %d\n%s%s", what, r.status, r.out, r.err);
    program_free(&r);
}

/* Where the last bytes that a loader maps end. */
static size_t mapped_end(const bytes *b)
{
    Elf64_Ehdr head;
    size_t end = 0;
    memcpy(&head, b->data, sizeof head);
    for (int i = 0; i < head.e_phnum; i++) {
        Elf64_Phdr part;
        memcpy(&part, b->data + head.e_phoff + (size_t)i * sizeof part, sizeof part);
        if (part.p_type == PT_LOAD && part.p_offset + part.p_filesz > end) end = part.p_offset + part.p_filesz;
    }
    assert_true(end > 0 && end <= b->size);
    return end;
}

/* The copy works, so that it is the damage that is refused. */
static void a_copy_elsewhere_works(void **state)
{
    (void)state;
    place p = make_place();
    bytes b = good_library();
    write_bytes(p.library, b.data, b.size);
    program_result r = run(&p);
    assert_int_equal(r.status, 0);
    assert_non_null(strstr(r.err, "\"steps\": 3,"));
    program_free(&r);
    free(b.data);
    program_remove_folder(p.folder);
}

static void a_library_that_is_cut_off_is_refused(void **state)
{
    (void)state;
    place p = make_place();
    bytes b = good_library();
    expect_refused(&p, "none");
    size_t end = mapped_end(&b);
    const size_t sizes[] = {0, 10, sizeof(Elf64_Ehdr), 4096, b.size / 4, b.size / 2, end - 1};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        char what[64];
        if (sizes[i] >= end) continue; /* the rest is for debuggers */
        snprintf(what, sizeof what, "%zu of %zu bytes", sizes[i], b.size);
        write_bytes(p.library, b.data, sizes[i]);
        expect_refused(&p, what);
    }
    free(b.data);
    program_remove_folder(p.folder);
}

/* What a loader needs first, overwritten: it ends in whatever way. */
static void a_library_with_holes_is_refused(void **state)
{
    (void)state;
    place p = make_place();
    bytes b = good_library();
    Elf64_Ehdr head;
    memcpy(&head, b.data, sizeof head);
    for (int i = 0; i < head.e_phnum; i++) {
        Elf64_Phdr part;
        memcpy(&part, b.data + head.e_phoff + (size_t)i * sizeof part, sizeof part);
        bool code = part.p_type == PT_LOAD && (part.p_flags & PF_X);
        if (part.p_type != PT_DYNAMIC && !code) continue;
        bytes hurt = good_library();
        memset(hurt.data + part.p_offset, 0, part.p_filesz);
        write_bytes(p.library, hurt.data, hurt.size);
        expect_refused(&p, code ? "no code" : "no dynamic section");
        free(hurt.data);
    }
    free(b.data);
    program_remove_folder(p.folder);
}

/* A text, and a library that a loader takes but that stands behind nothing. */
static void another_file_of_that_name_is_refused(void **state)
{
    (void)state;
    place p = make_place();
    const char text[] = "This is a text of more bytes than the head of an executable has, and it is no library.\n";
    write_bytes(p.library, (const unsigned char *)text, sizeof text - 1);
    expect_refused(&p, "a text");
    bytes other = read_bytes(exec_program("module.so"));
    write_bytes(p.library, other.data, other.size);
    expect_refused(&p, "another library");
    free(other.data);
    program_remove_folder(p.folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_copy_elsewhere_works),
        cmocka_unit_test(a_library_that_is_cut_off_is_refused),
        cmocka_unit_test(a_library_with_holes_is_refused),
        cmocka_unit_test(another_file_of_that_name_is_refused),
    };
    return cmocka_run_group_tests_name("the library of pinch exec", tests, NULL, NULL);
}
