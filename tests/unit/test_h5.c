/* HDF5 files: what is written comes back, equal contents are equal bytes, failures say why. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"
#include "io/h5.h"

static char folder[FILE_PATH];

static void path_of(char path[FILE_PATH], const char *name)
{
	assert_int_equal(file_join(path, folder, name), STATUS_OK);
}

static void write_sample(const char *path)
{
	const double numbers[6] = {0.1, -0.0, 1e-300, 3, 4, 5};
	const unsigned char bytes[3] = {0, 255, 7};
	struct h5_output output;
	assert_int_equal(h5_begin(&output, path), STATUS_OK);
	hid_t group;
	assert_int_equal(h5_group(&group, output.file, "state"), STATUS_OK);
	assert_int_equal(h5_write(group, "numbers", H5T_NATIVE_DOUBLE, 2, 3, numbers), STATUS_OK);
	assert_int_equal(h5_write(group, "bytes", H5T_NATIVE_UCHAR, 3, 0, bytes), STATUS_OK);
	assert_int_equal(h5_write(group, "none", H5T_NATIVE_INT, 0, 0, NULL), STATUS_OK);
	assert_int_equal(h5_attribute_text(group, "numbers", "unit", "m/s"), STATUS_OK);
	H5Gclose(group);
	assert_int_equal(h5_write_text(output.file, "scene", "grid : { };\n"), STATUS_OK);
	assert_int_equal(h5_attribute_number(output.file, ".", "time", 0.1), STATUS_OK);
	assert_int_equal(h5_attribute_integer(output.file, ".", "step", 1LL << 40), STATUS_OK);
	assert_int_equal(h5_commit(&output), STATUS_OK);
	assert_false(file_exists(output.temporary));
}

static void comes_back(void **unused)
{
	(void)unused;
	char path[FILE_PATH];
	path_of(path, "a.h5");
	write_sample(path);
	hid_t file;
	assert_int_equal(h5_open(&file, path), STATUS_OK);
	double numbers[6], time;
	unsigned char bytes[3];
	long long step;
	char *text;
	assert_int_equal(h5_read(file, "state/numbers", H5T_NATIVE_DOUBLE, 6, numbers, path), STATUS_OK);
	const double expected[6] = {0.1, -0.0, 1e-300, 3, 4, 5};
	assert_memory_equal(numbers, expected, sizeof numbers);
	assert_int_equal(h5_read(file, "state/bytes", H5T_NATIVE_UCHAR, 3, bytes, path), STATUS_OK);
	assert_int_equal(bytes[1], 255);
	assert_int_equal(h5_read(file, "state/none", H5T_NATIVE_INT, 0, NULL, path), STATUS_OK);
	assert_int_equal(h5_read_number(file, "time", &time, path), STATUS_OK);
	assert_true(time == 0.1);
	assert_int_equal(h5_read_integer(file, "step", &step, path), STATUS_OK);
	assert_true(step == 1LL << 40);
	assert_int_equal(h5_read_text(file, "scene", &text, path), STATUS_OK);
	assert_string_equal(text, "grid : { };\n");
	free(text);
	/* what is not there, or not as long */
	assert_int_equal(h5_read(file, "state/numbers", H5T_NATIVE_DOUBLE, 5, numbers, path), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "holds 6 values, expected 5"));
	assert_int_equal(h5_read(file, "missing", H5T_NATIVE_DOUBLE, 5, numbers, path), STATUS_INPUT);
	H5Fclose(file);
}

static void same_contents_same_bytes(void **unused)
{
	(void)unused;
	char a[FILE_PATH], b[FILE_PATH], *text[2];
	size_t size[2];
	path_of(a, "a.h5");
	path_of(b, "b.h5");
	write_sample(a);
	usleep(1100000); /* times in a file would differ by a second */
	write_sample(b);
	assert_int_equal(file_read(&text[0], &size[0], a), STATUS_OK);
	assert_int_equal(file_read(&text[1], &size[1], b), STATUS_OK);
	assert_int_equal(size[0], size[1]);
	assert_memory_equal(text[0], text[1], size[0]);
	free(text[0]);
	free(text[1]);
}

static void failures_say_why(void **unused)
{
	(void)unused;
	struct h5_output output;
	hid_t file;
	char path[FILE_PATH];
	assert_int_equal(h5_begin(&output, "/nonexistent/x.h5"), STATUS_RESOURCE);
	assert_non_null(strstr(error_message(), "/nonexistent/x.h5: No such file or directory"));
	assert_int_equal(h5_open(&file, "/nonexistent/x.h5"), STATUS_RESOURCE);
	assert_non_null(strstr(error_message(), "No such file or directory"));
	path_of(path, "text.h5");
	assert_int_equal(file_write(path, "not HDF5", 8), STATUS_OK);
	assert_int_equal(h5_open(&file, path), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "is not an HDF5 file"));
}

static void links_show_other_files(void **unused)
{
	(void)unused;
	char path[FILE_PATH];
	path_of(path, "a.h5");
	write_sample(path);
	path_of(path, "run.h5");
	struct h5_output output;
	assert_int_equal(h5_begin(&output, path), STATUS_OK);
	assert_int_equal(h5_link(output.file, "00000001", "a.h5", "/"), STATUS_OK);
	assert_int_equal(h5_commit(&output), STATUS_OK);
	hid_t file;
	double numbers[6];
	assert_int_equal(h5_open(&file, path), STATUS_OK);
	assert_int_equal(h5_read(file, "00000001/state/numbers", H5T_NATIVE_DOUBLE, 6, numbers, path), STATUS_OK);
	assert_true(numbers[0] == 0.1);
	H5Fclose(file);
}

int main(void)
{
	char template[] = "/tmp/tmdempm_h5_XXXXXX";
	snprintf(folder, sizeof folder, "%s", mkdtemp(template));
	const struct CMUnitTest tests[] = {cmocka_unit_test(comes_back), cmocka_unit_test(same_contents_same_bytes),
									   cmocka_unit_test(failures_say_why), cmocka_unit_test(links_show_other_files)};
	int failed = cmocka_run_group_tests(tests, NULL, NULL);
	const char *const names[] = {"a.h5", "b.h5", "run.h5", "text.h5"};
	for (int i = 0; i < 4; i++) {
		char path[FILE_PATH];
		path_of(path, names[i]);
		unlink(path);
	}
	rmdir(folder);
	return failed;
}
