#include "rose.h"

#include <algorithm>
#include <cmath>

#include "layout.h"
#include "text.h"

namespace
{
constexpr double pi = 3.14159265358979323846;
constexpr int sectors = 36;     // of the whole circle; opposite ones are equal
constexpr double letters = 15;  // page units
constexpr double reach = 0.97;  // of the box: the stress cross
constexpr double largest = 0.8; // of the box: the longest sector

struct bins {
	double all[sectors] = {}, strong[sectors] = {};
	double most = 0;
	int count = 0;
};

// Contacts that carry force, by direction; strong ones carry more than the mean.
bins count_normals(const rve_scene &rve)
{
	bins made;
	double sum = 0;
	for (const contact &c : rve.contacts)
		if (c.touching())
			sum += std::fabs(c.force), made.count++;
	for (const contact &c : rve.contacts) {
		if (!c.touching())
			continue;
		double angle = std::atan2(c.b[1] - c.a[1], c.b[0] - c.a[0]) + 2 * pi;
		int k = int(std::floor(angle / (2 * pi) * sectors)) % sectors;
		for (int side : {k, (k + sectors / 2) % sectors}) {
			made.all[side]++;
			made.strong[side] += std::fabs(c.force) > sum / made.count;
		}
	}
	for (double n : made.all)
		made.most = std::max(made.most, n);
	return made;
}

void sector(shapes &to, double x, double y, double r, int k, const rgb &colour)
{
	constexpr int steps = 4;
	double p[steps + 2][2] = {{x, y}};
	for (int i = 0; i <= steps; i++) {
		double angle = 2 * pi * (k + double(i) / steps) / sectors;
		p[i + 1][0] = x + r * std::cos(angle), p[i + 1][1] = y + r * std::sin(angle);
	}
	if (r > 0)
		to.polygon(p, steps + 2, colour);
}

// r(angle) all around.
template <class radius> void curve(shapes &to, double x, double y, radius r, const rgb &colour)
{
	constexpr int n = 90;
	double p[n][2];
	for (int i = 0; i < n; i++) {
		double angle = 2 * pi * i / n;
		p[i][0] = x + r(angle) * std::cos(angle), p[i][1] = y + r(angle) * std::sin(angle);
	}
	to.line(p, n, true, colour);
}

void axis(shapes &to, double x, double y, double r, double angle, double width, const rgb &colour)
{
	double a[2] = {x - r * std::cos(angle), y - r * std::sin(angle)};
	double b[2] = {x + r * std::cos(angle), y + r * std::sin(angle)};
	to.band(a, b, width, colour);
}

rgb stress_colour(double stress) { return stress > 0 ? ink::tension : ink::cell; }

std::string degrees(double angle)
{
	double shown = std::fmod(angle * 180 / pi + 360, 180);
	return number_text(std::round(shown) == 180 ? 0 : shown, "%.0f") + "\u00b0";
}

// A line of words behind a stroke of the colour that it explains.
void caption(page &page, const box &where, double y, const rgb &colour, const std::string &text)
{
	double u = page.unit, stroke = 18 * u, gap = 7 * u;
	double width = page.text_width(text, letters), x = 0.5 * (where.x0 + where.x1 - width - stroke - gap);
	if (x < where.x0 - 1)
		return;
	shapes mark;
	mark.rectangle({x, y - 1.6 * u, x + stroke, y + 1.6 * u}, colour);
	page.draw(mark);
	page.text(text, x + stroke + gap, y, letters, align::low, align::middle);
}
} // namespace

void rose_draw(page &page, const rve_scene &rve, const box &where)
{
	double u = page.unit, line = text_line(page, letters), title = line + 4 * u;
	double size = 0.5 * std::min(where.width(), where.height() - title - 2 * line);
	if (size < 22)
		return;
	double x = 0.5 * (where.x0 + where.x1), y = where.y1 - title - size;
	bins normals = count_normals(rve);
	double scale = normals.most > 0 ? largest * size / normals.most : 0;
	shapes weak, strong, ring, fabric, cross;
	for (int k = 0; k < sectors; k++) {
		sector(weak, x, y, scale * normals.all[k], k, {0.78, 0.81, 0.86});
		sector(strong, x, y, scale * normals.strong[k], k, {0.42, 0.46, 0.54});
	}
	curve(
		ring, x, y, [&](double) { return largest * size; }, ink::frame);
	const double *f = rve.whole.fabric;
	tensor_axes contacts = tensor_axes_of(f[0], f[1], f[2]),
				stress = tensor_axes_of(rve.whole.stress[0], rve.whole.stress[1], rve.whole.stress[3]);
	// E = (1 + a cos 2 (angle - of the larger)) / 2 pi, drawn where the mean of the sectors lies
	double a = 2 * (contacts.large - contacts.small), mean = scale * 2 * normals.count / sectors;
	if (normals.count > 0)
		curve(
			fabric, x, y, [&](double angle) { return mean * (1 + a * std::cos(2 * (angle - contacts.angle))); },
			ink::fabric);
	// the principal stresses to scale; the most compressive stands across the largest
	double full = std::max(std::fabs(stress.large), std::fabs(stress.small));
	if (full > 0) {
		axis(cross, x, y, reach * size * std::fabs(stress.small) / full, stress.angle + 0.5 * pi, 3.2 * u,
			 stress_colour(stress.small));
		axis(cross, x, y, reach * size * std::fabs(stress.large) / full, stress.angle, 3.2 * u,
			 stress_colour(stress.large));
	}
	page.draw(weak);
	page.draw(strong);
	page.draw(ring, 1);
	page.draw(cross);
	page.draw(fabric, 2.4);
	std::string count = std::to_string(normals.count) + " contacts";
	for (const std::string &head : {normals.count > 0 ? count + ", dark: strong" : "no contacts", count})
		if (page.text_width(head, letters) < where.width()) {
			page.text(head, x, where.y1, letters, align::middle, align::high);
			break;
		}
	if (full > 0) {
		char unit[TICKS_UNIT];
		double factor = ticks_unit("Pa", full, unit), major = stress.small, minor = stress.large;
		bool pulled = std::fabs(minor) > std::fabs(major);
		if (pulled)
			std::swap(major, minor);
		caption(page, where, y - size - 0.6 * line, stress_colour(major),
				number_text(major * factor, "%.3g") + ", " + number_text(minor * factor, "%.3g") + " " + unit + ", " +
					degrees(stress.angle + (pulled ? 0 : 0.5 * pi)));
	}
	if (normals.count > 0)
		caption(page, where, y - size - 1.6 * line, ink::fabric,
				"fabric " + number_text(a, "%.2f") + ", " + degrees(contacts.angle));
}
