/* labels: long */
/* timeout: 900 */
#define FINE
#include "manufactured.h"
