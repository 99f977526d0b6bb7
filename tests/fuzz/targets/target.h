#ifndef PINCH_FUZZ_TARGET_H
#define PINCH_FUZZ_TARGET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* What a fuzzer calls with each input, by the name that libFuzzer gives it. A finding ends the process: by a sanitizer,
 * or by target_found. Returns 0. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Prints what is wrong and aborts. */
_Noreturn void target_found(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* The path of a file with these bytes. It is the same file in each call, and lives in memory. */
const char *target_file(const uint8_t *data, size_t size);

/* The same in a folder of the file system, for formats that name other files by their place relative to their own. */
const char *target_file_in(const char *folder, const uint8_t *data, size_t size);

/* What a command says to standard error between these two is kept. It has to be one line where something is wrong, and
 * nothing otherwise. */
void target_listen(void);
void target_heard(bool wrong);

/* A message for people has to be one line. */
void target_check_message(const char *text);

/* Numbers out of bytes. What is past the end is 0. */
typedef struct target_bytes {
    const uint8_t *at;
    size_t left;
} target_bytes;

unsigned target_byte(target_bytes *b);
/* How many iterations a solver gets. Under libFuzzer that is 40, and 300 for one input in 16: what does not converge
 * costs as much as its budget allows, and most of what a fuzzer makes does not. Elsewhere it is 300. */
int target_iterations(target_bytes *b);
/* A number of ordinary size, or now and then one that is not: 0, huge, tiny, infinite, NaN. */
double target_number(target_bytes *b);

#endif
