#include "gl_test.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkWindowToImageFilter.h>

#include "page.h"

namespace
{
constexpr rgb red = {1, 0, 0}, green = {0, 1, 0}, blue = {0, 0, 1};

// The line of the driver's report that begins with `key`, without it.
std::string capability(const std::string &report, const std::string &key)
{
	size_t at = report.find(key);
	if (at == std::string::npos)
		return "unknown";
	at = report.find_first_not_of(" \t:", at + key.size());
	return at == std::string::npos ? "unknown" : report.substr(at, report.find('\n', at) - at);
}

bool pixel_is(vtkImageData *image, int x, int y, const rgb &colour, std::string &error)
{
	for (int c = 0; c < 3; c++) {
		int found = int(image->GetScalarComponentAsDouble(x, y, 0, c)), wanted = int(255 * colour[size_t(c)]);
		if (std::abs(found - wanted) > 3) {
			error = "OpenGL draws wrongly: a pixel that was asked to be " + std::to_string(wanted) + " is " +
					std::to_string(found);
			return false;
		}
	}
	return true;
}
} // namespace

bool gl_test(std::string &works, std::string &error)
{
	// Sheet: the left red.  World, on the right: a green square behind a smaller blue one.
	page page(64, 48);
	shapes left, behind, before;
	left.rectangle({0, 0, 32, 48}, red);
	behind.rectangle({-1, -1, 1, 1}, green);
	before.rectangle({-0.5, -0.5, 0.5, 0.5}, blue);
	page.draw(left);
	page.look({-1, -1, 1, 1}, {32, 8, 64, 40});
	page.draw_world(before, 2);
	page.draw_world(behind, 1);
	vtkNew<vtkRenderWindow> window;
	window->SetOffScreenRendering(1);
	window->SetNumberOfLayers(2);
	window->SetSize(page.width, page.height);
	window->AddRenderer(page.sheet());
	for (const auto &world : page.worlds())
		window->AddRenderer(world);
	window->Render();
	vtkNew<vtkWindowToImageFilter> grab;
	grab->SetInput(window);
	grab->ReadFrontBufferOff();
	grab->ShouldRerenderOff();
	grab->Update();
	const char *text = window->ReportCapabilities();
	std::string report = text ? text : "";
	works = capability(report, "OpenGL renderer string") + ", OpenGL " + capability(report, "OpenGL version string");
	vtkImageData *image = grab->GetOutput();
	return pixel_is(image, 16, 24, red, error) && pixel_is(image, 36, 12, green, error) &&
		   pixel_is(image, 48, 24, blue, error) && pixel_is(image, 48, 4, {1, 1, 1}, error);
}
