// Colour maps and the fixed colours of pictures, all in one place.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <vtkLookupTable.h>
#include <vtkSmartPointer.h>

using rgb = std::array<double, 3>; // 0..1

namespace ink
{
constexpr rgb text = {0.13, 0.13, 0.13};
constexpr rgb frame = {0.78, 0.78, 0.78};
constexpr rgb wall = {0.86, 0.86, 0.87};
constexpr rgb wall_edge = {0.25, 0.25, 0.27};
constexpr rgb missing = {0.72, 0.72, 0.72}; // NaN
constexpr rgb compression = {0.10, 0.10, 0.12};
constexpr rgb tension = {0.12, 0.47, 0.85};
constexpr rgb sliding = {0.90, 0.33, 0.05};
constexpr rgb bond = {1.00, 1.00, 1.00};
constexpr rgb broken = {0.93, 0.25, 0.75};
constexpr rgb cell = {0.85, 0.00, 0.35};
constexpr rgb fabric = {0.00, 0.50, 0.45};
} // namespace ink

// A map of `name` (viridis, inferno, coolwarm); nullptr if there is none of that name.
const std::vector<rgb> *colour_map_find(const std::string &name);

// The colour at t (cut to 0..1; NaN gives the colour of missing values).
rgb colour_map_at(const std::vector<rgb> &map, double t);

// The same as a table for VTK's mappers.
vtkSmartPointer<vtkLookupTable> colour_map_table(const std::vector<rgb> &map, double low, double high);

// a (1 - t) + b t.
rgb colour_mix(const rgb &a, const rgb &b, double t);
