#pragma once
/// The stiffness of a body in three dimensions as a sparse matrix.

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

/// Block by block: of a node with itself and with the 13 that come after it in the grid.
///
/// Cost  O(cells), a cell's matrix once a kind of matter; 1.1 KB a node
class StiffnessBlocks {
public:
  /// With the springs of `elasticity`. @param nodes all of the matter's, in the order of the grid
  StiffnessBlocks(const Specimen& body, const LatticeElasticity& elasticity,
                  const std::vector<std::int64_t>& nodes);
  /// A spring between components of two nodes of one cell. @param near, far places in `nodes`, ascending
  /// @param after   how many nodes after near far is: 1 + 3 + 9 for one along each axis
  void add_spring(std::size_t near, std::size_t far, std::size_t after, int component, double stiffness);
  /// The lower triangle, of components 3 * place + component that are not fixed, which keep their order.
  /// @param group if not null, becomes the node of each that has some, from 0 on
  Eigen::SparseMatrix<double> lower(const std::vector<char>& is_fixed,
                                    std::vector<std::int32_t>* group = nullptr) const;

private:
  static constexpr std::size_t n_after = 14;
  struct Block {
    std::int32_t node = -1;
    Eigen::Matrix3d values = Eigen::Matrix3d::Zero();
  };
  std::vector<std::array<Block, n_after>> rows_;
};

} // namespace maille::deform
