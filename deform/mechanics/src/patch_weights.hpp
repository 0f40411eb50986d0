#pragma once
/// Weights of the cells around a node for the recovery of nodal values from cell means.

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace maille {

/// Value at the central node of the polynomial of degree 2 that fits the means of a patch of cells in
/// weighted least squares. Patches are bits of a word: 4 cells along every axis of the dimension, x fastest.
///
/// Fitted degree by degree: linear fields are exact as far as the patch determines them; a flat patch has no
/// slope across, and a single cell gives the constant; poorly determined quadratic terms are damped. Permuted
/// axes give the same weights, within rounding.
class PatchWeights {
public:
  static constexpr int across = 4;
  /// Of 1; x y z; xx xy xz yy yz zz, in cells from the node.
  using Coefficients = Eigen::Matrix<double, 10, 1>;
  static constexpr int monomials = Coefficients::SizeAtCompileTime;

  explicit PatchWeights(int dimension);

  /// Subset of `cells` that is connected to a cell at the node through faces of cells in `cells`.
  std::uint64_t joined(std::uint64_t cells) const;
  /// Coefficients of a patch for weight(). @pre `patch` is not 0
  /// Cost  2 us for the first patch of its shape, then a look-up
  const Coefficients& of(std::uint64_t patch);
  /// Weight of a cell: the field at the node is the weighted sum of the cells' values.
  double weight(int bit, const Coefficients& of_patch) const { return weighted_[bit].dot(of_patch); }

private:
  using Moments = Eigen::Matrix<double, monomials, monomials>;

  Coefficients fit(std::uint64_t patch) const;

  int dimension_;
  std::uint64_t at_node_ = 0;
  std::array<std::uint64_t, 3> not_first_{}, not_last_{}; ///< along every axis
  std::vector<Coefficients>
      weighted_; ///< by bit: weight of the cell times the means of the monomials over it
  std::vector<std::array<Moments, 1 << across>>
      moments_; ///< by row along x, and by the bits of its present cells
  std::unordered_map<std::uint64_t, Coefficients> known_;
};

} // namespace maille
