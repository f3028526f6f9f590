#include "catalyst_module.h"

#include <climits>
#include <dlfcn.h>
#include <fstream>
#include <sstream>
#include <unistd.h>

#include "live_connect.h"

namespace
{
std::string module_path()
{
	char self[PATH_MAX];
	ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
	std::string path(self, n > 0 ? size_t(n) : 0);
	return path.substr(0, path.rfind('/') + 1) + "tmdempm-catalyst.so";
}

const catalyst_module *load(std::string &error)
{
	std::string path = module_path();
	if (access(path.c_str(), R_OK) != 0) {
		error = "ParaView Catalyst is not built in (" + path +
				" is not there): install paraview-dev, python3-paraview and libpython3-dev, and build again";
		return nullptr;
	}
	// Python's own modules look for libpython's symbols among the global ones.
	void *handle = dlopen(path.c_str(), RTLD_NOW | RTLD_GLOBAL);
	auto *module = handle ? static_cast<const catalyst_module *>(dlsym(handle, "tmdempm_catalyst")) : nullptr;
	if (!module)
		error = std::string("cannot load ParaView Catalyst: ") + dlerror() +
				"; it was built for other packages than are installed now: build again";
	return module;
}
} // namespace

bool catalyst_script_draws(const std::string &path)
{
	std::ifstream file(path);
	std::stringstream text;
	if (path.size() < 3 || path.compare(path.size() - 3, 3, ".py") != 0 || !(text << file.rdbuf()))
		return true;
	for (const char *word : {"View", "Render", "Show(", "SaveScreenshot"})
		if (text.str().find(word) != std::string::npos)
			return true;
	return false;
}

std::unique_ptr<task> catalyst_scripts(const std::vector<std::string> &scripts, const std::string &folder,
									   std::string &error)
{
	const catalyst_module *module = load(error);
	return std::unique_ptr<task>(module ? module->scripts(scripts, folder, error) : nullptr);
}

std::unique_ptr<task> catalyst_live(const std::string &host, int port, std::string &error)
{
	const catalyst_module *module = load(error);
	live_connect_to(host);
	return std::unique_ptr<task>(module ? module->live(host, port, error) : nullptr);
}

bool catalyst_test_script(std::string &error)
{
	const catalyst_module *module = load(error);
	return module && module->test_script(error);
}

bool catalyst_test_live(std::string &error)
{
	const catalyst_module *module = load(error);
	live_connect_to("127.0.0.1");
	return module && module->test_live(error);
}
