/* timeout: 120 */
#include "manufactured.h"
