/* The results of a study in an SQLite database. */
#define _DEFAULT_SOURCE

#include "results.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <sqlite3.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { HAS = 0, ADD_TRIAL, ADD_DIRECTION, ADD_ERROR, ADD_REFINEMENT, STATEMENTS };
static const char *const statement_texts[STATEMENTS] = {
    [HAS] = "SELECT 1 FROM trials WHERE \"index\" = ?1",
    [ADD_TRIAL] = "INSERT INTO trials VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)",
    [ADD_DIRECTION] = "INSERT INTO directions VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)",
    [ADD_ERROR] = "INSERT INTO errors VALUES (?1, ?2, ?3, ?4)",
    [ADD_REFINEMENT] = "INSERT OR REPLACE INTO refinements VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
};

struct results {
    char *path;
    sqlite3 *database;
    sqlite3_stmt *statements[STATEMENTS];
    int lock; /* a descriptor that holds the file's lock; -1: none */
    bool open_transaction, writable;
};

static bool refuse(results_error *e, command_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static bool refuse(results_error *e, command_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(e->text, sizeof e->text, format, arguments);
    va_end(arguments);
    e->status = status;
    return false;
}

/* A file that is damaged or of another kind is bad input; all else is the system's failure. */
static bool fail(const results *r, results_error *e)
{
    int code = r->database ? sqlite3_errcode(r->database) : SQLITE_NOMEM;
    const char *what = r->database ? sqlite3_errmsg(r->database) : "out of memory";
    switch (code & 0xff) {
    case SQLITE_NOTADB:
        return refuse(e, COMMAND_BAD_INPUT,
                      "%s: expected the results of a study, got a file that is no database; it is left as it is",
                      r->path);
    case SQLITE_CORRUPT:
        return refuse(e, COMMAND_BAD_INPUT, "%s: the database is damaged (%s); it is left as it is", r->path, what);
    case SQLITE_FULL:
        return refuse(e, COMMAND_SYSTEM,
                      "%s: the disk is full; what was written before is kept, and --resume goes on with it", r->path);
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
        return refuse(e, COMMAND_SYSTEM, "%s: cannot be written: %s", r->path, what);
    default:
        return refuse(e, COMMAND_SYSTEM, "%s: %s; what was written before is kept", r->path, what);
    }
}

static bool run(results *r, const char *text, results_error *e)
{
    return sqlite3_exec(r->database, text, NULL, NULL, NULL) == SQLITE_OK || fail(r, e);
}

/* ---- Opening. ---- */

static bool begin_study(results *r, const study *s, const char *version, const char *hash, results_error *e)
{
    static const char *const tables =
        "CREATE TABLE study (document TEXT, scene TEXT, \"table\" TEXT, hash TEXT, name TEXT, version TEXT,"
        " trials INTEGER, contact_solver TEXT, step REAL, files TEXT);"
        "CREATE TABLE trials (\"index\" INTEGER PRIMARY KEY, inputs TEXT, status TEXT, success INTEGER, exit INTEGER,"
        " wall_time REAL, run_time REAL, hash TEXT, recorded TEXT);"
        "CREATE TABLE directions (trial INTEGER, direction TEXT, status TEXT, success INTEGER, exit INTEGER,"
        " displacement REAL, rotation REAL, wall_time REAL, hash TEXT, recorded TEXT, PRIMARY KEY (trial, direction))"
        " WITHOUT ROWID;"
        "CREATE TABLE errors (trial INTEGER, direction TEXT, status TEXT, message TEXT, PRIMARY KEY (trial, direction))"
        " WITHOUT ROWID;"
        "CREATE TABLE refinements (trial INTEGER, contact_solver TEXT, step REAL, halvings INTEGER, status TEXT,"
        " success INTEGER, exit INTEGER, displacement REAL, rotation REAL, wall_time REAL, hash TEXT,"
        " PRIMARY KEY (trial, contact_solver, step, halvings)) WITHOUT ROWID;";
    sqlite3_stmt *row = NULL;
    char files[24];
    snprintf(files, sizeof files, "%016" PRIx64, s->files);
    bool good = run(r, "BEGIN IMMEDIATE", e) && run(r, tables, e);
    if (good && sqlite3_prepare_v2(r->database, "INSERT INTO study VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)",
                                   -1, &row, NULL) != SQLITE_OK)
        good = fail(r, e);
    if (good) {
        sqlite3_bind_text(row, 1, s->text, (int)s->length, SQLITE_STATIC);
        sqlite3_bind_text(row, 2, s->scene_text, (int)s->scene_length, SQLITE_STATIC);
        sqlite3_bind_text(row, 3, s->table.text, -1, SQLITE_STATIC);
        sqlite3_bind_text(row, 4, hash, -1, SQLITE_STATIC);
        sqlite3_bind_text(row, 5, s->name, -1, SQLITE_STATIC);
        sqlite3_bind_text(row, 6, version, -1, SQLITE_STATIC);
        sqlite3_bind_int64(row, 7, s->samples);
        sqlite3_bind_text(row, 8, world_solver_name(s->contact_solver), -1, SQLITE_STATIC);
        sqlite3_bind_double(row, 9, s->step);
        sqlite3_bind_text(row, 10, files, -1, SQLITE_STATIC);
        good = sqlite3_step(row) == SQLITE_DONE || fail(r, e);
    }
    sqlite3_finalize(row);
    return good && run(r, "COMMIT", e);
}

/* What is in the file: 1 for the results of a study, 0 for nothing yet, -1 after a failure. */
static int look(results *r, char hash[64], results_error *e)
{
    sqlite3_stmt *query = NULL;
    int found = -1;
    hash[0] = '\0';
    if (sqlite3_prepare_v2(r->database, "SELECT count(*) FROM sqlite_schema", -1, &query, NULL) != SQLITE_OK ||
        sqlite3_step(query) != SQLITE_ROW) {
        (void)fail(r, e);
    } else {
        found = sqlite3_column_int(query, 0) > 0;
    }
    sqlite3_finalize(query);
    if (found != 1) return found;
    query = NULL;
    if (sqlite3_prepare_v2(r->database, "SELECT hash FROM study", -1, &query, NULL) != SQLITE_OK ||
        sqlite3_step(query) != SQLITE_ROW) {
        if ((sqlite3_errcode(r->database) & 0xff) == SQLITE_CORRUPT)
            (void)fail(r, e);
        else
            (void)refuse(e, COMMAND_BAD_INPUT, "%s: expected the results of a study, got another database", r->path);
        found = -1;
    } else {
        snprintf(hash, 64, "%s", (const char *)sqlite3_column_text(query, 0));
    }
    sqlite3_finalize(query);
    return found;
}

/* Looks through the whole file, so that a damaged one is not written to. */
static bool is_sound(results *r, results_error *e)
{
    sqlite3_stmt *check = NULL;
    bool good = sqlite3_prepare_v2(r->database, "PRAGMA quick_check(1)", -1, &check, NULL) == SQLITE_OK &&
                sqlite3_step(check) == SQLITE_ROW;
    if (!good) {
        (void)fail(r, e);
    } else if (strcmp((const char *)sqlite3_column_text(check, 0), "ok") != 0) {
        good = refuse(e, COMMAND_BAD_INPUT, "%s: the database is damaged (%.200s); it is left as it is", r->path,
                      (const char *)sqlite3_column_text(check, 0));
    }
    sqlite3_finalize(check);
    return good;
}

/* SQLite's own locks allow writers to take turns; a study has one writer at a time. */
static bool lock(results *r, results_error *e)
{
    r->lock = open(r->path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (r->lock < 0) return refuse(e, COMMAND_SYSTEM, "%s: cannot be written: %s", r->path, strerror(errno));
    if (flock(r->lock, LOCK_EX | LOCK_NB) == 0) return true;
    return refuse(e, COMMAND_SYSTEM, "%s: another process is writing these results", r->path);
}

static bool open_database(results *r, int flags, results_error *e)
{
    if (sqlite3_open_v2(r->path, &r->database, flags, NULL) != SQLITE_OK) return fail(r, e);
    sqlite3_busy_timeout(r->database, 10000); /* readers may look at the results meanwhile */
    return true;
}

static bool prepare_all(results *r, results_error *e)
{
    for (int i = 0; i < STATEMENTS; i++)
        if (sqlite3_prepare_v2(r->database, statement_texts[i], -1, &r->statements[i], NULL) != SQLITE_OK)
            return fail(r, e);
    return true;
}

static bool open_for(results *r, const study *s, const char *version, bool resume, results_error *e)
{
    struct stat about;
    char hash[64], own[64];
    bool exists = stat(r->path, &about) == 0;
    if (exists && !S_ISREG(about.st_mode))
        return refuse(e, COMMAND_BAD_INPUT, "--out: expected the name of a file, got %s", r->path);
    if (exists && !resume)
        return refuse(e, COMMAND_BAD_INPUT, "%s: exists; --resume goes on with it, or choose another name for --out",
                      r->path);
    snprintf(own, sizeof own, "%016" PRIx64, study_hash(s));
    if (!lock(r, e) || !open_database(r, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, e)) return false;
    int found = look(r, hash, e);
    if (found < 0) return false;
    if (found > 0 && strcmp(hash, own) != 0)
        return refuse(
            e, COMMAND_BAD_INPUT,
            "%s: its study, scene, table, hands, meshes, --contact-solver or --step are not those of %s any more; "
            "nothing was changed. Choose another name for --out",
            r->path, s->file);
    if (found > 0 && !is_sound(r, e)) return false;
    /* a commit survives the process with either; the write-ahead log needs no wait for the disk */
    if (!run(r, "PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL", e)) return false;
    if (found == 0 && !begin_study(r, s, version, own, e)) return false;
    return prepare_all(r, e);
}

static void release(results *r)
{
    for (int i = 0; i < STATEMENTS; i++) sqlite3_finalize(r->statements[i]);
    sqlite3_close(r->database);
    if (r->lock >= 0) close(r->lock); /* after SQLite: closing a file gives up the process's locks on it */
    free(r->path);
    free(r);
}

static results *allocate(const char *path, results_error *e)
{
    results *r = calloc(1, sizeof *r);
    *e = (results_error){.status = COMMAND_SYSTEM, .text = "out of memory"};
    if (!r) return NULL;
    r->lock = -1;
    r->path = strdup(path);
    if (r->path) return r;
    free(r);
    return NULL;
}

results *results_open(const char *path, const study *s, const char *version, bool resume, results_error *error)
{
    struct stat about;
    results *r = allocate(path, error);
    if (!r) return NULL;
    bool is_new = stat(path, &about) != 0;
    r->writable = true;
    if (open_for(r, s, version, resume, error)) return r;
    bool empty = is_new && stat(path, &about) == 0 && about.st_size == 0;
    release(r);
    if (empty) unlink(path); /* a file that was never begun is not left behind */
    return NULL;
}

results *results_read(const char *path, results_error *error)
{
    char hash[64];
    struct stat about;
    if (stat(path, &about) != 0) {
        refuse(error, COMMAND_BAD_INPUT, "%s: cannot be read: %s", path, strerror(errno));
        return NULL;
    }
    if (!S_ISREG(about.st_mode)) {
        refuse(error, COMMAND_BAD_INPUT, "%s: expected the results of a study, which are a regular file", path);
        return NULL;
    }
    results *r = allocate(path, error);
    if (!r) return NULL;
    if (open_database(r, SQLITE_OPEN_READONLY, error)) {
        int found = look(r, hash, error);
        if (found > 0) return r;
        if (found == 0)
            refuse(error, COMMAND_BAD_INPUT, "%s: expected the results of a study, got an empty file", path);
    }
    release(r);
    return NULL;
}

/* Returns 1 where the results are of the study, 0 where they are not, -1 after a failure. */
static int is_of_study(results *r, const study *s, results_error *e)
{
    static const char same[] =
        "SELECT 1 FROM study WHERE document = ?1 AND scene = ?2 AND \"table\" IS ?3 AND files = ?4";
    sqlite3_stmt *query = NULL;
    char files[24];
    /* results of an older version lack a column */
    if (sqlite3_prepare_v2(r->database, same, -1, &query, NULL) != SQLITE_OK) return 0;
    snprintf(files, sizeof files, "%016" PRIx64, s->files);
    sqlite3_bind_text(query, 1, s->text, (int)s->length, SQLITE_STATIC);
    sqlite3_bind_text(query, 2, s->scene_text, (int)s->scene_length, SQLITE_STATIC);
    sqlite3_bind_text(query, 3, s->table.text, -1, SQLITE_STATIC);
    sqlite3_bind_text(query, 4, files, -1, SQLITE_STATIC);
    int code = sqlite3_step(query);
    sqlite3_finalize(query);
    if (code == SQLITE_ROW || code == SQLITE_DONE) return code == SQLITE_ROW;
    (void)fail(r, e);
    return -1;
}

bool results_check_beside(const char *path, const study *s, results_error *error)
{
    results *other = results_read(path, error);
    if (!other) return false;
    int same = is_of_study(other, s, error);
    release(other);
    return same > 0 ||
           (same == 0 &&
            refuse(error, COMMAND_BAD_INPUT,
                   "%s: expected results of this version, and of the same study, scene, table, hands and meshes as "
                   "%s has",
                   path, s->file));
}

bool results_attach(results *r, const char *path, results_error *error)
{
    sqlite3_stmt *attach = NULL;
    bool good = sqlite3_prepare_v2(r->database, "ATTACH ?1 AS beside", -1, &attach, NULL) == SQLITE_OK &&
                sqlite3_bind_text(attach, 1, path, -1, SQLITE_STATIC) == SQLITE_OK &&
                sqlite3_step(attach) == SQLITE_DONE;
    sqlite3_finalize(attach);
    return good || fail(r, error);
}

bool results_close(results *r, results_error *error)
{
    if (!r) return true;
    bool good = results_commit(r, error);
    /* The log is taken over into the file where nobody reads it at the moment; otherwise a later reader does it. */
    if (r->writable) sqlite3_wal_checkpoint_v2(r->database, NULL, SQLITE_CHECKPOINT_TRUNCATE, NULL, NULL);
    release(r);
    return good;
}

/* ---- Trials. ---- */

/* Makes a step of the statement and resets it. Returns SQLite's code. */
static int step(sqlite3_stmt *statement)
{
    int code = sqlite3_step(statement);
    sqlite3_reset(statement);
    return code;
}

int results_has(results *r, long index, results_error *error)
{
    sqlite3_bind_int64(r->statements[HAS], 1, index);
    int code = step(r->statements[HAS]);
    if (code == SQLITE_ROW) return 1;
    if (code == SQLITE_DONE) return 0;
    fail(r, error);
    return -1;
}

/* Binds a member of the trial: a number, a text, or JSON as a text. */
static void bind(sqlite3_stmt *statement, int place, const json_t *of, const char *key)
{
    const json_t *value = json_object_get(of, key);
    if (json_is_integer(value))
        sqlite3_bind_int64(statement, place, json_integer_value(value));
    else if (json_is_real(value))
        sqlite3_bind_double(statement, place, json_real_value(value));
    else if (json_is_boolean(value))
        sqlite3_bind_int(statement, place, json_is_true(value));
    else if (json_is_string(value))
        sqlite3_bind_text(statement, place, json_string_value(value), -1, SQLITE_TRANSIENT);
    else if (json_is_object(value))
        sqlite3_bind_text(statement, place, json_dumps(value, JSON_COMPACT | JSON_REAL_PRECISION(17)), -1, free);
    else
        sqlite3_bind_null(statement, place);
}

static bool add_row(results *r, int number, const json_t *trial, const json_t *of, const char *const *keys, int count,
                    results_error *error)
{
    sqlite3_stmt *statement = r->statements[number];
    for (int i = 0; i < count; i++) bind(statement, i + 1, strcmp(keys[i], "index") == 0 ? trial : of, keys[i]);
    return step(statement) == SQLITE_DONE || fail(r, error);
}

static bool add_rows(results *r, int number, const json_t *trial, const char *list, const char *const *keys, int count,
                     results_error *error)
{
    const json_t *rows = json_object_get(trial, list);
    for (size_t i = 0; i < json_array_size(rows); i++)
        if (!add_row(r, number, trial, json_array_get(rows, i), keys, count, error)) return false;
    return true;
}

bool results_add(results *r, const json_t *trial, results_error *error)
{
    static const char *const trial_keys[] = {"index",     "inputs",   "status", "success", "exit",
                                             "wall_time", "run_time", "hash",   "recorded"};
    static const char *const direction_keys[] = {"index",        "direction", "status",    "success", "exit",
                                                 "displacement", "rotation",  "wall_time", "hash",    "recorded"};
    static const char *const error_keys[] = {"index", "direction", "status", "message"};
    if (!r->open_transaction && !run(r, "BEGIN IMMEDIATE", error)) return false;
    r->open_transaction = true;
    return add_row(r, ADD_TRIAL, trial, trial, trial_keys, 9, error) &&
           add_rows(r, ADD_DIRECTION, trial, "directions", direction_keys, 10, error) &&
           add_rows(r, ADD_ERROR, trial, "errors", error_keys, 4, error);
}

bool results_add_refinements(results *r, const json_t *answer, results_error *error)
{
    static const char *const keys[] = {"trial", "contact_solver", "step",     "halvings",  "status", "success",
                                       "exit",  "displacement",   "rotation", "wall_time", "hash"};
    if (!r->open_transaction && !run(r, "BEGIN IMMEDIATE", error)) return false;
    r->open_transaction = true;
    return add_rows(r, ADD_REFINEMENT, answer, "rows", keys, 11, error);
}

bool results_commit(results *r, results_error *error)
{
    if (!r->open_transaction) return true;
    r->open_transaction = false;
    if (run(r, "COMMIT", error)) return true;
    sqlite3_exec(r->database, "ROLLBACK", NULL, NULL, NULL);
    return false;
}

/* ---- Looking at them. ---- */

bool results_count(results *r, results_counts *counts, results_error *error)
{
    sqlite3_stmt *query = NULL;
    bool good = sqlite3_prepare_v2(r->database,
                                   "SELECT (SELECT trials FROM study), count(*), total(success), total(exit IN (1, 3)),"
                                   " total(exit = 2) FROM trials",
                                   -1, &query, NULL) == SQLITE_OK &&
                sqlite3_step(query) == SQLITE_ROW;
    if (good)
        *counts = (results_counts){sqlite3_column_int64(query, 0), sqlite3_column_int64(query, 1),
                                   sqlite3_column_int64(query, 2), sqlite3_column_int64(query, 3),
                                   sqlite3_column_int64(query, 4)};
    else
        (void)fail(r, error);
    sqlite3_finalize(query);
    return good;
}

static json_t *column_value(sqlite3_stmt *query, int i)
{
    switch (sqlite3_column_type(query, i)) {
    case SQLITE_INTEGER:
        return json_integer(sqlite3_column_int64(query, i));
    case SQLITE_FLOAT:
        return json_real(sqlite3_column_double(query, i));
    case SQLITE_TEXT:
        return json_string((const char *)sqlite3_column_text(query, i));
    default:
        return json_null();
    }
}

bool results_query(results *r, const char *query, bool (*take)(void *context, const json_t *names, json_t *row),
                   void *context, results_error *error)
{
    sqlite3_stmt *statement = NULL;
    if (sqlite3_prepare_v2(r->database, query, -1, &statement, NULL) != SQLITE_OK) return fail(r, error);
    json_t *names = json_array();
    int count = sqlite3_column_count(statement), code;
    for (int i = 0; i < count; i++) (void)json_array_append_new(names, json_string(sqlite3_column_name(statement, i)));
    bool more = true;
    while (more && (code = sqlite3_step(statement)) == SQLITE_ROW) {
        json_t *row = json_array();
        for (int i = 0; i < count; i++) (void)json_array_append_new(row, column_value(statement, i));
        more = take(context, names, row);
        json_decref(row);
    }
    bool good = !more || code == SQLITE_DONE || fail(r, error);
    sqlite3_finalize(statement);
    json_decref(names);
    return good;
}
