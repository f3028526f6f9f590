#include "colour.h"

#include <algorithm>
#include <cmath>

namespace
{
// 33 control points each, 8 bit; between them linear (largest error 1.7/255).
// viridis, inferno: S. van der Walt, N. Smith, E. Firing (matplotlib, CC0).
// coolwarm: K. Moreland, Diverging Color Maps for Scientific Visualization (2009).
constexpr unsigned char viridis[][3] = {
	{68, 1, 84},    {71, 13, 96},   {72, 24, 106},  {72, 35, 116},  {71, 45, 123},  {69, 55, 129},  {66, 64, 134},
	{62, 73, 137},  {59, 82, 139},  {55, 91, 141},  {51, 99, 141},  {47, 107, 142}, {44, 114, 142}, {41, 122, 142},
	{38, 130, 142}, {35, 137, 142}, {33, 145, 140}, {31, 151, 139}, {31, 159, 136}, {33, 166, 133}, {39, 173, 129},
	{49, 181, 123}, {61, 188, 116}, {76, 194, 108}, {92, 200, 99},  {110, 206, 88}, {129, 211, 77}, {149, 216, 64},
	{170, 220, 50}, {192, 223, 37}, {213, 226, 26}, {234, 229, 26}, {253, 231, 37}};
constexpr unsigned char inferno[][3] = {
	{0, 0, 4},      {4, 3, 18},     {11, 7, 36},     {21, 11, 55},    {33, 12, 74},   {47, 10, 91},   {61, 9, 101},
	{74, 12, 107},  {87, 16, 110},  {100, 21, 110},  {113, 25, 110},  {125, 30, 109}, {138, 34, 106}, {151, 39, 102},
	{163, 44, 97},  {176, 49, 91},  {188, 55, 84},   {198, 61, 77},   {208, 69, 69},  {218, 78, 60},  {227, 89, 51},
	{235, 100, 41}, {241, 113, 31}, {246, 126, 20},  {249, 140, 10},  {251, 155, 6},  {252, 170, 15}, {251, 186, 31},
	{249, 201, 50}, {245, 217, 73}, {242, 232, 101}, {243, 245, 134}, {252, 255, 164}};
constexpr unsigned char coolwarm[][3] = {
	{59, 76, 192},   {68, 90, 204},   {78, 104, 215},  {88, 117, 225},  {98, 130, 234},  {108, 142, 241},
	{119, 154, 247}, {130, 165, 251}, {141, 176, 254}, {152, 185, 255}, {163, 194, 255}, {174, 201, 253},
	{184, 208, 249}, {194, 213, 244}, {204, 217, 238}, {213, 219, 230}, {221, 221, 221}, {229, 216, 209},
	{236, 211, 198}, {241, 204, 185}, {245, 196, 173}, {247, 187, 160}, {247, 177, 148}, {247, 166, 135},
	{244, 154, 123}, {241, 141, 111}, {236, 127, 99},  {229, 112, 87},  {222, 97, 76},   {213, 80, 66},
	{203, 62, 56},   {192, 40, 47},   {180, 4, 38}};

template <size_t n> std::vector<rgb> table(const unsigned char (&bytes)[n][3])
{
	std::vector<rgb> map;
	for (const auto &c : bytes)
		map.push_back({c[0] / 255.0, c[1] / 255.0, c[2] / 255.0});
	return map;
}
} // namespace

const std::vector<rgb> *colour_map_find(const std::string &name)
{
	static const std::vector<rgb> maps[] = {table(viridis), table(inferno), table(coolwarm)};
	static const char *const names[] = {"viridis", "inferno", "coolwarm"};
	for (int k = 0; k < 3; k++)
		if (name == names[k])
			return &maps[k];
	return nullptr;
}

rgb colour_mix(const rgb &a, const rgb &b, double t)
{
	return {a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t};
}

rgb colour_map_at(const std::vector<rgb> &map, double t)
{
	if (std::isnan(t))
		return ink::missing;
	double x = std::clamp(t, 0.0, 1.0) * double(map.size() - 1);
	size_t k = std::min(size_t(x), map.size() - 2);
	return colour_mix(map[k], map[k + 1], x - double(k));
}

vtkSmartPointer<vtkLookupTable> colour_map_table(const std::vector<rgb> &map, double low, double high)
{
	constexpr int n = 256;
	auto table = vtkSmartPointer<vtkLookupTable>::New();
	table->SetNumberOfTableValues(n);
	for (int k = 0; k < n; k++) {
		rgb c = colour_map_at(map, k / (n - 1.0));
		table->SetTableValue(k, c[0], c[1], c[2], 1);
	}
	table->SetTableRange(low, high);
	table->SetNanColor(ink::missing[0], ink::missing[1], ink::missing[2], 1);
	return table;
}
