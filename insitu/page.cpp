#include "page.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <unistd.h>

#include <vtkActor2D.h>
#include <vtkCamera.h>
#include <vtkCellData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty.h>
#include <vtkProperty2D.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>
#include <vtkTriangleFilter.h>

// ---- shapes ----

shapes::shapes()
	: points(vtkSmartPointer<vtkPoints>::New()), polys(vtkSmartPointer<vtkCellArray>::New()),
	  lines(vtkSmartPointer<vtkCellArray>::New()), line_colours(vtkSmartPointer<vtkUnsignedCharArray>::New()),
	  poly_colours(vtkSmartPointer<vtkUnsignedCharArray>::New())
{
	points->SetDataTypeToDouble();
	line_colours->SetNumberOfComponents(4);
	poly_colours->SetNumberOfComponents(4);
}

vtkIdType shapes::add(const double (*p)[2], int n)
{
	vtkIdType first = points->GetNumberOfPoints();
	for (int k = 0; k < n; k++)
		points->InsertNextPoint(p[k][0], p[k][1], 0);
	return first;
}

void shapes::paint(vtkUnsignedCharArray *colours, const rgb &colour, double opacity)
{
	unsigned char c[4];
	for (int k = 0; k < 3; k++)
		c[k] = static_cast<unsigned char>(std::lround(255 * std::clamp(colour[k], 0.0, 1.0)));
	c[3] = static_cast<unsigned char>(std::lround(255 * opacity));
	colours->InsertNextTypedTuple(c);
}

void shapes::polygon(const double (*p)[2], int n, const rgb &colour, double opacity)
{
	vtkIdType first = add(p, n);
	polys->InsertNextCell(n);
	for (int k = 0; k < n; k++)
		polys->InsertCellPoint(first + k);
	paint(poly_colours, colour, opacity);
}

void shapes::line(const double (*p)[2], int n, bool closed, const rgb &colour, double opacity)
{
	vtkIdType first = add(p, n);
	lines->InsertNextCell(n + closed);
	for (int k = 0; k < n; k++)
		lines->InsertCellPoint(first + k);
	if (closed)
		lines->InsertCellPoint(first);
	paint(line_colours, colour, opacity);
}

void shapes::band(const double a[2], const double b[2], double w, const rgb &colour, double opacity)
{
	double dx = b[0] - a[0], dy = b[1] - a[1], length = std::hypot(dx, dy);
	if (length <= 0)
		return;
	double nx = -0.5 * w * dy / length, ny = 0.5 * w * dx / length;
	double p[4][2] = {{a[0] + nx, a[1] + ny}, {a[0] - nx, a[1] - ny}, {b[0] - nx, b[1] - ny}, {b[0] + nx, b[1] + ny}};
	polygon(p, 4, colour, opacity);
}

void shapes::rectangle(const box &b, const rgb &colour, double opacity)
{
	double p[4][2] = {{b.x0, b.y0}, {b.x1, b.y0}, {b.x1, b.y1}, {b.x0, b.y1}};
	polygon(p, 4, colour, opacity);
}

vtkSmartPointer<vtkPolyData> shapes::data(bool concave) const
{
	auto data = vtkSmartPointer<vtkPolyData>::New();
	data->SetPoints(points);
	data->SetLines(lines);
	data->SetPolys(polys);
	auto colours = vtkSmartPointer<vtkUnsignedCharArray>::New(); // VTK's order of cells: lines, then polygons
	colours->DeepCopy(line_colours);
	colours->InsertTuples(colours->GetNumberOfTuples(), poly_colours->GetNumberOfTuples(), 0, poly_colours);
	colours->SetName("colour");
	data->GetCellData()->SetScalars(colours);
	if (!concave)
		return data;
	vtkNew<vtkTriangleFilter> filter;
	filter->PassLinesOn();
	filter->SetInputData(data);
	filter->Update();
	return filter->GetOutput();
}

// ---- page ----

page::page(int w, int h)
	: width(w), height(h), unit(std::min(double(w), 1.25 * h) / 1000),
	  sheet_renderer(vtkSmartPointer<vtkRenderer>::New())
{
	sheet_renderer->SetBackground(1, 1, 1);
	sheet_renderer->SetLayer(0);
}

// VTK's own letters lack Greek and brackets in Debian's build; these come with Debian's fonts and matplotlib.
static const char *font_file(bool bold)
{
	static const char *const places[2][3] = {
		{"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/dejavu/DejaVuSans.ttf",
		 "/usr/share/matplotlib/mpl-data/fonts/ttf/DejaVuSans.ttf"},
		{"/usr/share/fonts/truetype/dejavu/DejaVuSans-Bold.ttf", "/usr/share/fonts/dejavu/DejaVuSans-Bold.ttf",
		 "/usr/share/matplotlib/mpl-data/fonts/ttf/DejaVuSans-Bold.ttf"}};
	const char *asked = getenv("TMDEMPM_FONT"); // a TrueType file; what cannot be read gives VTK's own letters
	if (asked && *asked)
		return access(asked, R_OK) == 0 ? asked : nullptr;
	for (const char *place : places[bold])
		if (access(place, R_OK) == 0)
			return place;
	return nullptr;
}

static void set_style(vtkTextProperty *style, double size, bool bold, const rgb &colour)
{
	if (const char *file = font_file(bold)) {
		style->SetFontFamily(VTK_FONT_FILE);
		style->SetFontFile(file);
	} else {
		style->SetFontFamilyToArial();
		style->SetBold(bold);
	}
	style->SetFontSize(std::max(8, int(std::lround(size))));
	style->SetColor(colour[0], colour[1], colour[2]);
}

bool page::greek() { return font_file(false) != nullptr; }

double page::text_width(const std::string &text, double size, bool bold) const
{
	vtkNew<vtkTextProperty> style;
	set_style(style, size * unit, bold, ink::text);
	int b[4] = {0, 0, 0, 0};
	vtkTextRenderer::GetInstance()->GetBoundingBox(style, text, b, 72);
	return b[1] - b[0];
}

void page::text(const std::string &text, double x, double y, double size, align across, align up, const rgb &colour,
				bool bold, bool turned)
{
	if (text.empty())
		return;
	vtkNew<vtkTextActor> actor;
	vtkTextProperty *style = actor->GetTextProperty();
	set_style(style, size * unit, bold, colour);
	actor->SetInput(text.c_str());
	// VTK justifies in the text's own frame: turned, its foot points to the right of the page.
	static const int along[] = {VTK_TEXT_LEFT, VTK_TEXT_CENTERED, VTK_TEXT_RIGHT};
	static const int height[] = {VTK_TEXT_BOTTOM, VTK_TEXT_CENTERED, VTK_TEXT_TOP};
	static const int turned_height[] = {VTK_TEXT_TOP, VTK_TEXT_CENTERED, VTK_TEXT_BOTTOM};
	style->SetJustification(along[int(turned ? up : across)]);
	style->SetVerticalJustification(turned ? turned_height[int(across)] : height[int(up)]);
	style->SetOrientation(turned ? 90 : 0);
	actor->GetPositionCoordinate()->SetCoordinateSystemToDisplay();
	actor->SetPosition(std::round(x), std::round(y));
	sheet_renderer->AddActor2D(actor);
}

void page::draw(const shapes &what, double line_width)
{
	if (what.empty())
		return;
	vtkNew<vtkPolyDataMapper2D> mapper;
	mapper->SetInputData(what.data());
	mapper->SetScalarModeToUseCellData();
	vtkNew<vtkActor2D> actor;
	actor->SetMapper(mapper);
	actor->GetProperty()->SetLineWidth(float(line_width * unit));
	sheet_renderer->AddActor2D(actor);
}

void page::look(const box &view, const box &where)
{
	scale = view.width() / where.width();
	depth = std::max(view.width(), view.height());
	auto world_renderer = vtkSmartPointer<vtkRenderer>::New();
	world_renderers.push_back(world_renderer);
	world_renderer->SetLayer(1);
	world_renderer->InteractiveOff();
	world_renderer->SetViewport(where.x0 / width, where.y0 / height, where.x1 / width, where.y1 / height);
	vtkCamera *camera = world_renderer->GetActiveCamera();
	double x = 0.5 * (view.x0 + view.x1), y = 0.5 * (view.y0 + view.y1);
	camera->ParallelProjectionOn();
	camera->SetFocalPoint(x, y, 0);
	camera->SetPosition(x, y, 2 * depth);
	camera->SetViewUp(0, 1, 0);
	camera->SetParallelScale(0.5 * view.height());
	camera->SetClippingRange(0.5 * depth, 3 * depth);
}

void page::add(vtkActor *actor, int level)
{
	actor->SetPosition(0, 0, 0.02 * depth * level);
	vtkProperty *p = actor->GetProperty();
	p->LightingOff();
	world_renderers.back()->AddActor(actor);
}

void page::draw_world(const shapes &what, int level, double line_width, bool concave)
{
	if (what.empty())
		return;
	vtkNew<vtkPolyDataMapper> mapper;
	mapper->SetInputData(what.data(concave));
	mapper->SetScalarModeToUseCellData();
	vtkNew<vtkActor> actor;
	actor->SetMapper(mapper);
	actor->GetProperty()->SetLineWidth(float(std::max(1.0, line_width * unit)));
	add(actor, level);
}
