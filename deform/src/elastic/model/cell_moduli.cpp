#include "elastic/model/cell_moduli.hpp"

namespace maille::deform {

namespace {

/// The material's factors on the moduli along the grid's axes, turned as slack is.
Vec3 weights_of(const Scene& scene, std::int64_t cell) {
  const auto& along_material = scene.materials[scene.specimen.material(cell)].relaxed_weights;
  if (along_material == std::array<double, 3>{1, 1, 1})
    return {1, 1, 1}; // to the bit: squares of a turn's entries add up to 1 only but for rounding
  const Eigen::Matrix3d axes = scene.material_axes(cell);
  Vec3 weights{};
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < 3; ++i)
      weights[a] += axes(a, i) * axes(a, i) * along_material[i];
  return weights;
}

CellModuli::Table diagonal_of(const Scene& scene, std::int64_t cell, CellModuli::Weights which) {
  if (which == CellModuli::Weights::equal)
    return {{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
  const Vec3 weights = which == CellModuli::Weights::of_relaxed ? weights_of(scene, cell) : Vec3{1, 1, 1};
  const Eigen::MatrixXd C = scene.cell_stiffness(cell);
  CellModuli::Table table{};
  const int dimension = scene.dimension();
  for (int a = 0; a < dimension; ++a)
    for (int b = 0; b < dimension; ++b) {
      // Voigt: xx yy zz yz xz xy in 3D, xx yy xy in 2D
      const int row = a == b ? a : dimension == 3 ? 6 - a - b : 2;
      table[a][b] = scene.specimen.tissue_of(cell) * C(row, row) * (a == b ? weights[a] : 1);
    }
  return table;
}

} // namespace

CellModuli::CellModuli(const Scene& scene, Weights weights) : specimen_(&scene.specimen) {
  const Specimen& body = scene.specimen;
  const std::int64_t n = body.grid.n_cells();
  const bool turns = !body.fibres.empty() || body.has_weights();
  std::vector<bool> is_known(scene.materials.size(), false);
  kinds_.resize(turns ? 0 : scene.materials.size());
  if (turns) {
    per_cell_.assign(n, -1);
    kinds_.reserve(body.n_matter_cells());
  }
  bool is_first = true;
  for (std::int64_t cell = 0; cell < n; ++cell) {
    if (!body.is_matter(cell)) {
      is_homogeneous_box_ = false;
      continue;
    }
    const std::uint8_t material = body.material(cell);
    if (turns) {
      per_cell_[cell] = static_cast<std::int32_t>(kinds_.size());
      kinds_.push_back(diagonal_of(scene, cell, weights));
    } else if (!is_known[material]) {
      is_known[material] = true;
      kinds_[material] = diagonal_of(scene, cell, weights);
    }
    if (is_first)
      first_kind_ = kind(cell);
    is_first = false;
    is_homogeneous_box_ = is_homogeneous_box_ && kinds_[kind(cell)] == kinds_[first_kind_];
    if (body.material_id.empty() && !turns)
      break; // the others are like the first
  }
}

} // namespace maille::deform
