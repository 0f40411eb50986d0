#include "relax/cell_moduli.hpp"

namespace maille::deform {

namespace {

CellModuli::Table diagonal_of(const Scene& scene, std::int64_t cell) {
  const Eigen::MatrixXd C = scene.cell_stiffness(cell);
  CellModuli::Table table{};
  const int dimension = scene.dimension();
  for (int a = 0; a < dimension; ++a)
    for (int b = 0; b < dimension; ++b) {
      // Voigt: xx yy zz yz xz xy in 3D, xx yy xy in 2D
      const int row = a == b ? a : dimension == 3 ? 6 - a - b : 2;
      table[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)] = C(row, row);
    }
  return table;
}

} // namespace

CellModuli::CellModuli(const Scene& scene) : specimen_(&scene.specimen) {
  const Specimen& body = scene.specimen;
  const std::int64_t n = body.grid.n_cells();
  const bool turns = !body.fibres.empty();
  std::vector<bool> is_known(scene.materials.size(), false);
  kinds_.resize(turns ? 0 : scene.materials.size());
  if (turns)
    per_cell_.assign(static_cast<std::size_t>(n), -1);
  bool is_first = true;
  for (std::int64_t cell = 0; cell < n; ++cell) {
    if (!body.is_matter(cell)) {
      is_homogeneous_box_ = false;
      continue;
    }
    const std::uint8_t material = body.material(cell);
    if (turns) {
      per_cell_[static_cast<std::size_t>(cell)] = static_cast<std::int32_t>(kinds_.size());
      kinds_.push_back(diagonal_of(scene, cell));
    } else if (!is_known[material]) {
      is_known[material] = true;
      kinds_[material] = diagonal_of(scene, cell);
    }
    if (is_first)
      first_kind_ = kind(cell);
    is_first = false;
    is_homogeneous_box_ = is_homogeneous_box_ && kinds_[kind(cell)] == kinds_[first_kind_];
    if (body.material_id.empty() && !turns)
      break; // the others are like the first
  }
}

std::int64_t CellModuli::bytes() const {
  return static_cast<std::int64_t>(kinds_.size() * sizeof(Table) + per_cell_.size() * sizeof(std::int32_t));
}

} // namespace maille::deform
