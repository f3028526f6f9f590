#include "pictures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "base/ticks.h"
#include "layout.h"

namespace
{
enum level { LEVEL_DISCS, LEVEL_RIMS, LEVEL_CASING, LEVEL_CHAINS, LEVEL_BONDS, LEVEL_CELL };

constexpr double surroundings_fade = 0.66; // how far the periodic images go towards white
constexpr double aspect_most = 3;          // of the window; a slender cell is shown in more of its surroundings
constexpr double letters = 17, swatch = 26, legend_gap = 20; // page units
constexpr double pi = 3.14159265358979323846;

// The periodic cell: x = H s, s in [0, 1)^2.
struct cell {
	double H[4], inverse[4];

	bool open(const double matrix[4])
	{
		double det = matrix[0] * matrix[3] - matrix[1] * matrix[2];
		std::copy(matrix, matrix + 4, H);
		if (!(std::fabs(det) > 0) || !std::isfinite(det))
			return false;
		double m[4] = {matrix[3] / det, -matrix[1] / det, -matrix[2] / det, matrix[0] / det};
		std::copy(m, m + 4, inverse);
		return true;
	}
	std::array<double, 2> place(double a, double b) const { return {H[0] * a + H[1] * b, H[2] * a + H[3] * b}; }
	std::array<double, 2> fraction(double x, double y) const
	{
		return {inverse[0] * x + inverse[1] * y, inverse[2] * x + inverse[3] * y};
	}
	// The shift that brings (x, y) into the cell.
	std::array<double, 2> wrap(double x, double y) const
	{
		auto s = fraction(x, y);
		return place(-std::floor(s[0]), -std::floor(s[1]));
	}
};

struct disc {
	double x, y, radius, value;
};

struct contact {
	double a[2], b[2];
	double force; // N, compression positive
	bool sliding;
	int bond; // 0 none, 1 intact, 2 broken
};

struct rve {
	cell shape;
	const frame_array *field;
	std::vector<disc> discs;
	std::vector<contact> contacts;
	double mean_radius = 0;
};

bool read_discs(const frame_view &frame, const frame_image &image, int channel, rve &rve, std::string &error)
{
	const frame_array *x = frame.find_array(channel, "coordinates"), *radius = frame.find_array(channel, "radius");
	rve.field = frame.find_array(channel, image.field);
	if (!rve.field) {
		error = "there is no field \"" + std::string(image.field) + "\"; there are " + frame.names(channel);
		return false;
	}
	if (!x || !radius || x->count != radius->count || x->count != rve.field->count || x->count == 0 ||
		!rve.shape.open(frame.channel(channel).cell_matrix)) {
		error = "the RVE's frame has no discs, radii or cell";
		return false;
	}
	std::vector<double> values = scale_values(frame, *rve.field, image.component);
	for (int64_t k = 0; k < x->count; k++) {
		disc d = {frame.value(*x, k, 0), frame.value(*x, k, 1), frame.value(*radius, k), values[size_t(k)]};
		auto shift = rve.shape.wrap(d.x, d.y);
		d.x += shift[0], d.y += shift[1];
		rve.discs.push_back(d);
		rve.mean_radius += d.radius / double(x->count);
	}
	return true;
}

// The contacts, each moved so that its middle lies in the cell; the weakest first, so that the chains lie on top.
// Copies for other viewers (array "image") are left out: all images are made here.
void read_contacts(const frame_view &frame, int channel, rve &rve)
{
	const frame_array *x = channel >= 0 ? frame.find_array(channel, "coordinates") : nullptr;
	const frame_array *force = channel >= 0 ? frame.find_array(channel, "normal_force") : nullptr;
	if (!x || !force || x->count != 2 * force->count)
		return;
	const frame_array *sliding = frame.find_array(channel, "sliding"), *bond = frame.find_array(channel, "bond");
	const frame_array *image = frame.find_array(channel, "image");
	auto flag = [&](const frame_array *array, int64_t k) {
		return array && k < array->count ? int(frame.value(*array, k)) : 0;
	};
	for (int64_t k = 0; k < force->count; k++) {
		if (flag(image, k) != 0)
			continue;
		contact c;
		for (int d = 0; d < 2; d++) {
			c.a[d] = frame.value(*x, 2 * k, d);
			c.b[d] = frame.value(*x, 2 * k + 1, d);
		}
		auto shift = rve.shape.wrap(0.5 * (c.a[0] + c.b[0]), 0.5 * (c.a[1] + c.b[1]));
		for (int d = 0; d < 2; d++)
			c.a[d] += shift[size_t(d)], c.b[d] += shift[size_t(d)];
		c.force = frame.value(*force, k);
		c.sliding = flag(sliding, k) != 0;
		c.bond = flag(bond, k);
		if (std::isfinite(c.force))
			rve.contacts.push_back(c);
	}
	std::stable_sort(rve.contacts.begin(), rve.contacts.end(),
					 [](const contact &a, const contact &b) { return std::fabs(a.force) < std::fabs(b.force); });
}

// The cell with some of its surroundings, not more slender than aspect_most.
box view_of(const rve &rve)
{
	box b = {0, 0, 0, 0};
	for (int k = 1; k < 4; k++) {
		auto p = rve.shape.place(k & 1, k >> 1);
		b = {std::min(b.x0, p[0]), std::min(b.y0, p[1]), std::max(b.x1, p[0]), std::max(b.y1, p[1])};
	}
	double pad = std::max(2.2 * rve.mean_radius, 0.05 * std::max(b.width(), b.height()));
	b = {b.x0 - pad, b.y0 - pad, b.x1 + pad, b.y1 + pad};
	double more_x = std::max(0.0, b.height() / aspect_most - b.width()) / 2;
	double more_y = std::max(0.0, b.width() / aspect_most - b.height()) / 2;
	return {b.x0 - more_x, b.y0 - more_y, b.x1 + more_x, b.y1 + more_y};
}

// Calls `visit` with every lattice shift whose copy of the cell can reach into the view; the cell itself comes
// last, so that it lies on top of its images.
void for_images(const cell &shape, const box &view, const std::function<void(double, double, bool)> &visit)
{
	double low[2] = {0, 0}, high[2] = {0, 0};
	for (int k = 0; k < 4; k++) {
		auto s = shape.fraction(k & 1 ? view.x0 : view.x1, k & 2 ? view.y0 : view.y1);
		for (size_t d = 0; d < 2; d++)
			low[d] = std::min(low[d], s[d]), high[d] = std::max(high[d], s[d]);
	}
	for (double i = std::floor(low[0]) - 1; i <= std::ceil(high[0]); i++)
		for (double j = std::floor(low[1]) - 1; j <= std::ceil(high[1]); j++) {
			auto shift = shape.place(i, j);
			if (i != 0 || j != 0)
				visit(shift[0], shift[1], false);
		}
	visit(0, 0, true);
}

bool inside(const box &b, double x, double y, double reach)
{
	return x > b.x0 - reach && x < b.x1 + reach && y > b.y0 - reach && y < b.y1 + reach;
}

void draw_discs(page &page, const rve &rve, const colour_scale &scale, const box &view)
{
	shapes bodies, rims;
	double largest = 0;
	for (const disc &d : rve.discs)
		largest = std::max(largest, d.radius / page.metres_per_pixel());
	int sides = int(std::clamp(10 + 1.5 * largest, 12.0, 64.0));
	std::vector<std::array<double, 2>> circle{size_t(sides)};
	for_images(rve.shape, view, [&](double dx, double dy, bool own) {
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
			rims.line(p, sides, true, colour_mix(colour_mix(colour, ink::text, 0.6), white, fade));
		}
	});
	page.draw_world(bodies, LEVEL_DISCS);
	if (largest > 4)
		page.draw_world(rims, LEVEL_RIMS, 1);
}

// The force drawn as wide as a band may be: above the bulk, so that single peaks do not thin all others.
double force_reference(const rve &rve)
{
	if (rve.contacts.empty())
		return 1;
	double force = std::fabs(rve.contacts[size_t(0.98 * double(rve.contacts.size() - 1))].force);
	return force > 0 ? force : 1;
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

void draw_contacts(page &page, const rve &rve, const chains &chains, const box &view)
{
	shapes casing, bands, bonds, bond_rims;
	double pixel = page.metres_per_pixel() * page.unit;
	for_images(rve.shape, view, [&](double dx, double dy, bool own) {
		double fade = own ? 0 : surroundings_fade;
		for (const contact &c : rve.contacts) {
			double a[2] = {c.a[0] + dx, c.a[1] + dy}, b[2] = {c.b[0] + dx, c.b[1] + dy};
			double middle[2] = {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])};
			if (!inside(view, middle[0], middle[1], 2.5 * rve.mean_radius))
				continue;
			double w = std::max(chains.width(c.force), (c.sliding ? 1.4 : 0.7) * pixel);
			rgb white = {1, 1, 1};
			if (w > 1.3 * pixel)
				casing.band(a, b, w + 1.6 * pixel, white, own ? 0.75 : 0.5);
			bands.band(a, b, w, colour_mix(contact_colour(c), white, fade));
			if (c.bond == 0)
				continue;
			// Cement: a short bar across the contact.
			double tx = -(b[1] - a[1]), ty = b[0] - a[0], l = std::hypot(tx, ty), s = 0.42 * rve.mean_radius;
			double from[2] = {middle[0] - s * tx / l, middle[1] - s * ty / l};
			double to[2] = {middle[0] + s * tx / l, middle[1] + s * ty / l};
			bond_rims.band(from, to, 0.30 * rve.mean_radius + 2.4 * pixel, colour_mix(ink::compression, white, fade));
			bonds.band(from, to, 0.30 * rve.mean_radius,
					   c.bond == 1 ? ink::bond : colour_mix(ink::broken, white, fade));
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
	page.draw_world(under, LEVEL_CELL + 1, 5);
	page.draw_world(outline, LEVEL_CELL + 2, 2.6);
}

// ---- legend ----

struct legend_item {
	std::string text;
	std::function<void(page &, double x, double y)> sign;
	double width; // of the sign, pixels
};

std::vector<legend_item> legend_items(const page &page, const rve &rve, const chains &chains)
{
	double u = page.unit, pixel = page.metres_per_pixel();
	std::vector<legend_item> items;
	auto line_item = [&](const std::string &text, rgb colour, double thick) {
		items.push_back({text,
						 [=](class page &page, double x, double y) {
							 shapes s;
							 s.rectangle({x, y - 0.5 * thick, x + swatch * u, y + 0.5 * thick}, colour);
							 page.draw(s);
						 },
						 swatch * u});
	};
	auto bond_item = [&](const std::string &text, rgb colour) {
		items.push_back({text,
						 [=](class page &page, double x, double y) {
							 shapes s;
							 s.rectangle({x, y - 8 * u, x + 7 * u, y + 8 * u}, ink::compression);
							 s.rectangle({x + 1.3 * u, y - 6.7 * u, x + 5.7 * u, y + 6.7 * u}, colour);
							 page.draw(s);
						 },
						 7 * u});
	};
	bool any[5] = {};
	for (const contact &c : rve.contacts) {
		any[c.sliding ? 2 : c.force < 0 ? 1 : 0] = true;
		any[3] |= c.bond == 1, any[4] |= c.bond == 2;
	}
	if (rve.contacts.empty())
		return items;
	double step = ticks_step(chains.reference, 1);
	double shown = step > chains.reference * 1.2 ? ticks_step(0.4 * chains.reference, 1) : step;
	char unit[TICKS_UNIT], text[96];
	double factor = ticks_unit("N", shown * 1.0001, unit);
	snprintf(text, sizeof text, "force %g %s", shown * factor, unit);
	line_item(text, ink::compression, std::max(1.0, chains.width(shown) / pixel));
	if (any[1])
		line_item("tension", ink::tension, 5 * u);
	if (any[2])
		line_item("sliding", ink::sliding, 5 * u);
	if (any[3])
		bond_item("bond", ink::bond);
	if (any[4])
		bond_item("broken bond", ink::broken);
	return items;
}

// Length scale on the left, signs and words on the right, in one row; it may be wider than the group above.
void draw_legend(page &page, const layout &where, const std::vector<legend_item> &items, double y)
{
	double u = page.unit, width = 0, edge = 22 * u;
	for (const legend_item &item : items)
		width += legend_gap * u + item.width + 8 * u + page.text_width(item.text, letters);
	length_scale length = length_scale_make(page, where);
	double x0 = std::max(edge, std::min(where.window.x0 + 1, page.width - edge - length.width - width));
	length_scale_draw(page, length, x0, y);
	double x = std::max(x0 + length.width, where.group.x1 - width);
	for (const legend_item &item : items) {
		x += legend_gap * u;
		item.sign(page, x, y);
		x += item.width + 8 * u;
		page.text(item.text, x, y, letters, align::low, align::middle);
		x += page.text_width(item.text, letters);
	}
}
} // namespace

bool picture_rve(page &page, const frame_view &frame, const frame_image &image, std::string &error)
{
	std::string prefix = "rve_" + std::string(image.rve);
	int discs = frame.find(prefix + "_discs");
	if (discs < 0) {
		error = "the frame has no RVE \"" + std::string(image.rve) + "\"";
		return false;
	}
	rve rve;
	colour_scale scale;
	if (!read_discs(frame, image, discs, rve, error))
		return false;
	read_contacts(frame, frame.find(prefix + "_contacts"), rve);
	std::vector<double> values;
	for (const disc &d : rve.discs)
		values.push_back(d.value);
	if (!scale_make(image, *rve.field, frame.header().temperature_unit, values, scale, error))
		return false;

	const double foot = 78;
	box view = view_of(rve);
	layout where = layout_make(page, view, scale, foot);
	chains chains = {force_reference(rve), 0.6 * rve.mean_radius};
	draw_discs(page, rve, scale, view);
	draw_contacts(page, rve, chains, view);
	draw_cell(page, rve.shape);
	layout_frame(page, where);
	layout_bar(page, where, scale);
	std::string title = "RVE " + std::string(image.rve);
	if (frame.header().title[0])
		title += " \u2013 " + std::string(frame.header().title);
	layout_heading(page, where, title, frame.header().time);
	draw_legend(page, where, legend_items(page, rve, chains), where.group.y0 - 24 * page.unit);
	layout_note(page, where, frame.channel(discs).note, 60);
	return true;
}
