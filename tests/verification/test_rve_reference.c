/* labels: slow
 * timeout: 300 */
#include "rve_reference.h"
