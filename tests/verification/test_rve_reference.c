/* timeout: 300 */
enum { SEEDS = 3 };
#include "rve_reference.h"
