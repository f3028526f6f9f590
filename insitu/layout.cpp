#include "layout.h"

#include <algorithm>
#include <cmath>

#include "base/ticks.h"

namespace
{
constexpr double margin = 22, gap = 20, heading = 40, letters = 19, heading_letters = 22, length_gap = 9; // page units

} // namespace

std::string layout_time(double time)
{
	char text[64];
	if (time == 0 || std::fabs(time) >= 0.01)
		snprintf(text, sizeof text, "t = %.3f s", time);
	else if (std::fabs(time) >= 1e-5)
		snprintf(text, sizeof text, "t = %.3f ms", time * 1e3);
	else
		snprintf(text, sizeof text, "t = %.3f \u00b5s", time * 1e6);
	return text;
}

layout layout_make(page &page, const box &view, const colour_scale &scale, double foot)
{
	double u = page.unit, wide = page.width - 2 * margin * u, high = page.height - (2 * margin + heading + foot) * u;
	double bar_width = gap * u + scale_bar_width(page, scale), bar_height = 0.6 * gap * u + scale_bar_height(page);
	double beside = std::min((wide - bar_width) / view.width(), high / view.height());
	double under = std::min(wide / view.width(), (high - bar_height) / view.height());
	layout made;
	made.lying = beside < 0.97 * under;
	double s = made.lying ? under : beside; // pixels per metre
	double w = std::max(8.0, std::round(view.width() * s)), h = std::max(8.0, std::round(view.height() * s));
	double group_w = made.lying ? w : w + bar_width, group_h = made.lying ? h + bar_height : h;
	double x = std::round(0.5 * (page.width - group_w));
	double y = std::round((margin + foot) * u + 0.5 * (high - group_h));
	made.group = {x, y, x + group_w, y + group_h};
	made.window = {x, y + group_h - h, x + w, y + group_h};
	double cx = 0.5 * (view.x0 + view.x1), cy = 0.5 * (view.y0 + view.y1);
	page.look({cx - 0.5 * w / s, cy - 0.5 * h / s, cx + 0.5 * w / s, cy + 0.5 * h / s}, made.window);
	return made;
}

void layout_bar(page &page, const layout &where, const colour_scale &scale)
{
	double u = page.unit;
	const box &w = where.window;
	if (where.lying) {
		double inset = std::max(0.1 * w.width(), 0.5 * (w.width() - 700 * u));
		scale_bar_lying(page, scale, w.y0 - 0.6 * gap * u, w.x0 + inset, w.x1 - inset);
	} else {
		double inset = std::max(0.04 * w.height(), 0.5 * (w.height() - 560 * u));
		scale_bar_upright(page, scale, w.x1 + gap * u, w.y0 + inset, w.y1 - inset);
	}
}

std::string layout_fit(const page &page, std::string text, double size, double width)
{
	if (page.text_width(text, size) <= width)
		return text;
	while (!text.empty() && page.text_width(text + "\u2026", size) > width) {
		while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0) == 0x80)
			text.pop_back(); // the tail of a character of several bytes
		if (!text.empty())
			text.pop_back();
	}
	return text + "\u2026";
}

void layout_heading(page &page, const layout &where, const std::string &title, const std::string &clock)
{
	double u = page.unit, y = where.group.y1 + 14 * u, x0 = where.group.x0, x1 = where.group.x1;
	double clock_width = page.text_width(clock, heading_letters), space = 30 * u;
	if (page.text_width(title, heading_letters) + space + clock_width > x1 - x0) {
		x0 = margin * u;
		x1 = page.width - margin * u;
	}
	page.text(layout_fit(page, title, heading_letters, x1 - x0 - space - clock_width), x0, y, heading_letters,
			  align::low, align::low);
	page.text(clock, x1, y, heading_letters, align::high, align::low);
}

length_scale length_scale_make(const page &page, const layout &where)
{
	double room = std::max(0.22 * where.window.width(), 60 * page.unit) * page.metres_per_pixel();
	double length = std::pow(10, std::floor(std::log10(room)));
	length *= room >= 5 * length ? 5 : room >= 2 * length ? 2 : 1;
	char unit[TICKS_UNIT], text[96];
	double shown = length * ticks_unit("m", length * 1.0001, unit);
	snprintf(text, sizeof text, "%g %s", shown, unit);
	length_scale made = {length / page.metres_per_pixel(), text, 0};
	made.width = made.pixels + length_gap * page.unit + page.text_width(made.text, letters);
	return made;
}

void length_scale_draw(page &page, const length_scale &scale, double x, double y)
{
	double u = page.unit, end = x + scale.pixels;
	shapes bar;
	double strokes[3][2][2] = {
		{{x, y}, {end, y}}, {{x, y - 5 * u}, {x, y + 5 * u}}, {{end, y - 5 * u}, {end, y + 5 * u}}};
	for (const auto &stroke : strokes)
		bar.line(stroke, 2, false, ink::text);
	page.draw(bar, 1.8);
	page.text(scale.text, end + length_gap * u, y, letters, align::low, align::middle);
}

void layout_frame(page &page, const layout &where)
{
	const box &w = where.window;
	double corners[4][2] = {{w.x0, w.y0}, {w.x1, w.y0}, {w.x1, w.y1}, {w.x0, w.y1}};
	shapes frame;
	frame.line(corners, 4, true, ink::frame);
	page.draw(frame, 1);
}

void layout_note(page &page, const layout &where, const std::string &text, double below)
{
	double u = page.unit, x = where.window.x0;
	if (page.text_width(text, letters) > page.width - margin * u - x)
		x = margin * u;
	page.text(layout_fit(page, text, letters, page.width - margin * u - x), x, where.group.y0 - below * u, letters,
			  align::low, align::middle);
}
