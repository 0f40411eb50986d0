#pragma once
/// The stiffness of a body in two or three dimensions as a sparse matrix.

#include "elastic/model/fixed_mask.hpp"
#include "elastic/model/lattice_elasticity.hpp"

#include <Eigen/SparseCore>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace maille::deform {

/// The stiffness of one cell [N/m], from unit displacements of its corners; row and column dimension *
/// corner + component. @tparam dimension that of the scene
template<int dimension>
Eigen::MatrixXd cell_stiffness(const LatticeElasticity& elasticity, std::int64_t cell);

/// Nodes of matter, in the order of the grid.
std::vector<std::int64_t> nodes_of_matter(const Specimen& body);

/// Block by block: of a node with itself and with the 13 that come after it in the grid (4 in a plane).
///
/// Cost  O(cells), a cell's matrix once a kind of matter; 1.1 KB a node
class StiffnessBlocks {
public:
  /// With the springs of `elasticity`. @param body outlives this
  /// @param nodes all of the matter's, in the order of the grid
  StiffnessBlocks(const Specimen& body, const LatticeElasticity& elasticity,
                  const std::vector<std::int64_t>& nodes);
  /// Adds a spring between a component of a node of matter and of the next node along an axis of one cell.
  void add_spring(std::int64_t node, int axis, int component, double stiffness);
  /// The lower triangle of the free components dimension * place + component, in this order. @param fixed by
  /// place
  /// @param group if not null, receives the number of the node of each unknown, from 0 on
  Eigen::SparseMatrix<double> lower(const FixedMask& fixed, std::vector<std::int32_t>* group = nullptr) const;

private:
  struct Block {
    std::int32_t node = -1;
    Eigen::Matrix3d values = Eigen::Matrix3d::Zero();
  };
  Block& block(std::int64_t near, int after); ///< of a node of the grid

  const Grid& grid_;
  std::vector<std::int32_t> place_;  ///< in `nodes`, by node of the grid; -1: none
  using Row = std::array<Block, 14>; ///< the node itself and its 13 neighbours that follow it in the grid
  std::vector<Row> rows_;
};

} // namespace maille::deform
