#include "image_sink.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <unistd.h>

#include <vtkAutoInit.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkRenderWindow.h>
#include <vtkWindowToImageFilter.h>

#include "pictures.h"

VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingFreeType)

namespace
{
// Written beside its place and renamed: whoever looks there sees a whole picture or none.
bool write_png(vtkRenderWindow *window, const std::string &path, std::string &error)
{
	std::string temporary = path + ".part";
	vtkNew<vtkWindowToImageFilter> grab;
	grab->SetInput(window);
	grab->SetInputBufferTypeToRGB();
	grab->ReadFrontBufferOff();
	grab->ShouldRerenderOff();
	vtkNew<vtkPNGWriter> writer;
	writer->SetFileName(temporary.c_str());
	writer->SetInputConnection(grab->GetOutputPort());
	errno = 0;
	writer->Write();
	if (writer->GetErrorCode() == 0 && rename(temporary.c_str(), path.c_str()) == 0)
		return true;
	error = "cannot write " + path + (errno ? std::string(": ") + strerror(errno) : "");
	unlink(temporary.c_str());
	return false;
}

class image_sink : public sink
{
  public:
	image_sink()
	{
		window->SetOffScreenRendering(1);
		window->SetMultiSamples(4);
		window->SetNumberOfLayers(2);
		window->SetDPI(72);
	}

	bool draw(const frame_view &frame, const frame_image &image, const std::string &path, std::string &error) override
	{
		page page(image.size[0], image.size[1]);
		bool made =
			image.kind == 1 ? picture_rve(page, frame, image, error) : picture_points(page, frame, image, error);
		if (!made)
			return false;
		window->SetSize(page.width, page.height);
		window->AddRenderer(page.sheet());
		for (const auto &world : page.worlds())
			window->AddRenderer(world);
		window->Render();
		made = write_png(window, path, error);
		window->RemoveRenderer(page.sheet());
		for (const auto &world : page.worlds())
			window->RemoveRenderer(world);
		return made;
	}

  private:
	vtkNew<vtkRenderWindow> window;
};
} // namespace

std::unique_ptr<sink> image_sink_create() { return std::make_unique<image_sink>(); }
