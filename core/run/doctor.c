#define _GNU_SOURCE /* memfd_create, pipe2 */

#include "run/doctor.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <omp.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/error.h"
#include "io/h5.h"
#include "run/demo_frames.h"
#include "run/log.h"
#include "run/machine.h"
#include "run/viewer.h"
#include "rve/model.h"
#include "scene/scene.h"
#include "version.h"

enum { WORDS = 512 };

/* What one part is, how it is tried, and what to do about it.  `try` runs in its own process and fills words[WORDS]:
 * what works (returns true), or what does not. */
struct doctor_part {
	const char *name;
	const char *without; /* "" = a plain run needs it; else what is not to be had */
	bool (*try)(char *words);
	const char *cure;
};

static bool failed(char *words) { return snprintf(words, WORDS, "%s", error_message()), false; }

/* ---- what a plain run needs ---- */

static bool try_processor(char *words)
{
	struct machine machine;
	int started = 0;
	machine_look(&machine);
#pragma omp parallel reduction(+ : started)
	started += 1;
	snprintf(words, WORDS, "%s, %d threads start, %.1f GiB; RVEs run on x86-64 %s", machine.processor, started,
			 machine.memory / (1 << 30), rve_isa());
	return started == omp_get_max_threads();
}

static bool in_folder(char path[FILE_PATH], const char *folder, const char *name)
{
	return file_join(path, folder, name) == STATUS_OK;
}

/* A scene with a bit of everything that libconfig reads. */
static bool read_scene(const char *path, char *words)
{
	static const char text[] = "grid = { origin = [0.0, 0.0]; size = [1.0, 1.0]; cell = 0.25; };\n"
							   "time = { end = 0.1; step = 1e-3; };\n"
							   "materials = ( { name = \"m\"; density = 1e3; law = { type = \"thermoelastic\"; young = "
							   "1e6; poisson = 0.2; }; } );\n"
							   "bodies = ( { name = \"b\"; material = \"m\"; box = [0.25, 0.25, 0.75, 0.75]; } );\n";
	struct scene *scene;
	if (file_write(path, text, sizeof text - 1) != STATUS_OK || scene_load(&scene, path, 0, NULL, stdout) != STATUS_OK)
		return failed(words);
	bool right = scene->n_bodies == 1 && scene->time.step == 1e-3;
	scene_free(scene);
	snprintf(words, WORDS, "a scene is %s", right ? "read" : "read wrongly");
	return right;
}

static bool write_h5(const char *path, char *words)
{
	double values[100], back[100] = {0};
	struct h5_output output;
	hid_t file;
	for (int k = 0; k < 100; k++)
		values[k] = 1.0 / (k + 3);
	if (h5_begin(&output, path) != STATUS_OK)
		return failed(words);
	if (h5_write(output.file, "group/values", H5T_NATIVE_DOUBLE, 100, 0, values) != STATUS_OK ||
		h5_commit(&output) != STATUS_OK || h5_open(&file, path) != STATUS_OK) {
		h5_abandon(&output);
		return failed(words);
	}
	int status = h5_read(file, "group/values", H5T_NATIVE_DOUBLE, 100, back, path);
	H5Fclose(file);
	if (status != STATUS_OK)
		return failed(words);
	unsigned major, minor, release;
	H5get_libversion(&major, &minor, &release);
	bool same = !memcmp(values, back, sizeof values);
	snprintf(words, WORDS, "HDF5 %u.%u.%u: %s", major, minor, release,
			 same ? "written and read, every bit" : "what is read is not what was written");
	return same;
}

/* Tries something with a file in a folder of its own, which is gone afterwards. */
static bool with_file(char *words, const char *name, bool (*use)(const char *path, char *words))
{
	char folder[FILE_PATH], path[FILE_PATH];
	if (file_scratch_folder(folder, "doctor") != STATUS_OK || !in_folder(path, folder, name)) {
		snprintf(words, WORDS, "%s", error_message());
		return false;
	}
	bool works = use(path, words);
	unlink(path);
	rmdir(folder);
	return works;
}

static bool try_scene(char *words) { return with_file(words, "scene.cfg", read_scene); }
static bool try_hdf5(char *words) { return with_file(words, "values.h5", write_h5); }

static bool try_folder(char *words)
{
	char path[FILE_PATH], here[FILE_PATH] = "?";
	struct statvfs disk;
	char *cwd = getcwd(here, sizeof here);
	if (!cwd || file_temporary(path, "tmdempm-doctor") != STATUS_OK || file_write(path, "x", 1) != STATUS_OK)
		return failed(words);
	unlink(path);
	if (statvfs(".", &disk) != 0)
		return snprintf(words, WORDS, "%.300s: %s", here, strerror(errno)), false;
	double free_space = (double)disk.f_bavail * (double)disk.f_frsize / (1 << 30);
	snprintf(words, WORDS, "%.300s can be written to, %.1f GiB are free", here, free_space);
	return true;
}

/* ---- pictures ---- */

/* The memory that frames are handed over in. */
static bool try_memory(char *words)
{
	const size_t size = 1 << 24;
	int file = memfd_create("tmdempm-doctor", MFD_CLOEXEC | MFD_ALLOW_SEALING);
	int status = file < 0 ? errno : posix_fallocate(file, 0, (off_t)size);
	void *map = status ? MAP_FAILED : mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
	bool works = map != MAP_FAILED && fcntl(file, F_ADD_SEALS, F_SEAL_SHRINK) == 0;
	if (works)
		memset(map, 1, size);
	snprintf(words, WORDS, "%s",
			 works ? "frames are handed over in an anonymous memory file" : strerror(status ? status : errno));
	return works;
}

static bool try_viewer(char *words)
{
	const char *program = viewer_program();
	snprintf(words, WORDS, "%.400s", program ? program : "tmdempm-viewer is not built, or not beside this program");
	return program != NULL;
}

/* The last line that a program prints, also on its standard error if so asked; true if it ends with 0. */
static bool ask(char *words, const char *const *command, bool errors)
{
	int ends[2], status;
	if (pipe2(ends, O_CLOEXEC) < 0)
		return snprintf(words, WORDS, "no pipe: %s", strerror(errno)), false;
	pid_t pid = fork();
	if (pid == 0) {
		prctl(PR_SET_PDEATHSIG, SIGKILL);
		int null = open("/dev/null", O_RDWR);
		dup2(null, 0), dup2(ends[1], 1), dup2(errors ? ends[1] : null, 2);
		execvp(command[0], (char *const *)command);
		_exit(127);
	}
	close(ends[1]);
	FILE *stream = fdopen(ends[0], "r");
	char line[WORDS];
	words[0] = '\0';
	while (stream && fgets(line, sizeof line, stream))
		if (line[strcspn(line, "\r\n")] = '\0', *line)
			snprintf(words, WORDS, "%s", line);
	if (stream)
		fclose(stream);
	if (pid < 0 || waitpid(pid, &status, 0) != pid)
		return snprintf(words, WORDS, "cannot start %.300s", command[0]), false;
	if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
		return true;
	if (WIFSIGNALED(status))
		snprintf(words, WORDS, "it was ended by signal %d (%s)", WTERMSIG(status), strsignal(WTERMSIG(status)));
	else if (WEXITSTATUS(status) == 127)
		snprintf(words, WORDS, "%.300s is not there", command[0]);
	else if (!*words)
		snprintf(words, WORDS, "it ended with exit code %d", WEXITSTATUS(status));
	return false;
}

static bool ask_viewer(char *words, const char *test)
{
	const char *program = viewer_program();
	if (!program)
		return snprintf(words, WORDS, "there is no viewer"), false;
	return ask(words, (const char *const[]){program, "--self-test", test, NULL}, false);
}

static bool try_display(char *words)
{
	const char *name = getenv("DISPLAY");
	if (name && *name)
		return ask_viewer(words, "display");
	snprintf(words, WORDS, "none here; pictures are drawn on an Xvfb");
	return true;
}

static bool try_xvfb(char *words)
{
	unsetenv("DISPLAY");
	return ask_viewer(words, "display");
}

static bool try_gl(char *words) { return ask_viewer(words, "gl"); }

/* From a frame to a PNG, as a run does it. */
static bool draw_picture(const char *path, char *words)
{
	static const struct frame_image image = {.name = "doctor",
											 .field = "temperature",
											 .component = -1,
											 .view = {0, 0, 10, 12},
											 .size = {240, 200},
											 .map = "viridis",
											 .range = {20, 60}};
	struct frame_builder *builder = frame_builder_create();
	struct viewer *viewer = NULL;
	unsigned char head[24] = {0};
	int64_t bytes;
	const void *frame = builder ? demo_frame_silo(builder, 300, 0, &bytes) : NULL;
	double start = clock_seconds();
	if (!frame || viewer_start(&viewer, 1, &image, "/dev/null") != STATUS_OK)
		return failed(words);
	bool drawn = viewer_draw(viewer, frame, bytes, 0, path) == STATUS_OK && viewer_flush(viewer) == STATUS_OK;
	const char *notice = viewer_notice(viewer);
	snprintf(words, WORDS, "%s", notice ? notice : error_message());
	drawn = viewer_finish(viewer) == 0 && drawn;
	frame_builder_free(builder);
	FILE *png = drawn ? fopen(path, "rbe") : NULL;
	bool right = png && fread(head, 1, sizeof head, png) == sizeof head && !memcmp(head, "\x89PNG\r\n\x1a\n", 8) &&
				 head[19] == 240 && head[23] == 200;
	if (png)
		fclose(png);
	if (drawn)
		snprintf(words, WORDS, "%s in %.1f s",
				 right ? "a frame goes to the viewer and comes back as a picture" : "the picture is no whole PNG",
				 clock_seconds() - start);
	return right;
}

static bool try_images(char *words) { return with_file(words, "picture.png", draw_picture); }

/* ---- ParaView ---- */

static bool try_python(char *words)
{
	static const char text[] = "import sys, importlib.util as i\n"
							   "if not i.find_spec('matplotlib'): sys.exit(sys.executable + ' has no matplotlib')\n"
							   "import matplotlib as m\n"
							   "print('%s with matplotlib %s' % (sys.executable, m.__version__))\n";
	return ask(words, (const char *const[]){"python3", "-c", text, NULL}, true);
}

static bool try_catalyst(char *words) { return ask_viewer(words, "catalyst"); }
static bool try_live(char *words) { return ask_viewer(words, "live"); }

/* ---- devices ---- */

/* A function of a library that may not be there. */
#define FUNCTION(library, result, name, ...) result (*name)(__VA_ARGS__) = (result(*)(__VA_ARGS__))dlsym(library, #name)

static bool try_cuda(char *words)
{
	void *library = dlopen("libcuda.so.1", RTLD_NOW);
	if (!library)
		return snprintf(words, WORDS, "there is no libcuda.so.1: no driver of an NVIDIA GPU"), false;
	FUNCTION(library, int, cuInit, unsigned);
	FUNCTION(library, int, cuDriverGetVersion, int *);
	FUNCTION(library, int, cuDeviceGetCount, int *);
	FUNCTION(library, int, cuDeviceGetName, char *, int, int);
	int version = 0, n = 0, code = cuInit ? cuInit(0) : -1;
	char name[256] = "";
	if (code != 0 || !cuDeviceGetCount || cuDeviceGetCount(&n) != 0 || n < 1)
		return snprintf(words, WORDS, "the driver answers cuInit with %d and has no device", code), false;
	if (cuDriverGetVersion)
		cuDriverGetVersion(&version);
	if (cuDeviceGetName)
		cuDeviceGetName(name, sizeof name, 0);
	snprintf(words, WORDS, "CUDA %d.%d, %d device%s: %.200s%s", version / 1000, version % 1000 / 10, n,
			 n > 1 ? "s" : "", name, n > 1 ? " ..." : "");
	return true;
}

static bool try_opencl(char *words)
{
	enum { PLATFORMS = 16, DEVICES = 16, DEVICE_NAME = 0x102b };
	const unsigned long any_device = 0xffffffff;
	void *library = dlopen("libOpenCL.so.1", RTLD_NOW), *platforms[PLATFORMS], *devices[DEVICES];
	if (!library)
		return snprintf(words, WORDS, "there is no libOpenCL.so.1"), false;
	FUNCTION(library, int, clGetPlatformIDs, unsigned, void **, unsigned *);
	FUNCTION(library, int, clGetDeviceIDs, void *, unsigned long, unsigned, void **, unsigned *);
	FUNCTION(library, int, clGetDeviceInfo, void *, unsigned, size_t, void *, size_t *);
	unsigned n = 0, found = 0, all = 0;
	char name[256] = "";
	if (!clGetPlatformIDs || !clGetDeviceIDs || clGetPlatformIDs(PLATFORMS, platforms, &n) != 0 || n == 0)
		return snprintf(words, WORDS, "libOpenCL finds no platform"), false;
	for (unsigned p = 0; p < n && p < PLATFORMS; p++)
		if (clGetDeviceIDs(platforms[p], any_device, DEVICES, devices, &found) == 0 && found > 0) {
			if (!all && clGetDeviceInfo)
				clGetDeviceInfo(devices[0], DEVICE_NAME, sizeof name - 1, name, NULL);
			all += found;
		}
	snprintf(words, WORDS, "%u platform%s, %u device%s%s%.200s", n, n > 1 ? "s" : "", all, all == 1 ? "" : "s",
			 *name ? ": " : "", name);
	return all > 0;
}

/* ---- all of them ---- */

#define APT "apt-get install -y --no-install-recommends "
#define BUILD ", then build with cmake -DTMDEMPM_INSITU=ON"

static const struct doctor_part parts[] = {
	{"processor", "", try_processor,
	 "look at OMP_NUM_THREADS and OMP_THREAD_LIMIT, and at the limit of processes (ulimit -u)"},
	{"libconfig", "", try_scene, APT "libconfig9"},
	{"hdf5", "", try_hdf5, APT "libhdf5-103-1"},
	{"folder", "", try_folder, "go to a folder that you may write to, or name one: tmdempm run --out DIR"},
	{"memory", "pictures", try_memory, "needs Linux 3.17 or newer, and memory"},
	{"viewer", "pictures", try_viewer, APT "g++ cmake paraview-dev libx11-dev xvfb fonts-dejavu-core" BUILD},
	{"display", "pictures on this display", try_display, "unset DISPLAY: then pictures are drawn on an Xvfb"},
	{"xvfb", "pictures without a screen", try_xvfb, APT "xvfb libgl1-mesa-dri"},
	{"gl", "pictures", try_gl, APT "libgl1-mesa-dri xvfb"},
	{"images", "pictures", try_images, "the lines above say what is missing"},
	{"python", "charts of studies", try_python,
	 APT "python3 python3-matplotlib (for a python3 of your own: python3 -m pip install "
		 "matplotlib)"},
	{"catalyst", "scripts of ParaView Catalyst", try_catalyst,
	 APT "paraview-dev python3-paraview libpython3-dev" BUILD},
	{"live", "watching in ParaView", try_live, APT "paraview-dev python3-paraview libpython3-dev" BUILD},
	{"cuda", "CUDA", try_cuda,
	 "install the driver of the GPU (" APT "nvidia-driver); without a GPU there is nothing to do"},
	{"opencl", "OpenCL", try_opencl,
	 APT "ocl-icd-libopencl1, and a driver: pocl-opencl-icd for the CPU, the vendor's for a GPU"},
};
enum { PARTS = sizeof parts / sizeof *parts };

/* In a process of its own: whatever a driver does there, it does not do here. */
static void tried_by_child(const struct doctor_part *part, int report)
{
	char words[WORDS + 1] = "";
	prctl(PR_SET_PDEATHSIG, SIGKILL);
	setpgid(0, 0);
	words[0] = part->try(words + 1) ? '+' : '-';
	if (write(report, words, strlen(words)) < 0)
		_exit(1);
	_exit(0);
}

/* Its answer; without one within the time it is ended with all that it has started. */
static bool part_works(const struct doctor_part *part, double timeout, char words[WORDS])
{
	int ends[2], status = 0;
	char answer[WORDS + 2] = "";
	size_t n = 0;
	fflush(stdout);
	pid_t pid = pipe2(ends, O_CLOEXEC) < 0 ? -1 : fork();
	if (pid < 0)
		return snprintf(words, WORDS, "cannot start a process: %s", strerror(errno)), false;
	if (pid == 0)
		tried_by_child(part, ends[1]);
	close(ends[1]);
	double end = clock_seconds() + timeout;
	for (double left; (left = end - clock_seconds()) > 0;) {
		struct pollfd ready = {.fd = ends[0], .events = POLLIN};
		if (poll(&ready, 1, (int)(1e3 * left) + 1) <= 0)
			continue;
		ssize_t got = read(ends[0], answer + n, sizeof answer - 1 - n);
		if (got <= 0)
			break;
		n += (size_t)got;
	}
	bool late = clock_seconds() >= end;
	close(ends[0]);
	setpgid(pid, pid);
	kill(-pid, SIGKILL);
	waitpid(pid, &status, 0);
	if (late)
		return snprintf(words, WORDS, "no answer within %g s: it hangs, and was ended", timeout), false;
	if (n == 0)
		return snprintf(words, WORDS, "it crashed: signal %d (%s)", WIFSIGNALED(status) ? WTERMSIG(status) : 0,
						WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "none"),
			   false;
	snprintf(words, WORDS, "%.*s", WORDS - 1, answer + 1);
	return answer[0] == '+';
}

static bool is_named(const struct doctor_part *part, int n, char *const *names)
{
	bool named = n == 0;
	for (int k = 0; k < n; k++)
		named |= !strcmp(part->name, names[k]);
	return named;
}

static int check_names(int n, char *const *names)
{
	for (int k = 0; k < n; k++) {
		char all[WORDS] = "";
		bool known = false;
		for (int p = 0; p < PARTS; p++) {
			known |= !strcmp(parts[p].name, names[k]);
			snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", p ? ", " : "", parts[p].name);
		}
		if (!known)
			return error_set(STATUS_INPUT, "doctor: `%s` is no part, expected one of %s", names[k], all);
	}
	return STATUS_OK;
}

/* Tries a part and prints the outcome. */
static bool part_report(const struct doctor_part *part, double timeout)
{
	char words[WORDS];
	bool works = part_works(part, timeout, words), needed = !*part->without;
	printf("  %-7s  %-11s %s\n", works ? "works" : needed ? "BROKEN" : "missing", part->name, words);
	if (!works)
		printf("  %-7s  %-11s %s%s%s-> %s\n", "", "", needed ? "" : "without it no ", part->without, needed ? "" : "; ",
			   part->cure);
	return works;
}

int run_doctor(double timeout, int n, char *const *names)
{
	int broken = 0, absent = 0;
	CHECK(check_names(n, names));
	printf("tmdempm %s\n", TMDEMPM_VERSION);
	for (int k = 0; k < PARTS; k++) {
		if (!is_named(&parts[k], n, names) || part_report(&parts[k], timeout))
			continue;
		broken += !*parts[k].without;
		absent += *parts[k].without != '\0';
	}
	if (broken > 0)
		return error_set(STATUS_RESOURCE, "a run does not work on this machine: %d part%s that it needs", broken,
						 broken > 1 ? "s" : "");
	if (n == 0)
		printf("A plain run works here%s\n",
			   absent ? ".  What is missing above is not needed for it." : ", and everything else.");
	return STATUS_OK;
}
