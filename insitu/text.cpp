#include "text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

std::string number_text(double value, const char *format)
{
	char text[64];
	snprintf(text, sizeof text, format, value == 0 ? 0.0 : value);
	std::string made;
	for (const char *c = text; *c; c++)
		made += *c == '-' ? "\u2212" : std::string(1, *c);
	return made;
}

double text_line(const page &page, double letters) { return 1.45 * std::max(8.0, letters * page.unit); }

std::vector<std::string> text_wrap(const page &page, const std::vector<std::string> &pieces, double letters,
								   double width)
{
	std::vector<std::string> lines;
	for (const std::string &piece : pieces) {
		std::string longer = lines.empty() ? piece : lines.back() + "   " + piece;
		if (!lines.empty() && page.text_width(longer, letters) <= width)
			lines.back() = longer;
		else
			lines.push_back(piece);
	}
	return lines;
}

tensor_axes tensor_axes_of(double xx, double yy, double xy)
{
	double mean = 0.5 * (xx + yy), radius = std::hypot(0.5 * (xx - yy), xy);
	return {mean + radius, mean - radius, 0.5 * std::atan2(xy, 0.5 * (xx - yy))};
}
