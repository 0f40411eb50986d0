#pragma once
/// The direct solve at the bottom of a box's multigrid.

#include "elastic/box/box_level.hpp"
#include "maille/scene/grid.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace maille::deform {

/// A few nodes by the inverse of their matrix, in which rigid motions that nothing holds stay out. A level
/// that is only one cell thick along some axis by Cholesky's factors, layer by layer along its longest axis,
/// in float64: interpolation along such a beam or plate is far too stiff in bending, and coarser levels would
/// be of no help.
class BoxCoarsest {
public:
  /// Whether a level is to be the last one. @param n_finest nodes of the finest: factors may cost about as
  /// much as some cycles on it
  static bool is_small(const BoxLevel& level);
  static bool is_thin(const BoxLevel& level, std::int64_t n_finest);

  /// What it will hold on the coarser levels of a box of that stiffness.
  static std::int64_t bytes_at_most(const BoxLevel::Stiffness& C, const Grid& grid);

  /// @param level must outlive this
  explicit BoxCoarsest(const BoxLevel& level);
  /// Of the level's operator with its penalized links. @return false where a thin level is not held well
  /// enough to be factored
  bool factor();
  /// level.u = A^-1 level.f where nodes may move.
  void solve(BoxLevel& level) const;
  std::int64_t bytes() const;

private:
  void number_unknowns();
  template<class Visit>
  void for_each_entry(const Visit& visit) const;
  void factor_small();
  bool factor_layers();
  std::int64_t n_nodes() const { return level_.n_nodes(); }

  const BoxLevel& level_;
  int along_ = 0; ///< axis of the layers; all nodes are one layer where the level is small
  std::vector<std::int64_t> unknowns_;          ///< places in the fields, layer by layer
  std::vector<std::size_t> first_;              ///< of each layer in unknowns_, and their number
  std::vector<std::int32_t> number_;            ///< by 3 node + component: place in unknowns_, or -1
  Eigen::MatrixXf inverse_;                     ///< of a small level
  std::vector<Eigen::MatrixXd> lower_, beside_; ///< per layer: its factor, and that towards the layer before
};

} // namespace maille::deform
