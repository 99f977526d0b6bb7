#define _POSIX_C_SOURCE 200809L

#include "pinch_run.h"

#include "common/whole_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { EVERY = 1000, LARGEST = 1 << 28 /* bytes */ };

static command_status refuse(const run_checkpoint *c, const char *why)
{
    command_error("run", "--resume: %s: %s", c->from_path, why);
    return COMMAND_BAD_INPUT;
}

/* A pipe or a device may not end: only a file is read. */
static command_status read_from(run_checkpoint *c)
{
    struct stat status;
    int fd = open(c->from_path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    FILE *stream = fd < 0 ? NULL : fdopen(fd, "rb");
    if (!stream) {
        command_status refused = refuse(c, strerror(errno));
        if (fd >= 0) close(fd);
        return refused;
    }
    command_status done = COMMAND_DONE;
    if (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode) || status.st_size > LARGEST) {
        done = refuse(c, "expected a checkpoint that pinch run has written");
    } else {
        c->from_size = (size_t)status.st_size;
        c->from = malloc(c->from_size + 1);
        if (!c->from) {
            command_error("run", "out of memory");
            done = COMMAND_SYSTEM;
        } else if (fread(c->from, 1, c->from_size, stream) != c->from_size) {
            done = refuse(c, "cannot be read");
        }
    }
    fclose(stream);
    return done;
}

command_status run_checkpoint_prepare(const options *o, run_checkpoint *c)
{
    *c = (run_checkpoint){.path = o->checkpoint, .every = o->given[OPTION_EVERY] ? o->every : EVERY};
    if ((o->checkpoint || o->resume) && o->contact_solver != WORLD_PINCH) {
        command_error("run", "--%s: expected Pinch as contact solver, whose state it keeps, got %s",
                      o->checkpoint ? "checkpoint" : "resume", world_solver_name(o->contact_solver));
        return COMMAND_BAD_INPUT;
    }
    /* the first one may be hours away */
    if (o->checkpoint && !whole_file_can_be_written(o->checkpoint)) return command_cannot_write("run", o->checkpoint);
    if (!o->resume) return COMMAND_DONE;
    c->from_path = o->resume;
    return read_from(c);
}

void run_checkpoint_free(run_checkpoint *c)
{
    free(c->from);
    c->from = NULL;
}

static command_status no_memory(void)
{
    command_error("run", "out of memory");
    return COMMAND_SYSTEM;
}

command_status run_checkpoint_resume(const run_checkpoint *c, simulation *s)
{
    bool writes = c->path != NULL;
    if ((writes || c->from) && !simulation_know_origin(s)) return no_memory();
    if (!c->from) return COMMAND_DONE;
    switch (simulation_resume(s, (const unsigned char *)c->from, c->from_size)) {
    case CHECKPOINT_FINE:
        return COMMAND_DONE;
    case CHECKPOINT_FOREIGN:
        return refuse(c, "is a checkpoint of another scene, or of a run with other options: scene, the files of its "
                         "hands and meshes, solver, --step and --duration must be the same, as a run cannot be made "
                         "longer");
    case CHECKPOINT_DAMAGED:
        return refuse(c, "expected a whole checkpoint that this version of pinch run has written");
    default:
        return no_memory();
    }
}

/* The file is on the disk before it takes the place of the last one. */
static bool write_whole(const char *path, const unsigned char *bytes, size_t size)
{
    whole_file file;
    if (!whole_file_open(&file, path)) return false;
    bool written = fwrite(bytes, 1, size, file.stream) == size && fflush(file.stream) == 0 &&
                   (fsync(fileno(file.stream)) == 0 || errno == EINVAL || errno == ENOTSUP);
    return whole_file_close(&file, written) && written;
}

command_status run_checkpoint_step(const run_checkpoint *c, simulation *s, long steps, bool now)
{
    unsigned char *bytes;
    size_t size;
    if (!c->path || (!now && steps % c->every != 0)) return COMMAND_DONE;
    if (!simulation_checkpoint(s, &bytes, &size)) {
        command_error("run", "out of memory");
        return COMMAND_SYSTEM;
    }
    bool written = write_whole(c->path, bytes, size);
    free(bytes);
    return written ? COMMAND_DONE : command_cannot_write("run", c->path);
}
