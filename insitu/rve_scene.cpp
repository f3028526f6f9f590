#include "rve_scene.h"

#include <algorithm>
#include <cmath>

#include "scale.h"

namespace
{
constexpr double aspect_most = 3; // of the window; a slender cell is shown in more of its surroundings

bool read_discs(const frame_view &frame, const frame_image &image, int channel, rve_scene &rve, std::string &error)
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
void read_contacts(const frame_view &frame, int channel, rve_scene &rve)
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

} // namespace

bool cell::open(const double matrix[4])
{
	double det = matrix[0] * matrix[3] - matrix[1] * matrix[2];
	std::copy(matrix, matrix + 4, H);
	if (!(std::fabs(det) > 0) || !std::isfinite(det))
		return false;
	double m[4] = {matrix[3] / det, -matrix[1] / det, -matrix[2] / det, matrix[0] / det};
	std::copy(m, m + 4, inverse);
	return true;
}

std::array<double, 2> cell::wrap(double x, double y) const
{
	auto s = fraction(x, y);
	return place(-std::floor(s[0]), -std::floor(s[1]));
}

void cell::for_images(const box &view, const std::function<void(double, double, bool)> &visit) const
{
	double low[2] = {0, 0}, high[2] = {0, 0};
	for (int k = 0; k < 4; k++) {
		auto s = fraction(k & 1 ? view.x0 : view.x1, k & 2 ? view.y0 : view.y1);
		for (size_t d = 0; d < 2; d++)
			low[d] = std::min(low[d], s[d]), high[d] = std::max(high[d], s[d]);
	}
	for (double i = std::floor(low[0]) - 1; i <= std::ceil(high[0]); i++)
		for (double j = std::floor(low[1]) - 1; j <= std::ceil(high[1]); j++) {
			auto shift = place(i, j);
			if (i != 0 || j != 0)
				visit(shift[0], shift[1], false);
		}
	visit(0, 0, true);
}

bool rve_scene::read(const frame_view &frame, const frame_image &image, const std::string &name, std::string &error)
{
	std::string prefix = "rve_" + name;
	int channel = frame.find(prefix + "_discs");
	if (channel < 0) {
		error = "the frame has no RVE \"" + name + "\"";
		return false;
	}
	whole = frame.channel(channel).rve;
	if (!read_discs(frame, image, channel, *this, error))
		return false;
	read_contacts(frame, frame.find(prefix + "_contacts"), *this);
	return true;
}

box rve_scene::view() const
{
	box b = {0, 0, 0, 0};
	for (int k = 1; k < 4; k++) {
		auto p = shape.place(k & 1, k >> 1);
		b = {std::min(b.x0, p[0]), std::min(b.y0, p[1]), std::max(b.x1, p[0]), std::max(b.y1, p[1])};
	}
	double pad = std::max(2.2 * mean_radius, 0.05 * std::max(b.width(), b.height()));
	b = {b.x0 - pad, b.y0 - pad, b.x1 + pad, b.y1 + pad};
	double more_x = std::max(0.0, b.height() / aspect_most - b.width()) / 2;
	double more_y = std::max(0.0, b.width() / aspect_most - b.height()) / 2;
	return {b.x0 - more_x, b.y0 - more_y, b.x1 + more_x, b.y1 + more_y};
}

double rve_scene::force_reference() const
{
	if (contacts.empty())
		return 1;
	double force = std::fabs(contacts[size_t(0.98 * double(contacts.size() - 1))].force);
	return force > 0 ? force : 1;
}
