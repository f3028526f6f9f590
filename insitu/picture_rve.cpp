#include "pictures.h"

#include <algorithm>
#include <cmath>

#include "layout.h"
#include "rose.h"
#include "text.h"

namespace
{
enum level { LEVEL_DISCS, LEVEL_RIMS, LEVEL_CASING, LEVEL_CHAINS, LEVEL_BONDS, LEVEL_CELL = LEVEL_BONDS + 2 };

constexpr double surroundings_fade = 0.72; // how far the periodic images go towards white
constexpr double discs_wash = 0.35;        // how far the discs do, so that dark chains stand out on them
constexpr double pi = 3.14159265358979323846;

// page units
constexpr double margin = 22, gap = 20, letters = 17, swatch = 26, legend_gap = 20, heading_letters = 22, heading = 40;
constexpr double bare_below = 0.22; // page.unit below which there is no room for words
constexpr double column_width = 236, pair_column_width = 216, strip_height = 250;

bool inside(const box &b, double x, double y, double reach)
{
	return x > b.x0 - reach && x < b.x1 + reach && y > b.y0 - reach && y < b.y1 + reach;
}

// ---- what lies in the window ----

void draw_discs(page &page, const rve_scene &rve, const colour_scale &scale, const box &view)
{
	shapes bodies, rims;
	double largest = 0;
	for (const disc &d : rve.discs)
		largest = std::max(largest, d.radius / page.metres_per_pixel());
	int sides = int(std::clamp(10 + 1.5 * largest, 12.0, 64.0));
	std::vector<std::array<double, 2>> circle{size_t(sides)};
	rve.shape.for_images(view, [&](double dx, double dy, bool own) {
		for (const disc &d : rve.discs) {
			if (!inside(view, d.x + dx, d.y + dy, d.radius))
				continue;
			for (int k = 0; k < sides; k++)
				circle[size_t(k)] = {d.x + dx + d.radius * std::cos(2 * pi * k / sides),
									 d.y + dy + d.radius * std::sin(2 * pi * k / sides)};
			auto p = reinterpret_cast<const double(*)[2]>(circle.data());
			rgb colour = scale.colour(d.value), white = {1, 1, 1};
			double fade = own ? 0 : surroundings_fade;
			bodies.polygon(p, sides, colour_mix(colour, white, fade));
			rims.line(p, sides, true, colour_mix(colour_mix(colour, ink::text, 0.55), white, fade));
		}
	});
	page.draw_world(bodies, LEVEL_DISCS);
	if (largest > 4)
		page.draw_world(rims, LEVEL_RIMS, 1);
}

struct chains {
	double reference; // N
	double widest;    // m, at the reference force
	double width(double force) const { return widest * std::min(1.5, std::fabs(force) / reference); }
};

rgb contact_colour(const contact &c)
{
	return c.sliding ? ink::sliding : c.force < 0 ? ink::tension : ink::compression;
}

// Cement across the contact: a light bar with a rim; a broken one is a thin bar.
void draw_bond(shapes &rims, shapes &bodies, const contact &c, const double middle[2], double size, double pixel,
			   double fade)
{
	double tx = -(c.b[1] - c.a[1]), ty = c.b[0] - c.a[0], l = std::hypot(tx, ty);
	bool intact = c.bond == 1;
	double half = (intact ? 0.34 : 0.30) * size, thick = std::max((intact ? 0.17 : 0.11) * size, 1.6 * pixel);
	double from[2] = {middle[0] - half * tx / l, middle[1] - half * ty / l};
	double to[2] = {middle[0] + half * tx / l, middle[1] + half * ty / l};
	if (intact)
		rims.band(from, to, thick + 1.8 * pixel, colour_mix(ink::compression, {1, 1, 1}, fade));
	bodies.band(from, to, thick, intact ? ink::bond : colour_mix(ink::broken, {1, 1, 1}, fade));
}

void draw_contacts(page &page, const rve_scene &rve, const chains &chains, const box &view)
{
	shapes casing, bands, bonds, bond_rims;
	double pixel = page.metres_per_pixel() * page.unit;
	rve.shape.for_images(view, [&](double dx, double dy, bool own) {
		double fade = own ? 0 : surroundings_fade;
		for (const contact &c : rve.contacts) {
			double a[2] = {c.a[0] + dx, c.a[1] + dy}, b[2] = {c.b[0] + dx, c.b[1] + dy};
			double middle[2] = {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])};
			if (!inside(view, middle[0], middle[1], 2.5 * rve.mean_radius))
				continue;
			double w = std::max(chains.width(c.force), (c.sliding || c.force < 0 ? 2.2 : 0.8) * pixel);
			if (c.touching() && w > 1.3 * pixel)
				casing.band(a, b, w + 1.6 * pixel, {1, 1, 1}, own ? 0.75 : 0.5);
			if (c.touching())
				bands.band(a, b, w, colour_mix(contact_colour(c), {1, 1, 1}, fade));
			if (c.bond != 0)
				draw_bond(bond_rims, bonds, c, middle, rve.mean_radius, pixel, fade);
		}
	});
	page.draw_world(casing, LEVEL_CASING);
	page.draw_world(bands, LEVEL_CHAINS);
	page.draw_world(bond_rims, LEVEL_BONDS);
	page.draw_world(bonds, LEVEL_BONDS + 1);
}

void draw_cell(page &page, const cell &shape)
{
	double corners[4][2];
	for (int k = 0; k < 4; k++) {
		auto p = shape.place(k == 1 || k == 2, k >= 2);
		corners[k][0] = p[0], corners[k][1] = p[1];
	}
	shapes under, outline;
	under.line(corners, 4, true, {1, 1, 1});
	outline.line(corners, 4, true, ink::cell);
	page.draw_world(under, LEVEL_CELL, 5);
	page.draw_world(outline, LEVEL_CELL + 1, 2.6);
}

// ---- legend ----

struct legend_item {
	std::string text;
	std::function<void(page &, double x, double y)> sign;
	double width; // of the sign, pixels
};

legend_item line_item(const page &page, const std::string &text, rgb colour, double thick)
{
	double width = swatch * page.unit;
	return {text,
			[=](class page &page, double x, double y) {
				shapes s;
				s.rectangle({x, y - 0.5 * thick, x + width, y + 0.5 * thick}, colour);
				page.draw(s);
			},
			width};
}

legend_item bond_item(const page &page, const std::string &text, rgb colour, bool rim)
{
	double u = page.unit;
	return {text,
			[=](class page &page, double x, double y) {
				shapes s;
				if (rim)
					s.rectangle({x, y - 8 * u, x + 7 * u, y + 8 * u}, ink::compression);
				s.rectangle({x + 1.3 * u, y - 6.7 * u, x + 5.7 * u, y + 6.7 * u}, colour);
				page.draw(s);
			},
			7 * u};
}

// A round force near the reference.
std::string force_text(const chains &chains, double *shown)
{
	double step = ticks_step(chains.reference, 1);
	*shown = step > chains.reference * 1.2 ? ticks_step(0.4 * chains.reference, 1) : step;
	char unit[TICKS_UNIT], text[96];
	double factor = ticks_unit("N", *shown * 1.0001, unit);
	snprintf(text, sizeof text, "force %g %s", *shown * factor, unit);
	return text;
}

std::vector<legend_item> legend_items(const page &page, const std::vector<rve_scene> &rves, const chains &chains)
{
	std::vector<legend_item> items;
	bool any[5] = {};
	for (const rve_scene &rve : rves)
		for (const contact &c : rve.contacts) {
			any[c.sliding ? 2 : c.force < 0 ? 1 : 0] |= c.touching();
			any[3] |= c.bond == 1, any[4] |= c.bond == 2;
		}
	double u = page.unit, shown;
	std::string force = force_text(chains, &shown);
	if (any[0] || any[1] || any[2])
		items.push_back(
			line_item(page, force, ink::compression, std::max(1.0, chains.width(shown) / page.metres_per_pixel())));
	if (any[1])
		items.push_back(line_item(page, "tension", ink::tension, 5 * u));
	if (any[2])
		items.push_back(line_item(page, "sliding", ink::sliding, 5 * u));
	if (any[3])
		items.push_back(bond_item(page, "bond", ink::bond, true));
	if (any[4])
		items.push_back(bond_item(page, "broken bond", ink::broken, false));
	return items;
}

// Length scale, then signs and words, from x0 on; what does not fit before x1 begins another line, `y` being the middle
// of the first.
void draw_legend(page &page, const length_scale &length, const std::vector<legend_item> &items, double x0, double x1,
				 double y)
{
	double u = page.unit, x = x0 + length.width;
	length_scale_draw(page, length, x0, y);
	for (const legend_item &item : items) {
		double width = item.width + 8 * u + page.text_width(item.text, letters);
		if (x + legend_gap * u + width > x1) {
			x = x0 - legend_gap * u;
			y -= text_line(page, letters);
		}
		x += legend_gap * u;
		item.sign(page, x, y);
		page.text(item.text, x + item.width + 8 * u, y, letters, align::low, align::middle);
		x += width;
	}
}

int legend_lines(const page &page, const length_scale &length, const std::vector<legend_item> &items, double width)
{
	double u = page.unit, x = length.width;
	int lines = 1;
	for (const legend_item &item : items) {
		double wide = legend_gap * u + item.width + 8 * u + page.text_width(item.text, letters);
		lines += x + wide > width;
		x = x + wide > width ? wide - legend_gap * u : x + wide;
	}
	return lines;
}

// ---- words ----

// With as many decimals as the largest needs for three digits.
std::string components(double xx, double yy, double xy)
{
	double most = std::max({std::fabs(xx), std::fabs(yy), std::fabs(xy)});
	int decimals = most > 0 ? std::clamp(2 - int(std::floor(std::log10(most))), 0, 6) : 0;
	std::string format = "%." + std::to_string(decimals) + "f";
	auto text = [&](double value) {
		bool none = std::fabs(value) < 0.5 * std::pow(10, -decimals);
		return number_text(none ? 0 : value, none ? "%.0f" : format.c_str());
	};
	return "xx " + text(xx) + ", yy " + text(yy) + ", xy " + text(xy);
}

std::vector<std::string> state_texts(const rve_scene &rve, const char *temperature_unit)
{
	const frame_rve &w = rve.whole;
	std::vector<std::string> pieces;
	char unit[TICKS_UNIT];
	double most = std::max({std::fabs(w.stress[0]), std::fabs(w.stress[1]), std::fabs(w.stress[3])});
	double factor = ticks_unit("Pa", most, unit);
	if (w.point >= 0)
		pieces.push_back("point " + std::to_string(w.point) + (*w.rule ? " (" + std::string(w.rule) + ")" : ""));
	pieces.push_back((page::greek() ? "\u03c3 " : "stress ") +
					 components(w.stress[0] * factor, w.stress[1] * factor, w.stress[3] * factor) + " " + unit);
	pieces.push_back((page::greek() ? "\u03b5 " : "strain ") +
					 components(100 * w.strain[0], 100 * w.strain[1], 100 * w.strain[3]) + " %");
	pieces.push_back("e " + number_text(w.void_ratio, "%.3f"));
	pieces.push_back("Z " + number_text(w.coordination, "%.2f"));
	if (std::isfinite(w.temperature))
		pieces.push_back("T " + number_text(w.temperature, "%.5g") + " " +
						 unit_text(temperature_unit, temperature_unit));
	if (w.bonds_installed > 0)
		pieces.push_back("bonds " + std::to_string(w.bonds_intact) + " of " + std::to_string(w.bonds_installed));
	if (w.flags & FRAME_RVE_FLYING)
		pieces.push_back("flies free");
	if (w.flags & FRAME_RVE_FROZEN)
		pieces.push_back("frozen");
	return pieces;
}

// "RVE A – title"; one that no scene has named is known by its point.
std::string title_text(const frame_view &frame, const frame_image &image)
{
	std::string name = image.rve, title = frame.header().title;
	if (name.rfind("point_", 0) == 0)
		name = "of point " + name.substr(6);
	return "RVE " + name + (title.empty() ? "" : " \u2013 " + title);
}

// ---- where things stand ----

// One RVE's window with its rose, colour bar, words and legend: the rose beside the window and the words below, or all
// in a strip under it.
struct plan {
	bool beside;
	double scale;        // pixels per metre
	double w, h;         // of the window, pixels
	double column, foot; // width of what stands beside, height of what stands under it
	double total_w, total_h;
};

struct rve_page {
	class page &page;
	const std::vector<rve_scene> &rves;
	const colour_scale &scale;
	std::vector<std::vector<std::string>> words = {}; // of each RVE, in pieces
	double view_w = 0, view_h = 0;                    // m, the same for all
	plan p = {};
	std::vector<box> windows = {}; // pixels

	double u() const { return page.unit; }
	double line() const { return text_line(page, letters); }
	bool pair() const { return rves.size() > 1; }
	// Lines that the words of all need at this width.
	double lines(double width) const
	{
		size_t most = 0;
		for (const auto &pieces : words)
			most = std::max(most, text_wrap(page, pieces, letters, width).size());
		return std::min(double(most), std::max(1.0, std::floor(0.2 * page.height / line())));
	}
};

// The better of both ways in a region of `wide` x `high` pixels.
plan plan_make(const rve_page &at, double wide, double high)
{
	double u = at.u(), line = at.line(), strip = std::max(strip_height * u, 90 * u + 7 * line);
	double column = std::max((at.pair() ? pair_column_width : column_width) * u, scale_bar_width(at.page, at.scale));
	double foot = 12 * u + (at.lines(wide) + 2) * line;
	double beside = std::min((wide - column - gap * u) / at.view_w, (high - foot) / at.view_h);
	double under = std::min(wide / at.view_w, (high - strip) / at.view_h);
	plan p = {};
	p.beside = at.pair() || beside >= 0.9 * under;
	p.scale = std::max(p.beside ? beside : under, 8 / std::max(at.view_w, at.view_h));
	p.w = std::max(8.0, std::round(at.view_w * p.scale));
	p.h = std::max(8.0, std::round(at.view_h * p.scale));
	p.column = p.beside ? column + gap * u : 0;
	p.foot = p.beside ? foot : strip;
	p.total_w = p.w + p.column;
	p.total_h = p.h + p.foot;
	return p;
}

void draw_window(rve_page &at, size_t k, const chains &chains)
{
	box view = at.rves[k].view();
	double x = 0.5 * (view.x0 + view.x1), y = 0.5 * (view.y0 + view.y1);
	double w = at.p.w / at.p.scale, h = at.p.h / at.p.scale;
	view = {x - 0.5 * w, y - 0.5 * h, x + 0.5 * w, y + 0.5 * h};
	at.page.look(view, at.windows[k]);
	draw_discs(at.page, at.rves[k], at.scale, view);
	draw_contacts(at.page, at.rves[k], chains, view);
	draw_cell(at.page, at.rves[k].shape);
	layout where = {};
	where.window = at.windows[k];
	layout_frame(at.page, where);
}

// The words of RVE k from `y` down; returns where the next line would stand.
double draw_words(const rve_page &at, size_t k, double x, double y, double width)
{
	double lines = at.lines(width);
	for (const std::string &text : text_wrap(at.page, at.words[k], letters, width)) {
		if (lines-- < 1)
			break;
		at.page.text(layout_fit(at.page, text, letters, width), x, y, letters, align::low, align::middle);
		y -= at.line();
	}
	return y;
}

// Rose and, for the last one, the colour bar in the column beside window k.
void draw_column(const rve_page &at, size_t k, bool bar)
{
	double u = at.u(), x0 = at.windows[k].x1 + gap * u, x1 = at.windows[k].x1 + at.p.column, y1 = at.windows[k].y1;
	double height = at.windows[k].height(), rose = std::min(height, x1 - x0 + 60 * u);
	rose = bar ? std::min(rose, 0.52 * height) : rose;
	rose_draw(at.page, at.rves[k], {x0, y1 - rose, x1, y1});
	if (!bar)
		return;
	double room = height - rose - 26 * u, inset = 0.5 * std::max(10 * u, room - 420 * u);
	double x = std::round(x0 + 0.5 * std::max(0.0, x1 - x0 - scale_bar_width(at.page, at.scale)));
	scale_bar_upright(at.page, at.scale, x, at.windows[k].y0 + inset, at.windows[k].y0 + room - inset);
}

// From `x` to `x1`, or from edge to edge of the page where that is too narrow; left out where nothing helps.
void draw_legend_in(const rve_page &at, const chains &chains, double x, double x1, double y)
{
	layout where = {};
	where.window = at.windows[0];
	length_scale length = length_scale_make(at.page, where);
	auto items = legend_items(at.page, at.rves, chains);
	if (legend_lines(at.page, length, items, x1 - x) > 2)
		x = margin * at.u(), x1 = at.page.width - margin * at.u();
	if (legend_lines(at.page, length, items, x1 - x) <= 2)
		draw_legend(at.page, length, items, x, x1, y);
}

// Everything under a wide window: bar, words and legend on the left, rose on the right.
void draw_strip(const rve_page &at, const chains &chains)
{
	double u = at.u();
	const box &w = at.windows[0];
	box rose = {w.x1 - std::min(w.width(), at.p.foot), w.y0 - at.p.foot, w.x1, w.y0 - 14 * u};
	rose_draw(at.page, at.rves[0], rose);
	double x1 = rose.x0 - gap * u, inset = std::max(12 * u, 0.5 * (x1 - w.x0 - 560 * u));
	scale_bar_lying(at.page, at.scale, w.y0 - 14 * u, w.x0 + inset, x1 - inset);
	double y = draw_words(at, 0, w.x0, w.y0 - 118 * u - 0.5 * at.line(), x1 - w.x0);
	draw_legend_in(at, chains, w.x0, x1, y - 0.2 * at.line());
}

void draw_beside(const rve_page &at, const chains &chains, double wide)
{
	double y = 0, x1 = at.page.width - margin * at.u();
	for (size_t k = 0; k < at.rves.size(); k++) {
		const box &w = at.windows[k];
		double first = w.y0 - 12 * at.u() - 0.5 * at.line();
		draw_column(at, k, k + 1 == at.rves.size());
		draw_words(at, k, w.x0, first, std::min(wide, x1 - w.x0));
		y = first - at.lines(std::min(wide, x1 - w.x0)) * at.line();
	}
	draw_legend_in(at, chains, at.windows[0].x0, at.windows.back().x0 + at.p.total_w, y - 0.2 * at.line());
}

// A page too small for letters: the last RVE alone.
void draw_bare(rve_page &at)
{
	at.p.scale = std::min(at.page.width / at.view_w, at.page.height / at.view_h);
	at.p.w = std::max(1.0, std::floor(at.view_w * at.p.scale)),
	at.p.h = std::max(1.0, std::floor(at.view_h * at.p.scale));
	double x = std::floor(0.5 * (at.page.width - at.p.w)), y = std::floor(0.5 * (at.page.height - at.p.h));
	at.windows.assign(at.rves.size(), {x, y, x + at.p.w, y + at.p.h});
	draw_window(at, at.rves.size() - 1, {at.rves.back().force_reference(), 0.6 * at.rves.back().mean_radius});
}

std::string time_of(const frame_rve &rve) { return rve.point >= 0 || rve.time != 0 ? layout_time(rve.time) : ""; }

// Lays out and draws one RVE, or two side by side.
void draw_page(rve_page &at, const frame_view &frame, const frame_image &image)
{
	double u = at.u(), between = 30 * u, n = double(at.rves.size());
	if (u < bare_below) {
		draw_bare(at);
		return;
	}
	double left = margin * u, width = at.page.width - 2 * left, wide = (width - (n - 1) * between) / n;
	double labels = at.pair() ? at.line() + 6 * u : 0;
	double top = at.page.height - margin * u - std::max(heading * u, at.line()) - labels;
	at.p = plan_make(at, wide, top - margin * u);

	// the block of everything stands in the middle of the page
	double block = n * at.p.total_w + (n - 1) * between, spare = std::max(0.0, top - margin * u - at.p.total_h);
	double x0 = std::max(left, 0.5 * (at.page.width - block)), y1 = std::round(top - 0.5 * spare);
	chains chains = {0, 0.6 * at.rves[0].mean_radius};
	for (size_t k = 0; k < at.rves.size(); k++) {
		double x = std::round(x0 + double(k) * (at.p.total_w + between));
		at.windows.push_back({x, y1 - at.p.h, x + at.p.w, y1});
		chains.reference = std::max(chains.reference, at.rves[k].force_reference());
	}
	for (size_t k = 0; k < at.rves.size(); k++) {
		draw_window(at, k, chains);
		if (at.pair())
			at.page.text((k == 0 ? "before   " : "after   ") + time_of(at.rves[k].whole), at.windows[k].x0, y1 + 8 * u,
						 letters, align::low, align::low);
	}
	if (at.p.beside)
		draw_beside(at, chains, wide);
	else
		draw_strip(at, chains);
	layout where = {};
	where.group = {at.windows[0].x0, 0, at.windows.back().x0 + at.p.total_w, y1 + labels};
	layout_heading(at.page, where, title_text(frame, image), at.pair() ? "" : time_of(at.rves[0].whole));
}
} // namespace

bool picture_rve(page &page, const frame_view &frame, const frame_image &image, std::string &error)
{
	std::vector<rve_scene> rves;
	std::vector<double> values;
	for (const char *name : {image.before, image.rve}) {
		rve_scene rve;
		if (!*name)
			continue;
		if (!rve.read(frame, image, name, error))
			return false;
		for (const disc &d : rve.discs)
			values.push_back(d.value);
		rves.push_back(std::move(rve));
	}
	if (rves.empty()) {
		error = "the image names no RVE";
		return false;
	}
	colour_scale scale;
	if (!scale_make(image, *rves.back().field, frame.header().temperature_unit, values, scale, error))
		return false;
	scale.wash = discs_wash;
	rve_page at{page, rves, scale};
	for (const rve_scene &rve : rves) {
		box view = rve.view();
		at.words.push_back(state_texts(rve, frame.header().temperature_unit));
		at.view_w = std::max(at.view_w, view.width()), at.view_h = std::max(at.view_h, view.height());
	}
	draw_page(at, frame, image);
	return true;
}
