#include "answer_fields.hpp"

#include "body_pieces.hpp"
#include "maille/materials/fault.hpp"
#include "maille/scene/voxel_map.hpp"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <stdexcept>
#include <vector>

namespace maille::studies {
namespace fs = std::filesystem;

namespace {

constexpr std::array<const char*, 4> names{"Displacement", "DisplacementReference", "DisplacementError",
                                           "DisplacementErrorEstimate"};

/// Copies arrays of some nodes into fields of all nodes, which are created on first use.
void add_fields(const fs::path& file, const VtkArrays& arrays, const Scene& scene,
                const BodyNumbering& numbering,
                std::array<std::optional<Displacement>, names.size()>& fields) {
  if (arrays.points != std::ssize(numbering.nodes))
    throw InputError(
        {{file.string(), 0, "", fmt::format("{} points, as the scene's body has", numbering.nodes.size()),
          fmt::format("{}", arrays.points)}});
  const double in_a_metre = arrays.units.starts_with("lengths: mm") ? 1e3 : 1;
  for (std::size_t f = 0; f < names.size(); ++f) {
    const std::vector<double>& values = arrays.at_nodes.at(names[f]);
    if (values.size() != 3 * numbering.nodes.size())
      continue;
    Displacement& all = fields[f] ? *fields[f] : fields[f].emplace(scene.specimen.grid);
    auto at = values.begin();
    for (const std::int64_t node : numbering.nodes) {
      const Vec3 value = to_object(scene.specimen.placement, Vec3{at[0], at[1], at[2]});
      at += 3;
      for (int c = 0; c < scene.dimension(); ++c)
        all(c, node) = value[c] / in_a_metre;
    }
  }
}

} // namespace

AnswerFields read_answer_fields(const Scene& scene, const std::filesystem::path& file) {
  if (!std::filesystem::exists(file))
    throw std::runtime_error("there is no " + file.string());
  std::array<std::optional<Displacement>, names.size()> fields;
  const auto read = [&](const fs::path& part) {
    return read_vtk_arrays(part, {names.begin(), names.end()}, scene.specimen.grid.n_nodes());
  };
  if (file.extension() == ".pvtu")
    for (std::size_t i = 0; fs::exists(file_of_piece(file, i)); ++i) {
      const VtkArrays arrays = read(file_of_piece(file, i));
      const std::vector<double>& layers = arrays.layers;
      const int n = scene.dimension() == 3 ? scene.specimen.grid.cells()[2] : 0;
      if (layers.size() != 2 || !(layers[0] >= 0 && layers[0] < layers[1] && layers[1] <= n))
        throw std::runtime_error(file_of_piece(file, i).string() + " is of another grid");
      add_fields(file_of_piece(file, i), arrays, scene,
                 numbering_of(scene.specimen, {static_cast<int>(layers[0]), static_cast<int>(layers[1])}),
                 fields);
    }
  else
    add_fields(file, read(file), scene,
               file.extension() == ".vti" ? whole_grid(scene.specimen.grid) : matter_only(scene.specimen),
               fields);
  if (!fields[0])
    throw std::runtime_error(file.string() + " holds no Displacement");
  return {std::move(*fields[0]), std::move(fields[1]), std::move(fields[2]), std::move(fields[3])};
}

} // namespace maille::studies
