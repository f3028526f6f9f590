// Pictures: plain VTK, off screen, PNG.
#pragma once

#include <memory>

#include "sink.h"

std::unique_ptr<sink> image_sink_create();
