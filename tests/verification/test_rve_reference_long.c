/* labels: long */
/* timeout: 900 */
enum { SEEDS = 8 };
#include "rve_reference.h"
