// Numbers and lines of words for pages.
#pragma once

#include <string>
#include <vector>

#include "base/ticks.h"
#include "page.h"

// printf's format, with a minus sign that is one.
std::string number_text(double value, const char *format);

// Height of a line, pixels: letters have a least size on small pages.
double text_line(const page &page, double letters);

// Puts the pieces, three blanks between them, into lines no wider than `width` pixels; a piece is not cut in two.
std::vector<std::string> text_wrap(const page &page, const std::vector<std::string> &pieces, double letters,
								   double width);

// Principal values of a symmetric tensor in the plane and the direction (rad) of the larger one.
struct tensor_axes {
	double large, small, angle;
};
tensor_axes tensor_axes_of(double xx, double yy, double xy);
