// A page in pixels: the white sheet with its texts, scales and legends, and one window on it through which the
// world (metres) is seen.
#pragma once

#include <string>
#include <vector>

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include "colour.h"

struct box {
	double x0, y0, x1, y1;
	double width() const { return x1 - x0; }
	double height() const { return y1 - y0; }
};

// Triangles, quads and lines with a colour for each cell; in pixels or in metres.
class shapes
{
  public:
	shapes();
	void polygon(const double (*points)[2], int n, const rgb &colour, double opacity = 1);
	void line(const double (*points)[2], int n, bool closed, const rgb &colour, double opacity = 1);
	// A straight band of width w.
	void band(const double a[2], const double b[2], double w, const rgb &colour, double opacity = 1);
	void rectangle(const box &b, const rgb &colour, double opacity = 1);
	bool empty() const { return points->GetNumberOfPoints() == 0; }
	// Concave polygons are cut into triangles where asked for.
	vtkSmartPointer<vtkPolyData> data(bool concave = false) const;

  private:
	vtkIdType add(const double (*p)[2], int n);
	static void paint(vtkUnsignedCharArray *colours, const rgb &colour, double opacity);
	vtkSmartPointer<vtkPoints> points;
	vtkSmartPointer<vtkCellArray> polys, lines;
	vtkSmartPointer<vtkUnsignedCharArray> line_colours, poly_colours;
};

enum class align { low, middle, high };

class page
{
  public:
	page(int width, int height);

	const int width, height;
	const double unit; // pixels of a thousandth of the page: sizes of letters, lines and gaps are given in it
	vtkRenderer *sheet() const { return sheet_renderer; }
	const std::vector<vtkSmartPointer<vtkRenderer>> &worlds() const { return world_renderers; }

	// VTK's own letters, used where no font file is found, lack Greek.
	static bool greek();
	double text_width(const std::string &text, double size, bool bold = false) const;
	// (x, y) = the point named by the alignments; `turned`: reads upwards.
	void text(const std::string &text, double x, double y, double size, align across, align up,
			  const rgb &colour = ink::text, bool bold = false, bool turned = false);
	// Shapes in pixels; line widths in units.
	void draw(const shapes &what, double line_width = 1);

	// Opens a window `where` (pixels) on the part `view` (m) of a world of its own, to which add() and draw_world() add
	// from now on.
	void look(const box &view, const box &where);
	double metres_per_pixel() const { return scale; }
	// Adds to the world; higher levels lie in front.
	void add(vtkActor *actor, int level);
	void draw_world(const shapes &what, int level, double line_width = 1, bool concave = false);

  private:
	vtkSmartPointer<vtkRenderer> sheet_renderer;
	std::vector<vtkSmartPointer<vtkRenderer>> world_renderers; // the last is the one that is drawn to
	double scale = 1, depth = 1;
};
