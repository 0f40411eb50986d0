// Reads colour maps of ParaView: JSON, a list of maps.

#include "maille/materials/json.hpp"
#include "maille/scene/look.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace maille {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file, std::string key, std::string expected,
                       std::string found) {
  throw InputError({{file.string(), 0, std::move(key), std::move(expected), std::move(found)}});
}

/// Reads numbers in groups (RGBPoints, Points); all finite, the first of each group ascending.
std::vector<double> numbers_in_groups(const nlohmann::ordered_json& map, const char* key, std::size_t group,
                                      const std::filesystem::path& file) {
  const nlohmann::ordered_json& list = map.at(key);
  const std::string expected = "groups of " + std::to_string(group) +
                               " finite numbers, each group's value "
                               "not below the one before";
  std::vector<double> numbers;
  if (list.is_array())
    for (const nlohmann::ordered_json& number : list)
      numbers.push_back(number.is_number() ? number.get<double>() : std::nan(""));
  bool is_good = !numbers.empty() && numbers.size() % group == 0 &&
                 std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); });
  for (std::size_t i = group; is_good && i < numbers.size(); i += group)
    is_good = numbers[i] >= numbers[i - group];
  if (!is_good)
    fail(file, key, expected, list.is_array() ? std::to_string(numbers.size()) + " entries" : "no list");
  return numbers;
}

} // namespace

Look read_paraview_colours(const std::filesystem::path& file) {
  const auto json = parse_json(read_text_file(file, "a colour map"), file);
  const nlohmann::ordered_json* map = json.is_array() && !json.empty() ? &json.front() : &json;
  if (!map->is_object() || !map->contains("RGBPoints"))
    fail(file, "RGBPoints", "a map with points of colour", "none");
  Look look;
  look.of_grey_values = true;
  const auto colours = numbers_in_groups(*map, "RGBPoints", 4, file);
  for (std::size_t i = 0; i < colours.size(); i += 4)
    look.colours.push_back({colours[i],
                            {static_cast<float>(std::clamp(colours[i + 1], 0.0, 1.0)),
                             static_cast<float>(std::clamp(colours[i + 2], 0.0, 1.0)),
                             static_cast<float>(std::clamp(colours[i + 3], 0.0, 1.0))}});
  if (map->contains("Points")) {
    const auto points = numbers_in_groups(*map, "Points", 4, file);
    for (std::size_t i = 0; i < points.size(); i += 4)
      look.opacity.push_back({points[i], std::clamp(points[i + 1], 0.0, 1.0)});
  } else {
    look.opacity = {{look.colours.front().value, 0}, {look.colours.back().value, 1}};
  }
  return look;
}

} // namespace maille
