/* Scene files: each is taken or refused with one line. */
#include "scenes/scene.h"
#include "target.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    scene *s = NULL;
    scene_error error;
    scene_status status = scene_load(target_file(data, size), &s, &error);
    if (status == SCENE_BAD_INPUT) target_check_message(error.text);
    if ((status == SCENE_OK) != (s != NULL)) target_found("status %d with scene %p", (int)status, (void *)s);
    scene_free(s);
    return 0;
}
