// Bounds and directs the connections of ParaView's live link (live_connect.cpp).
#pragma once

#include <string>

// From now on every name leads to this host.
void live_connect_to(const std::string &host);
