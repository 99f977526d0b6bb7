#ifndef PINCH_VIEW_GLTF_H
#define PINCH_VIEW_GLTF_H

#include "film.h"

#include <stdio.h>

/*
 * Writes a film as binary glTF 2.0: every body as a node with its meshes, and for every contact point an arrow for the
 * force on the object and a friction cone in the colour of its state (stick, slip, yield, open). One animation moves
 * all of them; its times are those of the frames. The scene's axes are kept below a root node, which turns z up (in
 * dimension 2: nothing) to glTF's y up, so that a body's translation is its position in m. Numbers are floats, as glTF
 * has them: a position is true to 1e-7 of its size.
 *
 * The same film gives the same bytes. Returns false when memory runs out; write errors stay in the stream's error flag.
 */
bool gltf_write(const film *f, FILE *stream);

#endif
