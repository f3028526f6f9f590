/* labels: slow
 * timeout: 240 */
/* The viewer process: pictures of the asked size and colours; and whatever befalls it, the engine goes on and
 * nothing is left behind.  Pictures stay in build/tests/pictures for people to look at. */
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/error.h"
#include "run/demo_frames.h"
#include "run/viewer.h"

static const struct frame_image images[] = {
	{.name = "temperature",
	 .field = "temperature",
	 .component = -1,
	 .view = {0, 0, 10, 12},
	 .size = {1000, 800},
	 .map = "viridis",
	 .range = {20, 60}},
	{.name = "rve",
	 .kind = 1,
	 .rve = "A",
	 .field = "displacement",
	 .component = -1,
	 .size = {640, 480},
	 .map = "inferno",
	 .range_auto = 1},
	{.name = "no_such_field",
	 .field = "colour_of_joy",
	 .component = -1,
	 .view = {0, 0, 10, 12},
	 .size = {300, 200},
	 .map = "viridis",
	 .range_auto = 1},
};
enum { TEMPERATURE, RVE, NO_SUCH_FIELD, N_IMAGES };

struct fixture {
	struct frame_builder *builder;
	struct viewer *viewer;
	char dir[512], path[600];
};

static const char *path_of(struct fixture *f, const char *name)
{
	snprintf(f->path, sizeof f->path, "%s/%s.png", f->dir, name);
	return f->path;
}

static int set_up(void **state)
{
	struct fixture *f = calloc(1, sizeof *f);
	f->builder = frame_builder_create();
	char self[400];
	ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
	self[n] = '\0';
	*strrchr(self, '/') = '\0';
	snprintf(f->dir, sizeof f->dir, "%s/pictures", self);
	mkdir(f->dir, 0777);
	*state = f;
	return 0;
}

static int tear_down(void **state)
{
	struct fixture *f = *state;
	viewer_finish(f->viewer);
	frame_builder_free(f->builder);
	free(f);
	return 0;
}

static void start(struct fixture *f)
{
	char log[600];
	snprintf(log, sizeof log, "%s/viewer.log", f->dir);
	if (viewer_start(&f->viewer, N_IMAGES, images, log) != STATUS_OK)
		fail_msg("%s", error_message());
}

static int draw_silo(struct fixture *f, const char *name)
{
	int64_t bytes;
	const void *frame = demo_frame_silo(f->builder, 1088, 0.5, &bytes);
	unlink(path_of(f, name));
	return viewer_draw(f->viewer, frame, bytes, TEMPERATURE, path_of(f, name));
}

static bool exists(struct fixture *f, const char *name) { return access(path_of(f, name), F_OK) == 0; }

/* The size that a PNG's header tells. */
static void png_size(const char *path, unsigned size[2])
{
	unsigned char head[24] = {0};
	FILE *file = fopen(path, "rb");
	if (!file)
		fail_msg("%s is not there", path);
	assert_int_equal(fread(head, 1, sizeof head, file), sizeof head);
	fclose(file);
	assert_memory_equal(head, "\x89PNG\r\n\x1a\n", 8);
	for (int k = 0; k < 2; k++)
		size[k] = (unsigned)head[16 + 4 * k] << 24 | (unsigned)head[17 + 4 * k] << 16 |
				  (unsigned)head[18 + 4 * k] << 8 | head[19 + 4 * k];
}

/* True while the process runs; one that is dead and only waits for its parent counts as gone. */
static bool alive(int pid)
{
	char path[64], line[256] = "";
	snprintf(path, sizeof path, "/proc/%d/stat", pid);
	FILE *file = fopen(path, "r");
	if (!file)
		return false;
	char *got = fgets(line, sizeof line, file);
	fclose(file);
	const char *end = got ? strrchr(line, ')') : NULL;
	return end && end[2] != 'Z' && end[2] != 'X';
}

static bool gone_soon(int pid)
{
	for (int tick = 0; tick < 100 && alive(pid); tick++)
		usleep(50000);
	return !alive(pid);
}

/* The first child of a process, 0 if it has none. */
static int child_of(int pid)
{
	char path[64];
	int child = 0;
	snprintf(path, sizeof path, "/proc/%d/task/%d/children", pid, pid);
	FILE *file = fopen(path, "r");
	if (!file)
		return 0;
	if (fscanf(file, "%d", &child) != 1)
		child = 0;
	fclose(file);
	return child;
}

static void test_sizes(void **state)
{
	struct fixture *f = *state;
	start(f);
	int64_t bytes;
	assert_int_equal(draw_silo(f, "silo"), STATUS_OK);
	const void *frame = demo_frame_rve(f->builder, 400, 1.2, 0.3, 1, &bytes);
	assert_int_equal(viewer_draw(f->viewer, frame, bytes, RVE, path_of(f, "rve")), STATUS_OK);
	assert_int_equal(viewer_finish(f->viewer), 0);
	f->viewer = NULL;
	unsigned size[2];
	png_size(path_of(f, "silo"), size);
	assert_int_equal(size[0], 1000);
	assert_int_equal(size[1], 800);
	png_size(path_of(f, "rve"), size);
	assert_int_equal(size[0], 640);
	assert_int_equal(size[1], 480);
}

static void test_colours(void **state)
{
	struct fixture *f = *state;
	start(f);
	assert_int_equal(draw_silo(f, "colours"), STATUS_OK);
	assert_int_equal(viewer_finish(f->viewer), 0);
	f->viewer = NULL;
	/* 20 C (the lowest of the scale), inside a wall, a wall that is switched off, the page's edge */
	static const int expected[4][3] = {{68, 1, 84}, {219, 219, 222}, {255, 255, 255}, {255, 255, 255}};
	char command[1200];
	snprintf(command, sizeof command, "python3 '%s/tests/e2e/png_pixels.py' '%s' 278,286 208,286 351,636 2,2",
			 SOURCE_DIR, path_of(f, "colours"));
	FILE *pixels = popen(command, "r");
	assert_non_null(pixels);
	for (int k = 0; k < 4; k++) {
		int c[3] = {-1, -1, -1};
		assert_int_equal(fscanf(pixels, "%d %d %d", &c[0], &c[1], &c[2]), 3);
		for (int d = 0; d < 3; d++)
			assert_in_range(c[d] + 2, expected[k][d], expected[k][d] + 4);
	}
	assert_int_equal(pclose(pixels), 0);
}

/* Larger frames than ever before: the memory grows while older ones are still being drawn. */
static void test_memory_grows(void **state)
{
	struct fixture *f = *state;
	start(f);
	char name[32];
	for (int k = 0; k < 6; k++) {
		int64_t bytes;
		snprintf(name, sizeof name, "grows_%d", k);
		const void *frame = demo_frame_silo(f->builder, 500 << k, 0.1 * k, &bytes);
		assert_int_equal(viewer_draw(f->viewer, frame, bytes, TEMPERATURE, path_of(f, name)), STATUS_OK);
	}
	assert_int_equal(viewer_finish(f->viewer), 0);
	f->viewer = NULL;
	for (int k = 0; k < 6; k++) {
		snprintf(name, sizeof name, "grows_%d", k);
		assert_true(exists(f, name));
		unlink(path_of(f, name));
	}
}

static void test_failures_are_counted_and_told(void **state)
{
	struct fixture *f = *state;
	start(f);
	int64_t bytes;
	const void *frame = demo_frame_silo(f->builder, 200, 0, &bytes);
	assert_int_equal(viewer_draw(f->viewer, frame, bytes, NO_SUCH_FIELD, path_of(f, "joy")), STATUS_OK);
	assert_int_equal(viewer_draw(f->viewer, frame, bytes, TEMPERATURE, "/no/such/folder/x.png"), STATUS_OK);
	assert_int_equal(viewer_draw(f->viewer, frame, bytes, RVE, path_of(f, "no_rve")), STATUS_OK);
	assert_int_equal(draw_silo(f, "after_failures"), STATUS_OK);
	assert_int_equal(viewer_flush(f->viewer), STATUS_OK);
	const char *notice = viewer_notice(f->viewer);
	assert_non_null(notice);
	assert_non_null(strstr(notice, "there is no field \"colour_of_joy\"; there are temperature, stress"));
	assert_non_null(strstr(notice, "cannot write /no/such/folder/x.png: No such file"));
	assert_non_null(strstr(notice, "no RVE \"A\""));
	assert_null(viewer_notice(f->viewer));
	assert_true(exists(f, "after_failures"));
	assert_int_equal(viewer_finish(f->viewer), 3);
	f->viewer = NULL;
}

static void test_killed_viewer_is_restarted_once(void **state)
{
	struct fixture *f = *state;
	start(f);
	assert_int_equal(draw_silo(f, "kill_0"), STATUS_OK);
	assert_int_equal(draw_silo(f, "kill_1"), STATUS_OK);
	int first = viewer_pid(f->viewer);
	kill(first, SIGKILL);
	assert_int_equal(draw_silo(f, "kill_2"), STATUS_OK);
	assert_int_equal(viewer_flush(f->viewer), STATUS_OK);
	assert_int_not_equal(viewer_pid(f->viewer), first);
	const char *notice = viewer_notice(f->viewer);
	assert_true(notice && strstr(notice, "was ended by signal 9 (Killed); starting it again"));
	assert_true(exists(f, "kill_0") && exists(f, "kill_1") && exists(f, "kill_2"));

	/* Another kind of failure has its own chance. */
	kill(viewer_pid(f->viewer), SIGABRT);
	assert_int_equal(draw_silo(f, "kill_3"), STATUS_OK);
	assert_int_equal(viewer_flush(f->viewer), STATUS_OK);
	assert_true(exists(f, "kill_3"));

	/* The same kind again: given up, and said so at every call. */
	int last = viewer_pid(f->viewer);
	kill(last, SIGKILL);
	assert_true(gone_soon(last));
	int status = draw_silo(f, "kill_4");
	if (status == STATUS_OK)
		status = viewer_flush(f->viewer);
	assert_int_equal(status, STATUS_RESOURCE);
	assert_non_null(strstr(error_message(), "signal 9 (Killed) again; no more pictures"));
	assert_int_equal(draw_silo(f, "kill_5"), STATUS_RESOURCE);
	assert_int_equal(viewer_pid(f->viewer), 0);
	assert_int_equal(viewer_finish(f->viewer), 2);
	f->viewer = NULL;
}

static void test_stopped_viewer_is_reported(void **state)
{
	struct fixture *f = *state;
	start(f);
	assert_int_equal(draw_silo(f, "stop_0"), STATUS_OK);
	assert_int_equal(viewer_flush(f->viewer), STATUS_OK);
	viewer_notice(f->viewer);
	int stopped = viewer_pid(f->viewer);
	kill(stopped, SIGSTOP);
	assert_int_equal(draw_silo(f, "stop_1"), STATUS_OK); /* does not wait: there are free slots */
	assert_null(viewer_notice(f->viewer));
	viewer_set_timeout(f->viewer, 8); /* the new one must start within it, also on a busy machine */
	assert_int_equal(viewer_flush(f->viewer), STATUS_OK);
	const char *notice = viewer_notice(f->viewer);
	assert_true(notice && strstr(notice, "did not answer in time; starting it again"));
	assert_false(alive(stopped));
	assert_true(exists(f, "stop_1"));
	assert_true(viewer_waited(f->viewer) > 8);
	assert_int_equal(viewer_finish(f->viewer), 0);
	f->viewer = NULL;
}

/* The life of an engine that is about to be killed; tells the process ids of its viewer and Xvfb. */
static void doomed_engine(struct fixture *f, bool stop_viewer, int report)
{
	int pids[2] = {0, 0};
	unsetenv("DISPLAY");
	if (viewer_start(&f->viewer, N_IMAGES, images, NULL) == STATUS_OK) {
		pids[0] = viewer_pid(f->viewer);
		pids[1] = child_of(pids[0]);
		if (stop_viewer)
			kill(pids[0], SIGSTOP);
		draw_silo(f, "doomed_0");
		draw_silo(f, "doomed_1");
	}
	if (write(report, pids, sizeof pids) != sizeof pids)
		_exit(1);
	for (;;)
		pause();
}

static void check_engine_killed(struct fixture *f, bool stop_viewer)
{
	int report[2], pids[2] = {0, 0};
	assert_int_equal(pipe(report), 0);
	fflush(NULL);
	pid_t engine = fork();
	if (engine == 0)
		doomed_engine(f, stop_viewer, report[1]);
	assert_int_equal(read(report[0], pids, sizeof pids), sizeof pids);
	close(report[0]), close(report[1]);
	bool ran = pids[0] && pids[1] && alive(pids[0]) && alive(pids[1]);
	kill(engine, SIGKILL);
	waitpid(engine, NULL, 0);
	assert_true(ran);
	assert_true(gone_soon(pids[0]));
	assert_true(gone_soon(pids[1]));
}

static void test_nothing_survives_the_engine(void **state)
{
	check_engine_killed(*state, false);
	check_engine_killed(*state, true);
}

static void test_finish_leaves_nothing(void **state)
{
	struct fixture *f = *state;
	unsetenv("DISPLAY");
	start(f);
	int viewer = viewer_pid(f->viewer), xvfb = child_of(viewer);
	assert_true(viewer && xvfb);
	assert_int_equal(draw_silo(f, "finish"), STATUS_OK);
	/* Ctrl-C reaches the whole group; the viewer leaves the decision to the engine. */
	kill(viewer, SIGINT);
	kill(viewer, SIGTERM);
	assert_int_equal(viewer_finish(f->viewer), 0);
	f->viewer = NULL;
	assert_true(exists(f, "finish"));
	assert_false(alive(viewer));
	assert_true(gone_soon(xvfb));
	assert_int_equal(waitpid(-1, NULL, WNOHANG), -1); /* no child of ours is left, not even a zombie */
}

static void test_what_is_missing_is_named(void **state)
{
	(void)state;
	struct viewer *viewer;
	char *program = strdup(viewer_program());
	setenv("TMDEMPM_VIEWER", "/no/such/viewer", 1);
	assert_int_equal(viewer_start(&viewer, N_IMAGES, images, NULL), STATUS_RESOURCE);
	assert_non_null(strstr(error_message(), "install paraview-dev"));
	setenv("TMDEMPM_VIEWER", "/bin/false", 1); /* starts, and fails at once */
	assert_int_equal(viewer_start(&viewer, N_IMAGES, images, NULL), STATUS_RESOURCE);
	assert_non_null(strstr(error_message(), "exit code 1"));
	assert_null(viewer);
	setenv("TMDEMPM_VIEWER", program, 1);
	free(program);

	char *path = strdup(getenv("PATH"));
	unsetenv("DISPLAY");
	setenv("PATH", "/nowhere", 1);
	int status = viewer_start(&viewer, N_IMAGES, images, NULL);
	setenv("PATH", path, 1);
	free(path);
	assert_int_equal(status, STATUS_RESOURCE);
	if (!strstr(error_message(), "install xvfb"))
		fail_msg("%s", error_message());
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(test_sizes, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_colours, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_memory_grows, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_failures_are_counted_and_told, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_killed_viewer_is_restarted_once, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_stopped_viewer_is_reported, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_nothing_survives_the_engine, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_finish_leaves_nothing, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_what_is_missing_is_named, set_up, tear_down),
	};
	if (!viewer_program()) {
		printf("skipped: tmdempm-viewer is not built (TMDEMPM_INSITU=OFF)\n");
		return 77;
	}
	return cmocka_run_group_tests(tests, NULL, NULL);
}
