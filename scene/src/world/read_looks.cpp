// Reads the looks of all bodies of a scene file, with their grey values.

#include "maille/materials/text_file.hpp"
#include "maille/scene/look.hpp"
#include "read/read_look.hpp"
#include "read/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace maille {

namespace {

/// Crops an image to its visible voxels plus one on each side.
void cut_to_visible(Image& image, const Look& look) {
  const Index3 n = image.info.size;
  const auto range = look.visible_range();
  Index3 first{n[0], n[1], n[2]}, last{-1, -1, -1};
  std::size_t voxel = 0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i, ++voxel) {
        const double value = image.values[voxel];
        if (!range || !(value >= range->first && value <= range->second))
          continue;
        const Index3 at{i, j, k};
        for (std::size_t a = 0; a < 3; ++a) {
          first[a] = std::min(first[a], at[a]);
          last[a] = std::max(last[a], at[a]);
        }
      }
  if (last[0] < 0)
    return;
  Index3 size{};
  for (std::size_t a = 0; a < 3; ++a) {
    first[a] = std::max(first[a] - 1, 0);
    last[a] = std::min(last[a] + 1, n[a] - 1);
    size[a] = last[a] - first[a] + 1;
  }
  std::vector<float> kept;
  kept.reserve(std::int64_t{size[0]} * size[1] * size[2]);
  for (int k = first[2]; k <= last[2]; ++k)
    for (int j = first[1]; j <= last[1]; ++j) {
      const auto row = image.values.begin() + (first[0] + std::int64_t{n[0]} * (j + std::int64_t{n[1]} * k));
      kept.insert(kept.end(), row, row + size[0]);
    }
  image.values = std::move(kept);
  ImageInfo& info = image.info;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t a = 0; a < 3; ++a)
      info.origin[row] += info.direction[row][a] * info.spacing[a] * first[a];
  info.size = size;
}

Vec3 middle_of(const ImageInfo& image) {
  Vec3 middle = image.origin;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t a = 0; a < 3; ++a)
      middle[row] += image.direction[row][a] * image.spacing[a] * 0.5 * (image.size[a] - 1);
  return middle;
}

void put_middle_on(const ImageInfo& other, ImageInfo& image) {
  const Vec3 from = middle_of(image), to = middle_of(other);
  for (std::size_t a = 0; a < 3; ++a)
    image.origin[a] += to[a] - from[a];
}

void fill_grey(TableReader& table, Seen& seen) {
  const bool is_own = seen.look.image.empty();
  const auto own_name = table.text("shape") == "image" ? table.text("image") : std::nullopt;
  const std::string path = table.path_of("look");
  const int line = table.line_of_key("look");
  if (is_own && !own_name) {
    table.faults().add(line, path, "`image`, the file of the grey values: this body is not an image", "none");
    return;
  }
  if (seen.look.is_centred && !own_name) {
    table.faults().add(line, path + ".place", "\"header\": this body is not an image", "\"middle\"");
    return;
  }
  std::optional<std::filesystem::path> own;
  if (own_name)
    own = reader::resolve_path(*own_name, table.path_of("image"), table.line_of_key("image"), table.faults());
  const std::filesystem::path file = is_own ? own.value_or("") : std::filesystem::path(seen.look.image);
  if (file.empty())
    return;
  try {
    seen.grey = read_image(file);
    if (seen.grey.info.components != 1) {
      table.faults().add(line, path, "an image of one grey value a voxel",
                         std::to_string(seen.grey.info.components) + " values a voxel");
      return;
    }
    const ImageInfo of_body = own ? read_image_info(*own) : seen.grey.info;
    seen.grey.info = in_world(seen.grey.info, of_body.world);
    seen.placement = reader::placement_of(of_body);
    if (seen.look.is_centred)
      put_middle_on(of_body, seen.grey.info);
  } catch (const InputError& error) {
    reader::adopt(error, is_own ? path : path + ".image", line, table.faults());
    return;
  }
  const auto is_odd = [](float value) { return !std::isfinite(value); };
  if (const auto n_odd = std::ranges::count_if(seen.grey.values, is_odd); n_odd > 0) {
    const std::int64_t first = std::ranges::find_if(seen.grey.values, is_odd) - seen.grey.values.begin();
    const Index3& n = seen.grey.info.size;
    table.faults().add(line, is_own ? path : path + ".image", "grey values that are numbers, in every voxel",
                       fmt::format("{} voxels without a finite one, the first at [{}, {}, {}]", n_odd,
                                   first % n[0], first / n[0] % n[1], first / n[0] / n[1]));
    return;
  }
  const auto [least, largest] = std::ranges::minmax(seen.grey.values);
  seen.least = least;
  seen.largest = largest;
  const auto range = seen.look.visible_range();
  if (seen.look.mode == LookMode::isosurface && !(seen.look.isovalue <= largest)) {
    table.faults().add(line, path + ".isovalue",
                       fmt::format("a value that the image reaches, {} to {}", seen.least, seen.largest),
                       fmt::format("{}", seen.look.isovalue));
    return;
  }
  if (!range || range->first > largest || range->second < least) {
    table.faults().add(
        line, path,
        fmt::format("opacity above 0 for values that the image has, {} to {}", seen.least, seen.largest),
        range ? fmt::format("opacity from {} to {}", range->first, range->second)
              : std::string("none above 0"));
    return;
  }
  cut_to_visible(seen.grey, seen.look);
}

std::optional<Seen> read_seen(TableReader table) {
  const auto look = reader::read_look(table);
  if (!look)
    return std::nullopt;
  Seen seen;
  seen.look = *look;
  if (look->of_grey_values)
    fill_grey(table, seen);
  std::error_code unknown;
  if (!look->picture.empty() && !std::filesystem::is_regular_file(look->picture, unknown))
    table.faults().add(table.line_of_key("look"), table.path_of("look") + ".picture", "a file",
                       fmt::format("nothing at \"{}\"", look->picture));
  return seen;
}

} // namespace

std::vector<std::optional<Seen>> read_looks(const std::filesystem::path& scene_file) {
  FaultList faults(scene_file.string());
  const toml::table document = parse_toml(read_text_file(scene_file, "a scene file"), scene_file.string());
  TableReader root(document, "", faults, "scene");
  read_units(root);
  std::vector<std::optional<Seen>> looks;
  if (const auto* specimen = document["specimen"].as_table())
    looks.push_back(read_seen(TableReader(*specimen, "specimen", faults, "specimen")));
  if (const auto* objects = document["object"].as_array())
    for (std::size_t i = 0; i < objects->size(); ++i)
      if (const auto* object = objects->get(i)->as_table())
        looks.push_back(read_seen(TableReader(*object, fmt::format("object[{}]", i + 1), faults, "object")));
  faults.throw_if_any();
  return looks;
}

bool has_look(const std::filesystem::path& file) {
  return reader::is_set(file, "specimen.look");
}

} // namespace maille
