/* The recorder that writes a file for each recording into a folder. */
#include <pinch/ode.h>

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* Opens the next file that is not there yet: other processes may write into the same folder. */
static FILE *open_next(pinch_ode_record_folder *folder, char *path, size_t size)
{
    enum { MOST_NUMBER = 999999 };
    while (folder->last < MOST_NUMBER) {
        snprintf(path, size, "%s/island-%06d.json", folder->path, ++folder->last);
        FILE *stream = fopen(path, "wx");
        if (stream || errno != EEXIST) return stream;
    }
    return NULL;
}

static void write_next(pinch_ode_record_folder *folder, const pinch_ode_recording *recording)
{
    size_t size = strlen(folder->path) + 32;
    char *path = malloc(size);
    FILE *stream = path ? open_next(folder, path, size) : NULL;
    bool written = stream && pinch_ode_write_recording(recording, stream);
    if (stream) written = fclose(stream) == 0 && written;
    if (stream && !written) (void)remove(path); /* half a file is no recording */
    free(path);
    if (written)
        folder->written++;
    else
        folder->failed = true;
}

void pinch_ode_record_into_folder(void *context, const pinch_ode_recording *recording)
{
    static pthread_mutex_t writing = PTHREAD_MUTEX_INITIALIZER;
    pinch_ode_record_folder *folder = context;
    int error = errno;
    pthread_mutex_lock(&writing);
    if (!folder->failed && folder->written < folder->most) write_next(folder, recording);
    pthread_mutex_unlock(&writing);
    errno = error;
}
