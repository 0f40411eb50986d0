#include "export/voxel_maps.hpp"

#include "body_numbering.hpp"
#include "export/whole_file.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/sliding.hpp"
#include "maille/scene/voxel_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

/// Placement that rotates vectors from the object's frame to the frame of the written file.
Placement written_frame(const Specimen& body) {
  Placement placement = body.placement;
  if (placement.world == WorldAxes::lps)
    for (std::size_t row = 0; row < 2; ++row)
      for (double& component : placement.direction[row])
        component = -component;
  return placement;
}

/// Displacement at voxel centres, interpolated between the corners of the cell [mm], in `frame`.
std::optional<Image> displacement_of_voxels(const ImageInfo& info, const Scene& scene, const Answer& answer,
                                            const Placement& frame) {
  const Specimen& body = scene.specimen;
  const auto blocks = voxel_blocks(info, body);
  auto image = on_voxels(info, body, 3, [](std::int64_t, std::span<float>) {});
  if (!blocks || !image)
    return std::nullopt;
  image->info = in_world(image->info, WorldAxes::ras);
  image->info.vectors_to_world = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const DisplacementOfCells u(body, answer);
  const std::size_t n = info.n_voxels();
  for (std::size_t voxel = 0; voxel < n; ++voxel) {
    const auto row = static_cast<std::int64_t>(voxel) / info.size[0];
    const Index3 at{static_cast<int>(static_cast<std::int64_t>(voxel) % info.size[0]),
                    static_cast<int>(row % info.size[1]), static_cast<int>(row / info.size[1])};
    Index3 cell{};
    Vec3 part{};
    bool is_inside = true;
    for (std::size_t a = 0; a < 3; ++a) {
      const int from_first = at[a] - blocks->first[a], per_cell = blocks->per_cell[a];
      is_inside = is_inside && from_first >= 0;
      cell[a] = from_first / per_cell;
      part[a] = (from_first % per_cell + 0.5) / per_cell;
    }
    if (!is_inside || !body.grid.has_cell(cell) || !body.is_matter(body.grid.cell(cell)))
      continue;
    constexpr double millimetres = 1e3;
    const Vec3 world = to_world(frame, u.within(body.grid.cell(cell), part));
    for (std::size_t a = 0; a < 3; ++a)
      image->values[a * n + voxel] = static_cast<float>(millimetres * world[a]);
  }
  return image;
}

} // namespace

std::string why_no_maps(const Scene& scene) {
  const Specimen& body = scene.specimen;
  if (body.image.empty())
    return "a body from an image, on whose voxels maps lie, found shape = \"" + body.shape + "\"";
  if (scene.dimension() != 3)
    return "a three-dimensional body, found an image of one slice";
  if (!voxel_blocks(read_image_info(body.image), body))
    return "a body on the voxels of its image, found one on a lattice of its own";
  return "";
}

std::vector<fs::path> write_voxel_maps(const Scene& scene, const Answer& answer, bool has_stress,
                                       const fs::path& stem) {
  const Specimen& body = scene.specimen;
  const ImageInfo info = read_image_info(body.image);
  const Placement frame = written_frame(body);
  const CellFields fields = cell_fields(scene, answer);
  std::vector<fs::path> files;
  const auto put = [&](const char* name, const std::optional<Image>& image) {
    if (!image)
      throw std::runtime_error("the voxels of " + body.image +
                               " are no longer those that the body was read from");
    fs::path file = stem;
    file += fmt::format("_{}.nii.gz", name);
    write_whole(file, [&](const fs::path& unfinished) {
      write_nifti(*image, unfinished, image->info.components == 6 ? StoredAs::tensors : StoredAs::float32);
    });
    files.push_back(file);
  };
  const auto write = [&](const char* name, int components, const auto& values) {
    put(name, on_voxels(info, body, components, values));
  };
  const auto tensors = [&](const std::vector<std::array<double, 6>>& of_cells) {
    return [&](std::int64_t cell, std::span<float> values) {
      const auto tensor = tensor_to_world(frame, of_cells[cell]);
      std::copy(tensor.begin(), tensor.end(), values.begin());
      std::swap(values[4], values[5]); // images store xz before yz
    };
  };
  const auto along_fibres = [&](const std::vector<std::array<double, 6>>& of_cells) {
    return [&](std::int64_t cell, std::span<float> values) {
      values[0] = static_cast<float>(along(of_cells[cell], body.fibre_of(cell)));
    };
  };
  write("strain", 6, tensors(fields.strain));
  put("displacement", displacement_of_voxels(info, scene, answer, frame));
  if (scene.has_fibres())
    write("fibre_strain", 1, along_fibres(fields.strain));
  if (!has_stress)
    return files;
  write("stress", 6, tensors(fields.stress));
  write("von_mises", 1, [&](std::int64_t cell, std::span<float> values) {
    values[0] = static_cast<float>(fields.von_mises[cell]);
  });
  if (scene.has_fibres())
    write("fibre_stress", 1, along_fibres(fields.stress));
  return files;
}

} // namespace maille::studies
