/* The frame: layout, alignment, growth, finding things again. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "run/frame.h"
#include "run/viewer.h"

static const void *build(struct frame_builder *builder, int n, int64_t *bytes)
{
	frame_begin(builder, 7, 0.25, "a title", "C");
	frame_channel_add(builder, "points", FRAME_VERTICES, n, n);
	double(*x)[3] = frame_array_add(builder, "coordinates", "m", FRAME_GEOMETRY, FRAME_F64, 3, n);
	for (int k = 0; k < n; k++)
		x[k][0] = k, x[k][1] = -k;
	double *t = frame_array_add(builder, "temperature", "T", FRAME_POINT, FRAME_F64, 1, n);
	for (int k = 0; k < n; k++)
		t[k] = 20 + k;
	struct frame_channel *channel = frame_channel_add(builder, "rve_A_discs", FRAME_VERTICES, 3, 3);
	channel->cell_matrix[0] = 2.0;
	snprintf(channel->note, sizeof channel->note, "p = 9.8 kPa");
	unsigned char *odd = frame_array_add(builder, "flags", "-", FRAME_CELL, FRAME_U8, 1, 3);
	odd[2] = 9;
	int *ids = frame_array_add(builder, "id", "-", FRAME_CELL, FRAME_I32, 1, 3);
	ids[1] = 5;
	frame_array_add(builder, "empty", "N", FRAME_CELL, FRAME_F32, 1, 0);
	return frame_finish(builder, bytes);
}

static void check(const void *frame, int n, int64_t bytes)
{
	const struct frame_header *header = frame_header(frame);
	assert_int_equal(header->magic, FRAME_MAGIC);
	assert_int_equal(header->version, FRAME_VERSION);
	assert_int_equal(header->bytes, bytes);
	assert_int_equal(header->step, 7);
	assert_true(header->time == 0.25);
	assert_string_equal(header->title, "a title");
	assert_string_equal(header->temperature_unit, "C");
	assert_int_equal(header->n_channels, 2);
	assert_int_equal(header->n_arrays, 5);

	int64_t end = (int64_t)((const char *)(frame_arrays(frame) + header->n_arrays) - (const char *)frame);
	for (int a = 0; a < header->n_arrays; a++) {
		const struct frame_array *array = &frame_arrays(frame)[a];
		assert_int_equal(array->offset % 64, 0);
		assert_true(array->offset >= end);
		end = array->offset + frame_type_bytes(array->type) * array->components * array->count;
		assert_true(end <= bytes);
	}
	int points = frame_find_channel(frame, "points"), discs = frame_find_channel(frame, "rve_A_discs");
	assert_int_equal(points, 0);
	assert_int_equal(discs, 1);
	assert_int_equal(frame_find_channel(frame, "walls"), -1);
	const double *x = frame_data(frame, frame_find_array(frame, points, "coordinates"));
	const double *t = frame_data(frame, frame_find_array(frame, points, "temperature"));
	for (int k = 0; k < n; k++) {
		assert_true(x[3 * k] == k && x[3 * k + 1] == -k && x[3 * k + 2] == 0);
		assert_true(t[k] == 20 + k);
	}
	assert_null(frame_find_array(frame, discs, "temperature"));
	assert_null(frame_find_array(frame, -1, "temperature"));
	const unsigned char *flags = frame_data(frame, frame_find_array(frame, discs, "flags"));
	assert_true(flags[0] == 0 && flags[1] == 0 && flags[2] == 9);
	const int *ids = frame_data(frame, frame_find_array(frame, discs, "id"));
	assert_true(ids[0] == 0 && ids[1] == 5 && ids[2] == 0);
	assert_int_equal(frame_find_array(frame, discs, "empty")->count, 0);
	assert_true(frame_channels(frame)[discs].cell_matrix[0] == 2.0);
	assert_string_equal(frame_channels(frame)[discs].note, "p = 9.8 kPa");
}

static void test_layout(void **state)
{
	(void)state;
	struct frame_builder *builder = frame_builder_create();
	static const int sizes[] = {1, 1000, 3, 20000, 0}; /* reuse, growing and shrinking */
	for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
		int64_t bytes = 0;
		const void *frame = build(builder, sizes[k], &bytes);
		assert_non_null(frame);
		assert_int_equal((uintptr_t)frame % 64, 0);
		check(frame, sizes[k], bytes);
	}
	frame_builder_free(builder);
}

static void test_long_names_are_cut(void **state)
{
	(void)state;
	char name[300];
	memset(name, 'x', sizeof name - 1);
	name[sizeof name - 1] = '\0';
	struct frame_builder *builder = frame_builder_create();
	frame_begin(builder, 0, 0, name, name);
	frame_channel_add(builder, name, FRAME_SEGMENTS, 0, 0);
	frame_array_add(builder, name, name, FRAME_CELL, FRAME_F64, 1, 0);
	int64_t bytes;
	const void *frame = frame_finish(builder, &bytes);
	assert_int_equal(strlen(frame_channels(frame)[0].name), FRAME_NAME - 1);
	assert_int_equal(strlen(frame_arrays(frame)[0].name), FRAME_NAME - 1);
	assert_int_equal(strlen(frame_arrays(frame)[0].unit), FRAME_UNIT - 1);
	assert_int_equal(strlen(frame_header(frame)->title), 255);
	frame_builder_free(builder);
}

static void test_lack_of_memory_is_reported(void **state)
{
	(void)state;
	struct frame_builder *builder = frame_builder_create();
	frame_begin(builder, 0, 0, "", "K");
	assert_non_null(frame_channel_add(builder, "points", FRAME_VERTICES, 1, 1));
	assert_null(frame_array_add(builder, "huge", "m", FRAME_POINT, FRAME_F64, 1, INT64_MAX / 64));
	int64_t bytes;
	assert_null(frame_finish(builder, &bytes));
	frame_begin(builder, 0, 0, "", "K"); /* and it works again */
	assert_non_null(frame_finish(builder, &bytes));
	frame_builder_free(builder);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_layout),
		cmocka_unit_test(test_long_names_are_cut),
		cmocka_unit_test(test_lack_of_memory_is_reported),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
