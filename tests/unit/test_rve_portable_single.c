/* timeout: 120 */
#define RVE_FLOAT
#include "test_rve_portable.c"
