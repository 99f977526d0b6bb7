/* Studies: each is taken or refused with one line, and trials of what is taken can be drawn. */
#include "study/study.h"
#include "target.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    study *s = NULL;
    scene_error error;
    scene_status status = study_load(target_file_in(PINCH_STUDIES, data, size), &s, &error);
    if (status == SCENE_BAD_INPUT) target_check_message(error.text);
    if ((status == SCENE_OK) != (s != NULL)) target_found("status %d with study %p", (int)status, (void *)s);
    if (!s) return 0;
    if (s->samples < 1 || s->samples > STUDY_MOST_SAMPLES) target_found("%ld trials", s->samples);
    const long trials[] = {0, s->samples / 2, s->samples - 1};
    for (int i = 0; i < 3; i++) {
        json_t *inputs = study_draw(s, trials[i]), *again = study_draw(s, trials[i]);
        if (!inputs || !json_equal(inputs, again)) target_found("trial %ld is drawn in two ways", trials[i]);
        json_decref(inputs);
        json_decref(again);
    }
    study_free(s);
    return 0;
}
