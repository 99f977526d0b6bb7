#define _POSIX_C_SOURCE 200809L

/*
 * Runs a fuzz target without a fuzzer: TARGET [--rounds N] [--seed S] FILE..., where each FILE is run as it is, and
 * then N damaged copies of the files. With libFuzzer its own main takes the place of this one.
 */
#include "target.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct input {
    uint8_t *data;
    size_t size;
} input;

static input current;

/* Keeps the input of a finding, to be run again. */
static void keep_finding(int number)
{
    int file = open("finding", O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (file >= 0 && write(file, current.data, current.size) == (ssize_t)current.size) close(file);
    signal(number, SIG_DFL);
    raise(number);
}

static void run(input in)
{
    current = in;
    LLVMFuzzerTestOneInput(in.data, in.size);
}

static input read_input(const char *path)
{
    FILE *stream = fopen(path, "rb");
    input in = {NULL, 0};
    if (!stream || fseek(stream, 0, SEEK_END) != 0) target_found("%s cannot be read", path);
    long size = ftell(stream);
    rewind(stream);
    in.data = malloc((size_t)size + 1);
    if (!in.data) target_found("no memory");
    in.size = fread(in.data, 1, (size_t)size, stream);
    fclose(stream);
    return in;
}

static uint32_t draw(uint64_t *state, uint32_t below)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return below ? (uint32_t)(((*state >> 32) * below) >> 32) : 0;
}

/* A copy of `in` in which some bytes are changed, dropped, repeated, or taken from `other`. */
static input damage(const input *in, const input *other, uint64_t *random)
{
    static const char *const pieces[] = {"{",     "}",   "[",      "]",  "\"",  ",",    ":",  "-1",        "0",
                                         "1e308", "NaN", "1e-320", "\n", "<",   "</a>", "/>", "\xff",      "\\u0000",
                                         "null",  "-",   "1e15",   "\t", "&x;", "<!--", "'",  "9999999999"};
    size_t size = in->size;
    uint8_t *data = malloc(size + other->size + 256);
    if (!data) target_found("no memory");
    memcpy(data, in->data, size);
    for (uint32_t k = 1 + draw(random, 4); k > 0; k--) {
        size_t at = draw(random, (uint32_t)size + 1), cut = draw(random, 16);
        if (cut > size - at) cut = size - at;
        const uint8_t *piece = (const uint8_t *)"";
        size_t grown = 0;
        if (draw(random, 4) == 0 && other->size > 0) {
            size_t from = draw(random, (uint32_t)other->size);
            piece = other->data + from;
            grown = draw(random, (uint32_t)(other->size - from < 48 ? other->size - from : 48));
        } else if (draw(random, 2)) {
            piece = (const uint8_t *)pieces[draw(random, sizeof pieces / sizeof *pieces)];
            grown = strlen((const char *)piece);
        } else if (size > at) {
            data[at] = (uint8_t)draw(random, 256);
            continue;
        }
        memmove(data + at + grown, data + at + cut, size - at - cut);
        memcpy(data + at, piece, grown);
        size = size + grown - cut;
    }
    return (input){data, size};
}

int main(int argc, char **argv)
{
    signal(SIGABRT, keep_finding);
    signal(SIGSEGV, keep_finding);
    long rounds = 0;
    uint64_t random = 1;
    int count = 0;
    input *inputs = calloc((size_t)argc + 1, sizeof *inputs);
    if (!inputs) return 1;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--rounds") == 0 && i + 1 < argc)
            rounds = strtol(argv[++i], NULL, 10);
        else if (strcmp(argv[i], "--seed") == 0 && i + 1 < argc)
            random = strtoull(argv[++i], NULL, 10);
        else
            inputs[count++] = read_input(argv[i]);
    }
    if (count == 0) {
        fprintf(stderr, "usage: %s [--rounds N] [--seed S] FILE...\n", argv[0]);
        return 2;
    }
    for (int i = 0; i < count; i++) run(inputs[i]);
    for (long k = 0; k < rounds; k++) {
        const input *in = &inputs[draw(&random, (uint32_t)count)], *other = &inputs[draw(&random, (uint32_t)count)];
        input damaged = damage(in, other, &random);
        run(damaged);
        free(damaged.data);
    }
    printf("%d files and %ld damaged ones: no finding\n", count, rounds);
    for (int i = 0; i < count; i++) free(inputs[i].data);
    free(inputs);
    return 0;
}
