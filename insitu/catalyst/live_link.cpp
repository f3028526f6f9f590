#include "live_link.h"

vtkStandardNewMacro(live_link);
