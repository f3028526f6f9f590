#include "catalyst.h"

extern "C" __attribute__((visibility("default"))) const catalyst_module tmdempm_catalyst = {
	scripts_create, live_create, scripts_test, live_test};
