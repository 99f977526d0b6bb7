/* Recorded islands: each is read and solved again, or refused with one line. */
#include "replay/island_file.h"
#include "target.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    island_file *file = NULL;
    scene_error error;
    scene_status status = island_file_load(target_file(data, size), &file, &error);
    if (status == SCENE_BAD_INPUT) target_check_message(error.text);
    if ((status == SCENE_OK) != (file != NULL)) target_found("status %d with file %p", (int)status, (void *)file);
    island_file_free(file);
    return 0;
}
