/* assert_near(a, b, tolerance) in double precision (cmocka's assert_float_equal compares floats); NaN fails.
 * Include after cmocka.h. */
#ifndef TESTS_COMMON_NEAR_H
#define TESTS_COMMON_NEAR_H

#include <math.h>

#define assert_near(a, b, tolerance)                                                                                   \
	do {                                                                                                               \
		double near_a_ = (a), near_b_ = (b), near_tolerance_ = (tolerance);                                            \
		if (!(fabs(near_a_ - near_b_) <= near_tolerance_))                                                             \
			fail_msg("%s = %.17g, expected %.17g within %.3g (differs by %.3g)", #a, near_a_, near_b_,                 \
					 near_tolerance_, near_a_ - near_b_);                                                              \
	} while (0)

#endif
