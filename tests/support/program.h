#ifndef PINCH_TEST_PROGRAM_H
#define PINCH_TEST_PROGRAM_H

/* Runs a program and keeps what it said. */
typedef struct program_result {
    int status; /* exit status; 128 + signal when killed */
    char *out;  /* standard output, NUL-terminated */
    char *err;  /* standard error */
} program_result;

/* argv ends with NULL, and argv[0] is the path. The program runs in `folder`; NULL means here. Aborts when it cannot be
 * run. */
program_result program_run(const char *folder, char *const argv[]);
void program_free(program_result *result);

/* A fresh empty folder under $TMPDIR or /tmp; free the path after program_remove_folder. */
char *program_make_folder(void);
/* Removes the folder and the files in it. */
void program_remove_folder(char *folder);
/* Counts the entries of a folder without . and .. */
int program_count_entries(const char *folder);
/* Writes a file and returns its path, which the caller frees. */
char *program_write_file(const char *folder, const char *name, const char *text);
/* Reads a whole file into a NUL-terminated text, which the caller frees. */
char *program_read_file(const char *path);

/* The paths of all shipped scenes, in the order of their names; NULL ends them. */
const char *const *shipped_scenes(void);
/* The last part of a path. */
const char *file_name(const char *path);

#endif
