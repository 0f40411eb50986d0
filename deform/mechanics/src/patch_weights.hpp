#pragma once
/// Which cells around a node tell what a field of means of cells is worth at it, and how much each counts.

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace maille {

/// The polynomial of degree 2 nearest to the means of a patch of cells in weighted least squares, at the node
/// in their middle. Patches are bits of a word: 4 cells along every axis of the dimension, x fastest.
///
/// Degree by degree: linear fields are exact as far as the patch can tell them, across a flat patch there is
/// no slope, of a single cell it is the constant; what squares the patch tells badly are damped. Axes in
/// another order give the same weights, to rounding.
class PatchWeights {
public:
  static constexpr int across = 4;
  /// Of 1; x y z; xx xy xz yy yz zz, in cells from the node.
  using Coefficients = Eigen::Matrix<double, 10, 1>;
  static constexpr int monomials = Coefficients::SizeAtCompileTime;

  explicit PatchWeights(int dimension);

  /// Those of `cells` that are joined to one at the node through faces of cells in it.
  std::uint64_t joined(std::uint64_t cells) const;
  /// What weight() takes for the cells of a patch. @pre `patch` is not 0
  /// Cost  2 us for the first patch of its shape, then a look-up
  const Coefficients& of(std::uint64_t patch);
  /// The field at the node is the sum of the cells' values by these.
  double weight(int bit, const Coefficients& of_patch) const { return weighted_[bit].dot(of_patch); }

private:
  using Moments = Eigen::Matrix<double, monomials, monomials>;

  Coefficients fit(std::uint64_t patch) const;

  int dimension_;
  std::uint64_t at_node_ = 0;
  std::array<std::uint64_t, 3> not_first_{}, not_last_{}; ///< along every axis
  std::vector<Coefficients>
      weighted_; ///< of every bit the means of the monomials over the cell, by its weight
  std::vector<std::array<Moments, 1 << across>>
      moments_; ///< of every row along x, by which of its cells are there
  std::unordered_map<std::uint64_t, Coefficients> known_;
};

} // namespace maille
