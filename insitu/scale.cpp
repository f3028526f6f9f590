#include "scale.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/ticks.h"

namespace
{
constexpr double letters = 19, bar = 20, tick = 6, gap = 8; // page units

std::string replaced(std::string text, const std::string &from, const std::string &to)
{
	for (size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
		text.replace(at, from.size(), to);
	return text;
}

// "stress" + component 1 of 6 -> "stress yy".
std::string field_text(const frame_array &array, int component)
{
	static const char *const vector[] = {"x", "y", "z"};
	static const char *const tensor[] = {"xx", "yy", "zz", "xy", "yz", "xz"};
	std::string text = replaced(array.name, "_", " ");
	if (component < 0 || array.components == 1)
		return text;
	if (array.components == 3)
		return text + " " + vector[component];
	if (array.components == 6)
		return text + " " + tensor[component];
	return text + " " + std::to_string(component);
}

struct labels {
	std::vector<double> values;
	std::vector<std::string> texts;
};

labels labels_make(const colour_scale &scale, int n)
{
	double values[TICKS_MAX], step;
	int count = ticks_make(scale.low, scale.high, n, values, &step);
	labels made;
	for (int k = 0; k < count; k++) {
		char text[TICKS_LABEL];
		ticks_label(values[k], step, std::max(std::fabs(scale.low), std::fabs(scale.high)), text);
		made.values.push_back(values[k]);
		made.texts.push_back(replaced(text, "-", "\u2212"));
	}
	return made;
}

constexpr int parts = 5; // of a scale, about

// Bar in its own frame: `along` from a to b, `across` from c to d; lying or upright.
void bar_draw(page &page, const colour_scale &scale, bool lying, double a, double b, double c, double d)
{
	constexpr int n = 256;
	auto rectangle = [&](double from, double to) { return lying ? box{from, c, to, d} : box{c, from, d, to}; };
	shapes body, outline;
	for (int k = 0; k < n; k++)
		body.rectangle(rectangle(a + (b - a) * k / n, a + (b - a) * (k + 1) / n),
					   scale.at((k + 0.5) / n));
	// A point at an end where the data go on beyond the scale.
	double tip = 0.9 * (d - c), middle = 0.5 * (c + d);
	std::vector<std::array<double, 2>> path;
	auto corner = [&](double along, double across) {
		path.push_back(lying ? std::array<double, 2>{along, across} : std::array<double, 2>{across, along});
	};
	corner(a, c);
	if (scale.below)
		corner(a - tip, middle);
	corner(a, d), corner(b, d);
	if (scale.above)
		corner(b + tip, middle);
	corner(b, c);
	auto point = [&](double base, double end, const rgb &colour) {
		double p[3][2];
		for (int k = 0; k < 3; k++) {
			double along = k == 1 ? end : base, across = k == 0 ? c : k == 1 ? middle : d;
			p[k][0] = lying ? along : across;
			p[k][1] = lying ? across : along;
		}
		body.polygon(p, 3, colour);
	};
	if (scale.below)
		point(a, a - tip, scale.at(0));
	if (scale.above)
		point(b, b + tip, scale.at(1));
	outline.line(reinterpret_cast<const double(*)[2]>(path.data()), int(path.size()), true, ink::text);
	page.draw(body);
	page.draw(outline, 1.2);
}
} // namespace

std::string unit_text(const std::string &unit, const char *temperature_unit)
{
	std::string text = unit == "T" ? temperature_unit : unit;
	if (text == "-" || text.empty())
		return "";
	if (text == "C")
		return "\u00b0C";
	return replaced(replaced(text, "m3", "m\u00b3"), "m2", "m\u00b2");
}

std::vector<double> scale_values(const frame_view &frame, const frame_array &array, int component)
{
	std::vector<double> values(static_cast<size_t>(array.count));
	for (int64_t k = 0; k < array.count; k++) {
		double sum = 0;
		for (int c = 0; c < array.components; c++)
			sum += std::pow(frame.value(array, k, c), 2);
		values[static_cast<size_t>(k)] = array.components == 1 ? frame.value(array, k)
										 : component >= 0      ? frame.value(array, k, component)
															   : std::sqrt(sum);
	}
	return values;
}

bool scale_make(const frame_image &image, const frame_array &array, const char *temperature_unit,
				const std::vector<double> &values, colour_scale &scale, std::string &error)
{
	scale.map = colour_map_find(image.map);
	if (!scale.map) {
		error = "no colour map \"" + std::string(image.map) + "\"; there are viridis, inferno and coolwarm";
		return false;
	}
	if (image.component >= array.components && array.components > 1) {
		error = std::string(array.name) + " has no component " + std::to_string(image.component);
		return false;
	}
	double least = std::numeric_limits<double>::infinity(), most = -least;
	for (double v : values)
		if (std::isfinite(v))
			least = std::min(least, v), most = std::max(most, v);
	if (!(least <= most))
		least = most = 0;

	char unit[TICKS_UNIT];
	double largest = image.range_auto ? std::max(std::fabs(least), std::fabs(most))
									  : std::max(std::fabs(image.range[0]), std::fabs(image.range[1]));
	double range_factor; // range in the image's unit -> shown
	if (image.unit[0]) {
		snprintf(unit, sizeof unit, "%s", image.unit);
		scale.factor = ticks_unit_factor(array.unit, image.unit);
		bool temperature = std::string(array.unit) == "T" && image.unit == std::string(temperature_unit);
		if (scale.factor == 0 && !temperature) {
			error = std::string(array.name) + " is in " + array.unit + ", which cannot be shown in " + image.unit;
			return false;
		}
		scale.factor = temperature ? 1 : scale.factor;
		range_factor = 1;
	} else {
		scale.factor = range_factor = ticks_unit(array.unit, largest, unit);
	}
	double range[2] = {least * scale.factor, most * scale.factor};
	if (image.range_auto) {
		// zero means nothing to a temperature
		ticks_widen(range, parts, image.map == std::string("coolwarm") && array.unit != std::string("T"));
	} else {
		for (int k = 0; k < 2; k++)
			range[k] = image.range[k] * range_factor;
		double slack = 1e-6 * (range[1] - range[0]);
		scale.below = least * scale.factor < range[0] - slack;
		scale.above = most * scale.factor > range[1] + slack;
	}
	scale.low = range[0];
	scale.high = range[1];
	std::string shown = unit_text(unit, temperature_unit);
	scale.title = field_text(array, image.component) + (shown.empty() ? "" : " [" + shown + "]");
	return true;
}

double scale_bar_width(const page &page, const colour_scale &scale)
{
	double widest = 0;
	for (const std::string &text : labels_make(scale, parts).texts)
		widest = std::max(widest, page.text_width(text, letters));
	return widest + (bar + tick + 2 * gap + 1.2 * letters) * page.unit;
}

double scale_bar_height(const page &page) { return (bar + tick + 2 * gap + 2.3 * letters) * page.unit; }

void scale_bar_upright(page &page, const colour_scale &scale, double x, double y0, double y1)
{
	double u = page.unit, right = x + bar * u;
	y0 += scale.below ? bar * u : 0;
	y1 -= scale.above ? bar * u : 0;
	bar_draw(page, scale, false, y0, y1, x, right);
	shapes ticks;
	labels made = labels_make(scale, parts);
	double widest = 0;
	for (size_t k = 0; k < made.values.size(); k++) {
		double y = y0 + (y1 - y0) * (made.values[k] - scale.low) / (scale.high - scale.low);
		double stroke[2][2] = {{right, y}, {right + tick * u, y}};
		ticks.line(stroke, 2, false, ink::text);
		page.text(made.texts[k], right + (tick + 0.6 * gap) * u, y, letters, align::low, align::middle);
		widest = std::max(widest, page.text_width(made.texts[k], letters));
	}
	page.draw(ticks, 1.2);
	page.text(scale.title, right + (tick + 1.6 * gap) * u + widest, 0.5 * (y0 + y1), letters, align::low, align::middle,
			  ink::text, false, true);
}

void scale_bar_lying(page &page, const colour_scale &scale, double y, double x0, double x1)
{
	double u = page.unit, low = y - bar * u;
	x0 += scale.below ? bar * u : 0;
	x1 -= scale.above ? bar * u : 0;
	bar_draw(page, scale, true, x0, x1, low, y);
	shapes ticks;
	labels made = labels_make(scale, parts);
	for (size_t k = 0; k < made.values.size(); k++) {
		double x = x0 + (x1 - x0) * (made.values[k] - scale.low) / (scale.high - scale.low);
		double stroke[2][2] = {{x, low}, {x, low - tick * u}};
		ticks.line(stroke, 2, false, ink::text);
		page.text(made.texts[k], x, low - (tick + 0.4 * gap) * u, letters, align::middle, align::high);
	}
	page.draw(ticks, 1.2);
	page.text(scale.title, 0.5 * (x0 + x1), low - (tick + gap + 1.1 * letters) * u, letters, align::middle,
			  align::high);
}
