#include "answer_fields.hpp"

#include "body_pieces.hpp"
#include "maille/scene/voxel_map.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace maille::studies {
namespace fs = std::filesystem;

namespace {

/// Copies an array of some nodes into a field of all nodes, which is created on first use.
void add_field(const fs::path& file, const char* name, const Scene& scene, const BodyNumbering& numbering,
               std::optional<Displacement>& all) {
  const std::vector<double> values = read_vtk_array(file, name, std::ssize(numbering.nodes), 3);
  if (values.empty())
    return;
  if (!all)
    all.emplace(scene.specimen.grid);
  constexpr std::string_view millimetres = "lengths: mm";
  const double in_a_metre =
      std::ranges::equal(read_vtk_array(file, "Units", 0, std::ssize(millimetres)), millimetres) ? 1e3 : 1;
  auto at = values.begin();
  for (const std::int64_t node : numbering.nodes) {
    Vec3 value{at[0], at[1], at[2]};
    at += 3;
    value = to_object(scene.specimen.placement, value);
    for (int c = 0; c < scene.dimension(); ++c)
      (*all)(c, node) = value[static_cast<std::size_t>(c)] / in_a_metre;
  }
}

} // namespace

AnswerFields read_answer_fields(const Scene& scene, const std::filesystem::path& file) {
  if (!std::filesystem::exists(file))
    throw std::runtime_error("there is no " + file.string());
  AnswerFields fields;
  std::optional<Displacement> displacement;
  const auto add = [&](const fs::path& part, const BodyNumbering& numbering) {
    add_field(part, "Displacement", scene, numbering, displacement);
    add_field(part, "DisplacementReference", scene, numbering, fields.reference);
    add_field(part, "DisplacementError", scene, numbering, fields.error);
    add_field(part, "DisplacementErrorEstimate", scene, numbering, fields.estimate);
  };
  if (file.extension() == ".pvtu")
    for (std::size_t i = 0; fs::exists(file_of_piece(file, i)); ++i) {
      const std::vector<double> layers = read_vtk_array(file_of_piece(file, i), "Layers", 0, 2);
      const int n = scene.dimension() == 3 ? scene.specimen.grid.cells()[2] : 0;
      if (layers.size() != 2 || !(layers[0] >= 0 && layers[0] < layers[1] && layers[1] <= n))
        throw std::runtime_error(file_of_piece(file, i).string() + " is of another grid");
      add(file_of_piece(file, i),
          numbering_of(scene.specimen, {static_cast<int>(layers[0]), static_cast<int>(layers[1])}));
    }
  else
    add(file, file.extension() == ".vti" ? whole_grid(scene.specimen.grid) : matter_only(scene.specimen));
  if (!displacement)
    throw std::runtime_error(file.string() + " holds no Displacement");
  fields.displacement = std::move(*displacement);
  return fields;
}

} // namespace maille::studies
