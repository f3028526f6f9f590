/* labels: slow
 * timeout: 300
 *
 * The disc between two blocks (scenarios/dp_mpm/disk_squish_*.cfg), with and without friction that falls with
 * temperature: softening lowers the peak temperature and the heat of friction and lets the disc out sooner (DP-MPM
 * section 4.4); the heat of friction is what the points have got. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"

struct squeezed {
	double peak;     /* C, hottest point so far */
	double friction; /* J */
	double disc;     /* m, height of its centre */
	double block;    /* m, of that of the right block */
};

static double height_of(const struct mpm *mpm, int body)
{
	double sum = 0.0, n = 0.0;
	for (int k = 0; k < mpm->p.n; k++)
		if (mpm->p.body[k] == body)
			sum += mpm->p.x[k][1], n += 1.0;
	return sum / n;
}

static struct squeezed squeeze(const char *path)
{
	struct scene *scene;
	struct squeezed result = {0};
	assert_int_equal(scene_load(&scene, path, 0, NULL, stderr), STATUS_OK);
	struct mpm *mpm = start(scene);
	assert_int_equal(mpm->p.n, 2905);
	while (mpm->time < scene->time.end - 0.5 * mpm->dt) {
		steps(mpm, 10);
		for (int k = 0; k < mpm->p.n; k++)
			result.peak = fmax(result.peak, mpm->p.T[k] - 273.15);
	}
	mpm_measure(mpm);
	const struct mpm_ledger *l = &mpm->ledger;
	result.friction = l->work_contact_friction;
	result.disc = height_of(mpm, 2);
	result.block = height_of(mpm, 1);
	assert_near(l->energy_thermal, l->work_contact_friction, 1e-6 * l->work_contact_friction);
	assert_true(fabs(l->energy_residual) < 0.01 * l->work_boundary);
	mpm_free(mpm);
	scene_free(scene);
	return result;
}

static void test_softening(void **state)
{
	(void)state;
	struct squeezed hard = squeeze(SOURCE_DIR "/scenarios/dp_mpm/disk_squish_thermal.cfg"),
					soft = squeeze(SOURCE_DIR "/scenarios/dp_mpm/disk_squish_softening.cfg");
	print_message(
		"peak %.0f and %.0f C, friction %.3f and %.3f J, disc at %.2f and %.2f mm, block at %.2f and %.2f mm\n",
		hard.peak, soft.peak, hard.friction, soft.friction, 1e3 * hard.disc, 1e3 * soft.disc, 1e3 * hard.block,
		1e3 * soft.block);
	assert_true(soft.peak < 0.9 * hard.peak);
	assert_true(soft.friction < 0.95 * hard.friction);
	assert_true(soft.disc < hard.disc);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_softening)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
