#include "inputs.hpp"

#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/studies/picture/question_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::studies {

void keep_inputs(const std::vector<std::filesystem::path>& files) {
  for (const std::filesystem::path& file : files)
    keep_input(file);
}

std::string scene_text_of(const std::filesystem::path& file) {
  try {
    return read_text_file(file, "a scene file");
  } catch (const InputError&) {
    return {};
  }
}

namespace {

double largest_principal(const std::array<double, 6>& tensor) {
  const Vec3 values = principal_values(tensor);
  return std::max(std::abs(values[0]), std::abs(values[2]));
}

} // namespace

Displacement nodal_sizes(const Scene& scene, const Displacement& displacement, bool of_stress) {
  const CellFields fields = cell_fields(scene, displacement);
  const Specimen& body = scene.specimen;
  Displacement sizes(body.grid);
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
    double sum = 0;
    int n = 0;
    body.for_each_cell_at(body.grid.node_at(node), [&](std::int64_t cell) {
      const auto c = static_cast<std::size_t>(cell);
      sum += of_stress ? fields.von_mises[c] : largest_principal(fields.strain[c]);
      ++n;
    });
    sizes(0, node) = n > 0 ? sum / n : 0;
  }
  return sizes;
}

bool is_of_a_patient(const std::filesystem::path& scene) {
  try {
    return is_scene_of_a_patient(read_text_file(scene, "a scene file"));
  } catch (const InputError&) {
    return false;
  }
}

namespace {

std::int64_t count(const WorldScene& scene, ObjectKind kind) {
  return std::ranges::count(scene.objects, kind, &WorldObject::kind);
}

std::string cells_in_words(const WorldScene& scene) {
  std::string text = fmt::format("{}", scene.cells[0]);
  for (std::size_t a = 1; a < static_cast<std::size_t>(scene.dimension); ++a)
    text += fmt::format(" x {}", scene.cells[a]);
  return text;
}

} // namespace

std::string in_words(const WorldScene& scene) {
  return fmt::format("{}D world of {} cells, {} fixed, {} rigid, {} deformable object{}", scene.dimension,
                     cells_in_words(scene), count(scene, ObjectKind::fixed), count(scene, ObjectKind::rigid),
                     count(scene, ObjectKind::deformable), scene.objects.size() == 1 ? "" : "s");
}

} // namespace maille::studies
