#include "pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>

#include "layout.h"

namespace
{
enum level { LEVEL_SEAMS, LEVEL_DOMAINS, LEVEL_WALLS, LEVEL_WALL_EDGES };

// Grows `b` by the coordinates of a channel.
void include(box &b, const frame_view &frame, int channel)
{
	const frame_array *x = frame.find_array(channel, "coordinates");
	for (int64_t k = 0; x && k < x->count; k++) {
		double p[2] = {frame.value(*x, k, 0), frame.value(*x, k, 1)};
		if (std::isfinite(p[0]) && std::isfinite(p[1]))
			b = {std::min(b.x0, p[0]), std::min(b.y0, p[1]), std::max(b.x1, p[0]), std::max(b.y1, p[1])};
	}
}

// What the image asks to see, else the grid, else all there is.
box view_find(const frame_view &frame, const frame_image &image)
{
	const double *v = image.view;
	if (v[2] > v[0] && v[3] > v[1])
		return {v[0], v[1], v[2], v[3]};
	int grid = frame.find("grid");
	if (grid >= 0) {
		const frame_channel &g = frame.channel(grid);
		return {g.origin[0], g.origin[1], g.origin[0] + (g.dims[0] - 1) * g.spacing[0],
				g.origin[1] + (g.dims[1] - 1) * g.spacing[1]};
	}
	constexpr double far = std::numeric_limits<double>::infinity();
	box all = {far, far, -far, -far};
	for (const char *name : {"domains", "points", "walls"})
		if (frame.find(name) >= 0)
			include(all, frame, frame.find(name));
	if (!(all.x1 > all.x0 && all.y1 > all.y0))
		return {0, 0, 1, 1};
	double margin = 0.02 * std::max(all.width(), all.height());
	return {all.x0 - margin, all.y0 - margin, all.x1 + margin, all.y1 + margin};
}

struct coloured {
	int channel;              // that has the geometry
	const frame_array *array; // with a value for each cell of it
	std::vector<double> values;
};

// The field: an array of "domains", or of "points" shown on the domains (both are in the points' order).
bool field_find(const frame_view &frame, const frame_image &image, coloured &field, std::string &error)
{
	int domains = frame.find("domains"), points = frame.find("points");
	int geometry = domains >= 0 ? domains : points;
	if (geometry < 0) {
		error = "the frame has no points to draw";
		return false;
	}
	for (int channel : {domains, points}) {
		const frame_array *array = channel >= 0 ? frame.find_array(channel, image.field) : nullptr;
		if (array && array->count == frame.channel(geometry).n_cells) {
			field = {geometry, array, scale_values(frame, *array, image.component)};
			return true;
		}
	}
	error = "there is no field \"" + std::string(image.field) + "\"; there are " + frame.names(geometry);
	return false;
}

void draw_domains(page &page, const frame_view &frame, const coloured &field, const colour_scale &scale)
{
	auto data = frame.geometry(field.channel);
	if (!data || data->GetNumberOfCells() != vtkIdType(field.values.size()))
		return;
	vtkNew<vtkDoubleArray> values;
	values->Allocate(vtkIdType(field.values.size()));
	for (double v : field.values)
		values->InsertNextValue(v);
	data->GetCellData()->SetScalars(values);
	vtkNew<vtkPolyDataMapper> mapper;
	mapper->SetInputData(data);
	mapper->SetScalarModeToUseCellData();
	mapper->SetColorModeToMapScalars();
	mapper->SetLookupTable(colour_map_table(*scale.map, scale.low / scale.factor, scale.high / scale.factor));
	mapper->UseLookupTableScalarRangeOn();
	vtkNew<vtkActor> actor;
	actor->SetMapper(mapper);
	actor->GetProperty()->SetPointSize(float(5 * page.unit));
	page.add(actor, LEVEL_DOMAINS);
	// Domains deform each on its own: outlines in their own colours, behind, close the hairlines between them.
	vtkNew<vtkActor> seams;
	seams->SetMapper(mapper);
	seams->GetProperty()->SetRepresentationToWireframe();
	seams->GetProperty()->SetLineWidth(float(std::max(1.0, 2 * page.unit)));
	page.add(seams, LEVEL_SEAMS);
}

// Strokes at 45 degrees on the solid side (the right) of a line, as engineers draw the ground.
void hatch(shapes &strokes, const double a[2], const double b[2], double spacing, double length)
{
	double dx = b[0] - a[0], dy = b[1] - a[1], l = std::hypot(dx, dy);
	if (!(l > 0))
		return;
	double t[2] = {dx / l, dy / l}, n[2] = {t[1], -t[0]};
	for (double s = 0.5 * spacing; s < l; s += spacing) {
		double from[2] = {a[0] + s * t[0], a[1] + s * t[1]};
		double stroke[2][2] = {{from[0], from[1]},
							   {from[0] + 0.7 * length * (n[0] - t[0]), from[1] + 0.7 * length * (n[1] - t[1])}};
		strokes.line(stroke, 2, false, ink::wall_edge);
	}
}

// Leaves the corners of an outline: walls come with points along their faces.
void drop_straight(std::vector<std::array<double, 2>> &p, bool closed)
{
	std::vector<std::array<double, 2>> corners;
	for (size_t i = 0; i < p.size(); i++) {
		const auto &before = corners.empty() ? p.back() : corners.back(), &after = p[(i + 1) % p.size()];
		double ax = p[i][0] - before[0], ay = p[i][1] - before[1], bx = after[0] - p[i][0], by = after[1] - p[i][1];
		bool end = !closed && (i == 0 || i + 1 == p.size());
		bool straight =
			std::fabs(ax * by - ay * bx) <= 1e-9 * std::hypot(ax, ay) * std::hypot(bx, by) && ax * bx + ay * by > 0;
		if (end || !straight)
			corners.push_back(p[i]);
	}
	p = corners;
}

// Channel "walls": polygons (array "closed", or last corner = first) are solid; open lines are the surface of a
// solid on their right.
void draw_walls(page &page, const frame_view &frame)
{
	int c = frame.find("walls");
	const frame_array *x = c >= 0 ? frame.find_array(c, "coordinates") : nullptr;
	const frame_array *offsets = c >= 0 ? frame.find_array(c, "offsets") : nullptr;
	if (!x || !offsets)
		return;
	const frame_array *closed = frame.find_array(c, "closed"), *active = frame.find_array(c, "active");
	double pixel = page.metres_per_pixel(), u = page.unit;
	shapes solids, edges, strokes;
	for (int64_t k = 0; k + 1 < offsets->count; k++) {
		int64_t from = int64_t(frame.value(*offsets, k)), to = int64_t(frame.value(*offsets, k + 1));
		bool here = !active || k >= active->count || frame.value(*active, k) != 0;
		if (!here || from < 0 || to > x->count || to - from < 2)
			continue;
		std::vector<std::array<double, 2>> p;
		for (int64_t i = from; i < to; i++)
			p.push_back({frame.value(*x, i, 0), frame.value(*x, i, 1)});
		bool round = p.size() > 3 && p.front() == p.back();
		if (round)
			p.pop_back();
		bool solid = round || (closed && k < closed->count && frame.value(*closed, k) != 0 && p.size() >= 3);
		drop_straight(p, solid);
		auto corners = reinterpret_cast<const double(*)[2]>(p.data());
		edges.line(corners, int(p.size()), solid, ink::wall_edge);
		if (solid)
			solids.polygon(corners, int(p.size()), ink::wall);
		for (size_t i = 0; !solid && i + 1 < p.size(); i++)
			hatch(strokes, corners[i], corners[i + 1], 10 * u * pixel, 11 * u * pixel);
	}
	page.draw_world(solids, LEVEL_WALLS, 1, true);
	page.draw_world(strokes, LEVEL_WALLS, 1);
	page.draw_world(edges, LEVEL_WALL_EDGES, 2);
}
} // namespace

bool picture_points(page &page, const frame_view &frame, const frame_image &image, std::string &error)
{
	coloured field;
	colour_scale scale;
	if (!field_find(frame, image, field, error) ||
		!scale_make(image, *field.array, frame.header().temperature_unit, field.values, scale, error))
		return false;
	constexpr double foot = 44;
	layout where = layout_make(page, view_find(frame, image), scale, foot);
	draw_domains(page, frame, field, scale);
	draw_walls(page, frame);
	layout_frame(page, where);
	layout_bar(page, where, scale);
	layout_heading(page, where, frame.header().title, layout_time(frame.header().time));
	length_scale_draw(page, length_scale_make(page, where), where.window.x0 + 1,
					  where.group.y0 - 0.5 * foot * page.unit);
	return true;
}
