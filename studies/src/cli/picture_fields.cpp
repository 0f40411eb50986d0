#include "picture_fields.hpp"

#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/materials/toml_reader.hpp"
#include "maille/scene/cell_fields.hpp"

#include <Eigen/Eigenvalues>

namespace maille::studies {

namespace {

double largest_principal(const std::array<double, 6>& t) {
  Eigen::Matrix3d matrix;
  matrix << t[0], t[3], t[5], t[3], t[1], t[4], t[5], t[4], t[2];
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .cwiseAbs()
      .maxCoeff();
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
    const toml::table root = parse_toml(read_text_file(scene, "a scene file"), scene.string());
    const auto image = root["specimen"]["image"].value<std::string>();
    return image && (image->ends_with(".nii") || image->ends_with(".nii.gz"));
  } catch (const InputError&) {
    return false;
  }
}

} // namespace maille::studies
