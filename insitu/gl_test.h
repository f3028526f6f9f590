// Does OpenGL draw what it is told to?
#pragma once

#include <string>

// Draws a few shapes off-screen on the open display and looks at the pixels.  `works` names the renderer; false with
// what is wrong in `error`.
bool gl_test(std::string &works, std::string &error);
