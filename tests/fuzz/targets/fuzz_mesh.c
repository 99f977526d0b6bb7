/* OBJ and STL files: each becomes closed convex pieces with a finite mass, or is refused with one line. */
#include "scenes/shape/shape.h"
#include "target.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char error[256] = "";
    const char *path = target_file(data, size);
    scene_shape shape = {.type = SCENE_MESH, .u.mesh.file = malloc(strlen(path) + 1)};
    if (!shape.u.mesh.file) return 0;
    strcpy(shape.u.mesh.file, path);
    scene_shape_fault fault = scene_shape_load_mesh(&shape, error);
    if (fault == SCENE_SHAPE_BAD_FILE || fault == SCENE_SHAPE_NOT_CONVEX) target_check_message(error);
    if (fault == SCENE_SHAPE_FINE) {
        if (!(shape.volume > 0) || !isfinite(shape.volume)) target_found("a volume of %g m^3", shape.volume);
        for (int i = 0; i < 9; i += 4)
            if (!(shape.unit_inertia[i] > 0) || !isfinite(shape.unit_inertia[i]))
                target_found("a moment of inertia of %g m^2", shape.unit_inertia[i]);
    }
    scene_shape_free(&shape);
    return 0;
}
