#pragma once
/// The parts of the next coarser level of the componentwise multigrid.
///
/// Scheme: every second node along the axes that coarsen, linear interpolation in the positions of nodes;
/// coarse weights preserve the energy of linear displacements; coarse nodes are fixed where fine ones are, or
/// where fixed nodes have half of the interpolation weight; anchors hold corrections back beside fixed nodes.
///
/// Exact: the energy of linear displacements. Heuristic: the share of one half, and the bound of anchors.

#include "elastic/componentwise/componentwise_level.hpp"

namespace maille::deform {

/// A level and the nodes of the next coarser one.
class GridPair {
public:
  /// The coarse nodes that a fine one is interpolated from, and their weights.
  struct Parents {
    std::array<std::int64_t, 8> node{};
    std::array<double, 8> weight{};
    std::size_t n = 0;
  };

  /// @param fine with its transfer made; must outlive this
  explicit GridPair(const ComponentwiseLevel& fine);

  const ComponentwiseLevel& fine() const { return fine_; }
  const Index3& coarse_nodes() const { return coarse_nodes_; }
  std::int64_t n_coarse() const {
    return std::int64_t{1} * coarse_nodes_[0] * coarse_nodes_[1] * coarse_nodes_[2];
  }
  std::int64_t coarse_node(const Index3& at) const {
    return at[0] + coarse_nodes_[0] * (at[1] + std::int64_t{1} * coarse_nodes_[1] * at[2]);
  }
  Index3 coarse_node_at(std::int64_t node) const;
  /// From the number of a coarse node to that of the next along an axis.
  std::int64_t coarse_step(std::size_t a) const {
    return a == 0 ? 1 : a == 1 ? coarse_nodes_[0] : std::int64_t{1} * coarse_nodes_[0] * coarse_nodes_[1];
  }
  const AxisCoarsening& axis(std::size_t a) const { return fine_.transfer()[a]; }
  Parents parents(const Index3& fine) const;
  /// Sum of the interpolation weights of the fine nodes of matter on a coarse node.
  double matter_at(const Index3& coarse) const;

private:
  const ComponentwiseLevel& fine_;
  Index3 coarse_nodes_{};
};

/// Preserves the energy of linear displacements, axis by axis: weights of parallel links add up, distributed
/// by the hat functions; weights of links in series scale with the square of their share of the length. This
/// is the arithmetic mean of the material around a coarse link; cells without material count as zero. Never
/// softer than the Galerkin product, since (sum hat d)^2 <= sum hat d^2.
LinkWeights coarse_weights(const GridPair& grids);

/// A coarse node is fixed if the fine node at its position is, or if fixed nodes have at least the
/// interpolation weight of free nodes around it. Without the second condition, vertices in void beside a hold
/// stay free (docs/theory.md, 7b).
List<FixedNode> coarse_fixed(const GridPair& grids);

/// Anchors prevent overshoot of coarse corrections beside fixed nodes, where interpolation is cut off. A link
/// from a free node i to a fixed one costs w (P u)_i^2 <= w s_i sum_I P_iI u_I^2, s_i the sum of P_iI over
/// free coarse nodes I (Cauchy and Schwarz). Coarse links between a free and a fixed node count a part of it;
/// the anchor is the rest.
Anchors coarse_anchors(const GridPair& grids, const List<FixedNode>& coarse_fixed);

} // namespace maille::deform
