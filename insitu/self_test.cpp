#include "self_test.h"

#include <cstdio>
#include <cstring>
#include <string>

#include "catalyst_module.h"
#include "display.h"
#include "gl_test.h"

int self_test(const char *what)
{
	std::string works, error;
	bool good = false;
	if (!strcmp(what, "display")) {
		display display;
		good = display.open(works, error);
		works = works.empty() ? "draws on $DISPLAY" : works;
	} else if (!strcmp(what, "gl")) {
		display display;
		good = display.open(works, error) && gl_test(works, error);
	} else if (!strcmp(what, "catalyst")) {
		good = catalyst_test_script(error);
		works = "ParaView Catalyst runs a Python script";
	} else if (!strcmp(what, "live")) {
		good = catalyst_test_live(error);
		works = "a live connection over the loop-back carries data";
	} else {
		fprintf(stderr, "tmdempm-viewer: --self-test %s: expected display, gl, catalyst or live\n", what);
		return 2;
	}
	puts(good ? works.c_str() : error.c_str());
	return good ? 0 : 1;
}
