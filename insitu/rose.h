// The directions in an RVE: rose diagram of its contact normals, fabric and principal stresses.
#pragma once

#include "rve_scene.h"

// Draws it into the square-ish box `where` (pixels), with the words below the circle; what does not fit is left out.
void rose_draw(page &page, const rve_scene &rve, const box &where);
