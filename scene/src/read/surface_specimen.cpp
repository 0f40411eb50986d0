// A body from closed surfaces: `shape = "surface"`.

#include "conditions/voxelise.hpp"
#include "read/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

/// `surface`: one name of a file, or a list of them.
std::vector<std::string> read_names(TableReader& table) {
  const toml::node* node = table.require("surface");
  std::vector<std::string> names;
  if (!node)
    return names;
  if (const auto name = node->value<std::string>())
    return {*name};
  const auto* list = node->as_array();
  for (std::size_t i = 0; list && i < list->size(); ++i)
    if (const auto name = list->get(i)->value<std::string>())
      names.push_back(*name);
  if (!list || names.empty() || names.size() != list->size() || names.size() > 255) {
    table.fault("surface", table.missing("surface"));
    names.clear();
  }
  return names;
}

/// All surfaces, in metres; a fault if they do not state the same frame.
bool read_meshes(const std::vector<std::string>& names, double metres, TableReader& table,
                 std::vector<std::vector<Triangle>>& surfaces, std::optional<CoordinateFrame>& frame) {
  const std::string path = table.path_of("surface");
  const int line = table.line_of_key("surface");
  bool is_good = true;
  for (const std::string& name : names) {
    const auto file = resolve_path(name, path, line, table.faults());
    if (!file) {
      is_good = false;
      continue;
    }
    try {
      SurfaceMesh mesh = read_surface_mesh(*file, metres);
      if (!surfaces.empty() && mesh.frame != frame) {
        table.fault("surface", "files that state the same frame, SPACE=RAS or SPACE=LPS, or none", name);
        is_good = false;
      }
      frame = mesh.frame;
      surfaces.push_back(std::move(mesh.triangles));
    } catch (const InputError& error) {
      adopt(error, path, line, table.faults());
      is_good = false;
    }
  }
  return is_good && !surfaces.empty();
}

} // namespace

bool read_surface_specimen(TableReader& table, bool has_material,
                           const std::optional<Vec3>& spacing_otherwise, MaterialTable& materials,
                           Scene& scene, std::vector<float>* labels) {
  const auto names = read_names(table);
  const double metres = read_unit(table);
  const auto spacing = read_spacing(table, 3, spacing_otherwise);
  std::vector<std::vector<Triangle>> surfaces;
  std::optional<CoordinateFrame> frame;
  const auto without_body = [&] { // avoids faults for the other keys
    read_material(table, false, materials);
    for (const char* key : {"labels", "fibre", "coarsen", "threshold"})
      table.find(key);
    return false;
  };
  if (!read_meshes(names, metres, table, surfaces, frame) || !spacing)
    return without_body();
  const auto n = voxels_of(surfaces, *spacing);
  if (!(n[0] * n[1] * n[2] < 2e9) || std::ranges::max(n) > 1e6 ||
      !fits_into_memory({static_cast<int>(n[0]), static_cast<int>(n[1]), static_cast<int>(n[2])}, 3,
                        table.path_of("spacing"), table.line_of_key("spacing"), table.faults())) {
    table.fault("spacing", "one at which the surfaces' box holds fewer than 2e9 voxels",
                fmt::format("{:.3g} x {:.3g} x {:.3g} voxels", n[0], n[1], n[2]));
    return without_body();
  }
  std::vector<std::string> lost;
  auto made = voxelised(surfaces, *spacing, &lost);
  if (const auto* fault = std::get_if<RegionFault>(&made)) {
    table.fault("surface", fault->expected, fault->found);
    return without_body();
  }
  for (std::string& text : lost)
    scene.left_out.push_back({0, std::move(text)});
  Image& image = std::get<Image>(made);
  if (frame)
    image.info.world = *frame == CoordinateFrame::lps ? WorldAxes::lps : WorldAxes::ras;
  if (!read_image_specimen(table, has_material, materials, scene, labels, &image))
    return false;
  for (std::size_t i = 0; table.has("labels") && i < names.size(); ++i)
    if (std::ranges::find(scene.specimen.label, static_cast<std::int32_t>(i + 1)) ==
        scene.specimen.label.end())
      scene.left_out.push_back(
          {0,
           fmt::format("surface {} has no cells: is its label, {}, in [specimen] labels?", names[i], i + 1)});
  return true;
}

} // namespace maille::reader
