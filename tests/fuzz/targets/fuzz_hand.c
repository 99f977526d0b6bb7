/* URDF and MJCF files: each is taken or refused with one line. */
#include "hands/hand.h"
#include "target.h"

#include <math.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    hand *h = NULL;
    hand_error error;
    hand_status status = hand_load(target_file(data, size), NULL, 0, &h, &error);
    if (status == HAND_BAD_INPUT) target_check_message(error.text);
    if ((status == HAND_OK) != (h != NULL)) target_found("status %d with hand %p", (int)status, (void *)h);
    if (h && !isfinite(hand_total_mass(h))) target_found("a mass of %g kg", hand_total_mass(h));
    hand_free(h);
    return 0;
}
