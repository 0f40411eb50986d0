#include "maille/scene/look.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <stdexcept>

namespace maille {

namespace {

/// The table points before and after a value, and the fraction between them.
template<class Point>
std::pair<const Point*, const Point*> neighbours(const std::vector<Point>& points, double value,
                                                 double& part) {
  const auto after = std::ranges::upper_bound(points, value, {}, &Point::value);
  part = 0;
  if (after == points.begin())
    return {&points.front(), &points.front()};
  if (after == points.end())
    return {&points.back(), &points.back()};
  const Point& low = *std::prev(after);
  part = after->value > low.value ? (value - low.value) / (after->value - low.value) : 0;
  return {&low, &*after};
}

} // namespace

Rgb Look::colour_at(double value) const {
  double part = 0;
  const auto [low, high] = neighbours(colours, value, part);
  Rgb colour{};
  for (std::size_t a = 0; a < 3; ++a)
    colour[a] = static_cast<float>(low->colour[a] + part * (high->colour[a] - low->colour[a]));
  return colour;
}

double Look::opacity_at(double value) const {
  double part = 0;
  const auto [low, high] = neighbours(opacity, value, part);
  return low->opacity + part * (high->opacity - low->opacity);
}

std::optional<std::pair<double, double>> Look::visible_range() const {
  if (mode == LookMode::isosurface)
    return std::pair{isovalue, std::numeric_limits<double>::infinity()};
  const auto is_seen = [](const OpacityPoint& point) { return point.opacity > 0; };
  const auto first = std::ranges::find_if(opacity, is_seen);
  if (first == opacity.end())
    return std::nullopt;
  const auto after = std::ranges::find_if(opacity.rbegin(), opacity.rend(), is_seen).base();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return std::pair{first == opacity.begin() ? -infinity : std::prev(first)->value,
                   after == opacity.end() ? infinity : after->value};
}

std::optional<Rgb> parse_colour(std::string_view text) {
  if (text.size() != 7 || text[0] != '#')
    return std::nullopt;
  Rgb colour{};
  for (std::size_t a = 0; a < 3; ++a) {
    int value = 0;
    for (std::size_t d = 0; d < 2; ++d) {
      const char c = text[1 + 2 * a + d];
      const int digit = c >= '0' && c <= '9'   ? c - '0'
                        : c >= 'a' && c <= 'f' ? c - 'a' + 10
                        : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                               : -1;
      if (digit < 0)
        return std::nullopt;
      value = 16 * value + digit;
    }
    colour[a] = static_cast<float>(value) / 255;
  }
  return colour;
}

namespace {

struct Preset {
  std::string_view name;
  bool is_relative;
  std::vector<ColourPoint> colours;
  std::vector<OpacityPoint> opacity;
};

constexpr Rgb bone{0.93f, 0.90f, 0.80f}, skin{0.86f, 0.62f, 0.50f}, muscle{0.72f, 0.22f, 0.18f},
    dark{0.25f, 0.06f, 0.05f};

const std::vector<Preset>& presets() {
  static const std::vector<Preset> list{
      {"ct_bone",
       false,
       {{1100, {0.72f, 0.45f, 0.33f}}, {1250, bone}, {1900, {1, 1, 0.98f}}},
       {{1120, 0}, {1220, 0.7}, {1500, 1}}},
      {"ct_skin", false, {{300, skin}, {1100, skin}}, {{350, 0}, {650, 0.8}, {900, 1}}},
      {"ct_head",
       false,
       {{300, skin}, {1050, skin}, {1150, {0.85f, 0.68f, 0.52f}}, {1250, bone}, {1900, {1, 1, 0.98f}}},
       {{400, 0}, {600, 0.06}, {900, 0.12}, {1080, 0.03}, {1150, 0.05}, {1250, 0.8}, {1600, 1}}},
      {"ct_muscle",
       false,
       {{950, {0.95f, 0.80f, 0.45f}}, {1030, muscle}, {1100, muscle}, {1250, bone}},
       {{900, 0}, {1000, 0.1}, {1060, 0.7}, {1250, 1}}},
      {"mr_muscle",
       true,
       {{0, dark}, {0.35, muscle}, {0.75, {0.93f, 0.72f, 0.60f}}, {1, {1, 0.95f, 0.88f}}},
       {{0.04, 0}, {0.12, 0.35}, {0.3, 0.9}, {0.6, 1}}},
      {"grey", true, {{0, {0, 0, 0}}, {1, {1, 1, 1}}}, {{0.02, 0}, {0.15, 0.9}, {0.3, 1}}},
  };
  return list;
}

const Preset* preset_named(std::string_view name) {
  const auto found = std::ranges::find(presets(), name, &Preset::name);
  return found == presets().end() ? nullptr : &*found;
}

} // namespace

Look look_preset(std::string_view name) {
  const Preset* preset = preset_named(name);
  if (preset == nullptr)
    throw std::invalid_argument("no preset of that name");
  Look look;
  look.colours = preset->colours;
  look.opacity = preset->opacity;
  look.of_grey_values = true;
  return look;
}

bool is_relative_preset(std::string_view name) {
  const Preset* preset = preset_named(name);
  return preset != nullptr && preset->is_relative;
}

void stretch(Look& look, double low, double high) {
  const auto in_window = [&](double value) { return low + value * (high - low); };
  for (ColourPoint& point : look.colours)
    point.value = in_window(point.value);
  for (OpacityPoint& point : look.opacity)
    point.value = in_window(point.value);
  look.isovalue = in_window(look.isovalue);
}

Look solid_look(const Rgb& colour) {
  Look look;
  look.colours = {{0, colour}};
  look.opacity = {{0, 1}};
  look.mode = LookMode::isosurface;
  look.isovalue = 0.5;
  return look;
}

} // namespace maille
