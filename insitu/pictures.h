// The pictures that a scene can ask for.  Each puts one on a page; false with a reason in `error`.
#pragma once

#include <string>

#include "frame_view.h"
#include "page.h"

// The scene: domains of the points coloured by a field, walls, ground.
bool picture_points(page &page, const frame_view &frame, const frame_image &image, std::string &error);

// One RVE: its discs, force chains and periodic surroundings.
bool picture_rve(page &page, const frame_view &frame, const frame_image &image, std::string &error);
