/* The MPM in tests: calls that fail the test when they fail.  Include after cmocka.h. */
#ifndef TESTS_COMMON_MPM_CASE_H
#define TESTS_COMMON_MPM_CASE_H

#include "base/error.h"
#include "mpm/mpm.h"

static inline void ok(int status)
{
	if (status != STATUS_OK)
		print_error("status %d: %s\n", status, error_message());
	assert_int_equal(status, STATUS_OK);
}

static inline struct mpm *start(const struct scene *scene)
{
	struct mpm *mpm;
	ok(mpm_create(&mpm, scene));
	return mpm;
}

static inline void steps(struct mpm *mpm, int n)
{
	for (int k = 0; k < n; k++)
		ok(mpm_step(mpm));
}

#endif
