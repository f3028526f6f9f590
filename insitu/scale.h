// What a picture's colours mean: field, shown unit, range, map; and the bar that says so.
#pragma once

#include <string>
#include <vector>

#include "colour.h"
#include "frame_view.h"
#include "page.h"

struct colour_scale {
	std::string title;                 // "temperature [°C]"
	double factor = 1;                 // shown = value * factor
	double low = 0, high = 1;          // shown
	bool below = false, above = false; // there are values outside the range
	const std::vector<rgb> *map = nullptr;
	double wash = 0; // how far the colours go towards white

	double position(double value) const { return (value * factor - low) / (high - low); }
	rgb at(double t) const { return colour_mix(colour_map_at(*map, t), {1, 1, 1}, wash); }
	rgb colour(double value) const { return at(position(value)); }
};

// The scale of an image's field; `values` are what it shows, NaN ignored.  False with a reason in `error`.
bool scale_make(const frame_image &image, const frame_array &array, const char *temperature_unit,
				const std::vector<double> &values, colour_scale &scale, std::string &error);

// One value for each tuple: a component, the scalar, or (component -1) the magnitude.
std::vector<double> scale_values(const frame_view &frame, const frame_array &array, int component);

// Room for the bar: how wide an upright bar is with its labels, how high a lying one is.
double scale_bar_width(const page &page, const colour_scale &scale);
double scale_bar_height(const page &page);

// Draws it upright: its left edge at x, between y0 and y1; or lying: its upper edge at y, between x0 and x1.
void scale_bar_upright(page &page, const colour_scale &scale, double x, double y0, double y1);
void scale_bar_lying(page &page, const colour_scale &scale, double y, double x0, double x1);

// "W/m3" -> "W/m³", "C" -> "°C"; "" for "-".
std::string unit_text(const std::string &unit, const char *temperature_unit);
