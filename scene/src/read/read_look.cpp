#include "read/read_look.hpp"

#include "read/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

constexpr const char* wanted_colours = "pairs [value, \"#rrggbb\"] with ascending values, or a colour map of "
                                       "ParaView, a file that ends in .json";
constexpr const char* wanted_opacity =
    "pairs [value, opacity] with ascending values and opacities from 0 to 1";

std::optional<double> finite(const toml::node* node) {
  const auto number = node != nullptr ? node->value<double>() : std::nullopt;
  return number && std::isfinite(*number) ? number : std::nullopt;
}

/// Calls take(value, second) for every pair of a list with ascending values. @return false for other lists
template<class Take>
bool for_each_pair(const toml::node& node, Take&& take) {
  const auto* list = node.as_array();
  if (!list || list->empty())
    return false;
  double before = -std::numeric_limits<double>::infinity();
  for (const toml::node& entry : *list) {
    const auto* pair = entry.as_array();
    const auto value = pair && pair->size() == 2 ? finite(pair->get(0)) : std::nullopt;
    if (!value || *value < before || !take(*value, *pair->get(1)))
      return false;
    before = *value;
  }
  return true;
}

bool read_colour_points(const toml::node& node, std::vector<ColourPoint>& points) {
  return for_each_pair(node, [&](double value, const toml::node& second) {
    const auto colour = parse_colour(second.value_or(std::string()));
    if (colour)
      points.push_back({value, *colour});
    return colour.has_value();
  });
}

bool read_opacity_points(const toml::node& node, std::vector<OpacityPoint>& points) {
  return for_each_pair(node, [&](double value, const toml::node& second) {
    const auto opacity = finite(&second);
    if (opacity)
      points.push_back({value, *opacity});
    return opacity && *opacity >= 0 && *opacity <= 1;
  });
}

/// `window = [low, high]`.
std::optional<std::pair<double, double>> read_window(TableReader& table) {
  const toml::node* node = table.find("window");
  if (!node)
    return std::nullopt;
  const auto* list = node->as_array();
  const auto low = list && list->size() == 2 ? finite(list->get(0)) : std::nullopt;
  const auto high = list && list->size() == 2 ? finite(list->get(1)) : std::nullopt;
  if (low && high && *low < *high)
    return std::pair{*low, *high};
  table.fault("window", "two grey values, the smaller first");
  return std::nullopt;
}

/// Scales the values of a colour map to 0 ... 1, for stretch() to a window.
void to_unit_range(Look& look) {
  const double low = look.colours.front().value, high = look.colours.back().value;
  const double scale = high > low ? 1 / (high - low) : 1;
  for (ColourPoint& point : look.colours)
    point.value = (point.value - low) * scale;
  for (OpacityPoint& point : look.opacity)
    point.value = (point.value - low) * scale;
}

/// True for maps that come with ParaView: 0 to 1 (or -1 to 1), independent of an image.
bool is_of_no_image(const Look& look) {
  const double low = look.colours.front().value, high = look.colours.back().value;
  return (low == 0 || low == -1) && high == 1;
}

void read_colours(TableReader& table, bool has_window, Look& look) {
  const toml::node& node = *table.find("colours");
  look.of_grey_values = true;
  if (node.is_string()) {
    const auto file = read_file_name(table, "colours");
    if (!file)
      return;
    try {
      look = read_paraview_colours(*file);
      if (has_window)
        to_unit_range(look);
      else if (is_of_no_image(look))
        table.fault(
            "window",
            "two grey values between which the colour map is stretched: its own values are from 0 to 1",
            "none");
    } catch (const InputError& error) {
      adopt(error, table.path_of("colours"), line_of(node), table.faults());
    }
    return;
  }
  if (!read_colour_points(node, look.colours)) {
    table.fault("colours", wanted_colours);
    return;
  }
  if (has_window)
    table.fault("window", "no such key with `colours`, whose values are grey values");
  look.opacity = {{look.colours.front().value, 0}, {look.colours.back().value, 1}};
}

void read_preset(TableReader& table, bool has_window, Look& look) {
  const auto name = table.choice("preset");
  if (!name)
    return;
  look = look_preset(*name);
  if (is_relative_preset(*name) && !has_window)
    table.fault("window", fmt::format("two grey values between which preset = \"{}\" is stretched", *name),
                "none");
  if (!is_relative_preset(*name) && has_window)
    table.fault("window", fmt::format("no such key with preset = \"{}\", whose values are fixed", *name));
}

/// `labels = { 17 = "#aa3322" }`
void read_label_colours(TableReader& table, Look& look) {
  const toml::table* section = table.subtable("labels");
  if (!section)
    return;
  for (const auto& [key, node] : *section) {
    const auto colour = parse_colour(node.value_or(std::string()));
    std::int32_t label = 0;
    const std::string_view text = key.str();
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), label);
    if (colour && error == std::errc{} && end == text.data() + text.size())
      look.label_colours.emplace_back(label, *colour);
    else
      table.faults().add(line_of(node), table.path_of("labels"), "a label and its colour, 17 = \"#aa3322\"",
                         fmt::format("{} = {}", text, describe(node)));
  }
  std::ranges::sort(look.label_colours);
}

void read_light(TableReader& table, Shading& shading) {
  table.read("shading", shading.on);
  table.read("ambient", shading.ambient);
  table.read("diffuse", shading.diffuse);
  table.read("specular", shading.specular);
  table.read("shininess", shading.shininess);
}

void read_mode(TableReader& table, Look& look) {
  if (table.read("mode", look.mode) && look.mode == LookMode::isosurface)
    table.require("isovalue");
  if (const auto value = table.number("isovalue")) {
    look.isovalue = *value;
    if (look.mode != LookMode::isosurface)
      table.fault("isovalue", "no such key unless mode = \"isosurface\"");
    if (!table.has("opacity")) // a surface is opaque
      look.opacity = {{*value, 1}};
  }
}

/// `picture = "photograph.png"`, `pixel`.
void read_picture(TableReader& table, Look& look) {
  table.read("pixel", look.pixel);
  if (!table.has("picture"))
    table.refuse("pixel", "no such key without `picture`");
  const auto name = table.text("picture");
  if (!name)
    return;
  look.shading.on = false; // a picture contains its lighting
  const auto file = read_file_name(table, "picture");
  look.picture = file ? file->string() : "";
  const std::string ending = std::filesystem::path(*name).extension().string();
  if (ending != ".png" && ending != ".jpg" && ending != ".jpeg")
    table.fault("picture", "a file that ends in .png, .jpg or .jpeg");
}

void read_reach(TableReader& table, Look& look) {
  const toml::node* around = table.find("around");
  if (around && around->value<std::string>() == "all")
    look.around = std::numeric_limits<double>::infinity();
  else if (around) {
    look.around = read_quantity(*around, table.path_of("around"), Dimension::length, table.faults());
    if (look.around && *look.around < 0)
      table.fault("around", "a length >= 0, or \"all\"");
  }
  table.read("unit_distance", look.unit_distance);
}

} // namespace

std::optional<Look> read_look(TableReader& root) {
  if (!root.has("look"))
    return std::nullopt;
  const std::size_t faults_before = root.faults().size();
  auto section = root.open("look");
  if (!section)
    return std::nullopt;
  TableReader& table = *section;
  Look look = solid_look();
  const auto window = read_window(table);
  const bool has_window = table.has("window");
  const toml::node* colour = table.find("colour");
  const int n_ways = (table.has("colours") ? 1 : 0) + (table.has("preset") ? 1 : 0) + (colour ? 1 : 0) +
                     (table.has("picture") ? 1 : 0);
  if (n_ways > 1)
    table.fault("", "one of colour, colours, picture and preset", "several of them");
  if (table.has("colours")) {
    look.mode = LookMode::composite; // grey values, not the body's surface
    look.isovalue = 0;
    read_colours(table, has_window, look);
  } else if (table.has("preset"))
    read_preset(table, has_window, look);
  else if (colour) {
    if (const auto rgb = parse_colour(colour->value_or(std::string())))
      look = solid_look(*rgb);
    else
      table.fault("colour", "a colour \"#rrggbb\"");
  } else if (has_window)
    look = look_preset("grey");
  if (window && !look.colours.empty())
    stretch(look, window->first, window->second);
  if (const toml::node* node = table.find("opacity")) {
    look.opacity.clear();
    if (!read_opacity_points(*node, look.opacity))
      table.fault("opacity", wanted_opacity);
  }
  read_picture(table, look);
  read_mode(table, look);
  read_light(table, look.shading);
  read_reach(table, look);
  read_label_colours(table, look);
  if (const auto name = table.text("image")) {
    const auto file = read_file_name(table, "image");
    look.image = file ? file->string() : "";
    if (!look.of_grey_values && !table.has("colours") && !table.has("preset"))
      table.fault("image", "colours, a preset or a window beside it: how its values look", "none");
  }
  look.is_centred = table.choice("place") == "middle";
  if (look.is_centred && !table.has("image"))
    table.fault("place", "`image` beside it: what is put on the middle of the body's own image", "none");
  table.finish();
  return root.faults().size() == faults_before ? std::optional(look) : std::nullopt;
}

} // namespace maille::reader
