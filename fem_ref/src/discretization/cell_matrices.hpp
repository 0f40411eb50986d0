#pragma once
/// The stiffness matrices of a scene's cells.

#include "discretization/element.hpp"

#include "maille/scene/scene.hpp"

#include <algorithm>
#include <deal.II/lac/full_matrix.h>
#include <functional>
#include <vector>

namespace maille::fem_ref {

/// Stiffness matrices of cells. Cells of equal material and fibre share one matrix, computed once.
template<int dim>
class CellMatrices {
public:
  /// @param positions  node positions of a mesh cell, by its number; none: all cells are congruent
  CellMatrices(const Scene& scene, const Element<dim>& element, std::function<Eigen::MatrixXd(int)> positions)
      : scene_(&scene), element_(&element), positions_(std::move(positions)),
        of_material_(scene.materials.size()), scratch_(static_cast<unsigned>(element.n_unknowns())) {}

  const dealii::FullMatrix<double>& operator()(std::int64_t cell, int mesh_cell) {
    if (positions_) {
      const Eigen::MatrixXd X = positions_(mesh_cell),
                            K = scene_->specimen.tissue_of(cell) *
                                MappedCell<dim>(*element_, X).stiffness(scene_->cell_stiffness(cell));
      std::copy_n(K.data(), K.size(), &scratch_(0, 0));
      return scratch_;
    }
    const std::uint8_t material = scene_->specimen.material(cell);
    const bool shared =
        !scene_->specimen.has_weights() &&
        (scene_->specimen.fibres.empty() || scene_->materials[material].elasticity.is_isotropic());
    dealii::FullMatrix<double>& K = shared ? of_material_[material] : scratch_;
    if (shared && K.m() > 0)
      return K;
    K.reinit(scratch_.m(), scratch_.m(), true);
    element_->stiffness(scene_->specimen.tissue_of(cell) * scene_->cell_stiffness(cell), &K(0, 0));
    return K;
  }

private:
  const Scene* scene_;
  const Element<dim>* element_;
  std::function<Eigen::MatrixXd(int)> positions_;
  std::vector<dealii::FullMatrix<double>> of_material_;
  dealii::FullMatrix<double> scratch_;
};

} // namespace maille::fem_ref
