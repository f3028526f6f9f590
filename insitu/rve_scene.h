// One RVE as it is to be drawn: read from its two channels, moved into its cell.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "frame_view.h"
#include "page.h"

// The periodic cell: x = H s, s in [0, 1)^2.
struct cell {
	double H[4], inverse[4];

	bool open(const double matrix[4]);
	std::array<double, 2> place(double a, double b) const { return {H[0] * a + H[1] * b, H[2] * a + H[3] * b}; }
	std::array<double, 2> fraction(double x, double y) const
	{
		return {inverse[0] * x + inverse[1] * y, inverse[2] * x + inverse[3] * y};
	}
	// The shift that brings (x, y) into the cell.
	std::array<double, 2> wrap(double x, double y) const;

	// Calls `visit` with every lattice shift whose copy of the cell can reach into the view; the cell itself comes
	// last, so that it lies on top of its images.
	void for_images(const box &view, const std::function<void(double, double, bool)> &visit) const;
};

struct disc {
	double x, y, radius, value;
};

struct contact {
	double a[2], b[2];
	double force; // N, compression positive
	bool sliding;
	int bond; // 0 none, 1 intact, 2 broken
	bool touching() const { return force != 0 || bond == 1; }
};

struct rve_scene {
	cell shape;
	frame_rve whole;
	const frame_array *field;
	std::vector<disc> discs;
	std::vector<contact> contacts; // the weakest first, so that the chains lie on top
	double mean_radius = 0;

	// RVE `name` with the field that colours its discs; false with a reason in `error`.
	bool read(const frame_view &frame, const frame_image &image, const std::string &name, std::string &error);

	// The cell with some of its surroundings, not more slender than a readable picture.
	box view() const;

	// The force drawn as wide as a band may be: above the bulk, so that single peaks do not thin all others.
	double force_reference() const;
};
