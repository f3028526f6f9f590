/* labels: long */
/* timeout: 900 */
#define FINE
#include "rve_reference.h"
