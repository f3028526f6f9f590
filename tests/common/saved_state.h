/* The state of a run in memory: saved, loaded into another, compared bit by bit.  Include after <cmocka.h> and
 * elastic_scene.h. */
#ifndef TESTS_COMMON_SAVED_STATE_H
#define TESTS_COMMON_SAVED_STATE_H

struct saved {
	int n;
	struct mpm_state_array arrays[64];
	void *data[64];
	char names[64][96];
};

static inline size_t bytes_of(const struct mpm_state_array *a)
{
	return a->count * (a->type == 'i' ? sizeof(int) : a->type == 'b' ? 1 : 8);
}

static inline void save(struct mpm *mpm, struct saved *saved)
{
	saved->n = mpm_state(mpm, NULL);
	assert_true(saved->n <= 64);
	ok(mpm_write_out(mpm));
	mpm_state(mpm, saved->arrays);
	for (int a = 0; a < saved->n; a++) {
		snprintf(saved->names[a], sizeof saved->names[a], "%s", saved->arrays[a].name);
		saved->data[a] = malloc(bytes_of(&saved->arrays[a]) + 1);
		memcpy(saved->data[a], saved->arrays[a].data, bytes_of(&saved->arrays[a]));
	}
}

static inline void load(struct mpm *mpm, const struct saved *saved)
{
	struct mpm_state_array arrays[64];
	assert_int_equal(mpm_state(mpm, arrays), saved->n);
	for (int a = 0; a < saved->n; a++) {
		assert_string_equal(arrays[a].name, saved->names[a]);
		memcpy(arrays[a].data, saved->data[a], bytes_of(&arrays[a]));
	}
	ok(mpm_restored(mpm));
}

static inline void assert_same(struct mpm *mpm, const struct saved *saved)
{
	struct mpm_state_array arrays[64];
	ok(mpm_write_out(mpm));
	assert_int_equal(mpm_state(mpm, arrays), saved->n);
	for (int a = 0; a < saved->n; a++)
		if (memcmp(arrays[a].data, saved->data[a], bytes_of(&arrays[a])))
			fail_msg("%s differs", arrays[a].name);
}

static inline void discard(struct saved *saved)
{
	for (int a = 0; a < saved->n; a++)
		free(saved->data[a]);
}

#endif
