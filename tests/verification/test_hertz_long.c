/* labels: long
 * timeout: 900 */
#define CELLS 3
#include "test_hertz.c"
