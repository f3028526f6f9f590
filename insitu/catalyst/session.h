// ParaView's server manager inside of this process.
#pragma once

#include <string>

class vtkSMSessionProxyManager;

// Starts ParaView as a batch process without MPI (of which we are the only one); null with a reason in `error`.
// Signals keep the meaning that they had.
vtkSMSessionProxyManager *session_start(std::string &error);
