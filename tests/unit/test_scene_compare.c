/* Which changes of a scene a restart accepts. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "scene/compare.h"

static const char before[] =
	"grid : { cell = 0.1; size = [ 1.0, 2.0 ]; }; time : { end = 1.0; step = 1e-4; };\n"
	"walls = ( { name = \"a\"; friction = 0.5; }, { name = \"b\"; } ); gravity = [ 0.0, -9.81 ];\n"
	"output : { vtk = true; };\n";

static void accepts(const char *now)
{
	char what[512] = "";
	if (!scene_compare(before, now, what, sizeof what))
		fail_msg("refused: %s", what);
}

static void refuses(const char *now, const char *expected)
{
	char what[512] = "";
	assert_false(scene_compare(before, now, what, sizeof what));
	if (!strstr(what, expected))
		fail_msg("`%s` expected in `%s`", expected, what);
}

static void same_and_free_changes(void **unused)
{
	(void)unused;
	accepts(before);
	accepts("grid : { cell = 0.1; size = [ 1.0, 2.0 ]; }; time : { step = 1e-4; end = 3; }; title = \"longer\";\n"
			"walls = ( { name = \"a\"; friction = 0.5; }, { name = \"b\"; } ); gravity = [ 0.0, -9.81 ];\n"
			"images = ( { name = \"x\"; } ); inspect = ( ); guards : { points_leaving = false; };\n");
}

static void guards_are_free_wherever_they_stand(void **unused)
{
	(void)unused;
	char what[512] = "";
	static const char laws[] = "laws = ( { name = \"a\"; mu = 0.5; overlap_max = 0.2; }, { name = \"b\"; } );"
							   "materials = ( { law = \"a\"; }, { law = { mu = 0.4; overlap_max = 0.1; }; } );";
	if (!scene_compare(laws,
					   "laws = ( { name = \"a\"; mu = 0.5; }, { name = \"b\"; overlap_max = 0.9; } );"
					   "materials = ( { law = \"a\"; }, { law = { mu = 0.4; overlap_max = 0.9; }; } );",
					   what, sizeof what))
		fail_msg("refused: %s", what);
	assert_false(scene_compare(laws,
							   "laws = ( { name = \"a\"; mu = 0.5; }, { name = \"b\"; } );"
							   "materials = ( { law = \"a\"; }, { law = { mu = 0.3; }; } );",
							   what, sizeof what));
	assert_non_null(strstr(what, "materials.[1].law.mu: 0.4 before, 0.3 now"));
}

static void other_changes_are_named(void **unused)
{
	(void)unused;
	const char rest[] = "time : { end = 1.0; step = 1e-4; }; gravity = [ 0.0, -9.81 ];";
	char now[1024];
	snprintf(now, sizeof now,
			 "%s grid : { cell = 0.1; size = [ 1.0, 2.0 ]; }; walls = ( { name = \"a\"; friction = 0.3; }, { name = "
			 "\"b\"; } );",
			 rest);
	refuses(now, "walls.[0].friction: 0.5 before, 0.3 now");
	snprintf(now, sizeof now,
			 "%s grid : { cell = 0.1; size = [ 1.0, 2.0 ]; }; walls = ( { name = \"a\"; friction = 0.5; } );", rest);
	refuses(now, "walls.[1]: a group or list of 1 before, absent now");
	snprintf(now, sizeof now,
			 "%s grid : { cell = 0.1; size = [ 1.0, 2.0 ]; shape = 1; }; walls = ( { name = \"a\"; friction = 0.5; }, "
			 "{ name = \"b\"; } );",
			 rest);
	refuses(now, "grid.shape: absent before, 1 now");
	snprintf(now, sizeof now,
			 "%s grid : { cell = 0.1; size = [ 1.0, 2.0 ]; }; walls = ( { name = \"a\"; friction = 0.5; }, { name = "
			 "\"c\"; } );",
			 rest);
	refuses(now, "walls.[1].name: \"b\" before, \"c\" now");
	refuses("nonsense = {", "cannot be read");
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(same_and_free_changes),
									   cmocka_unit_test(guards_are_free_wherever_they_stand),
									   cmocka_unit_test(other_changes_are_named)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
