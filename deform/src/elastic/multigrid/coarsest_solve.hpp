#pragma once
/// The direct solve at the bottom of a multigrid.

#include "maille/base/arena.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <vector>

namespace maille::deform {

/// A single layer of unknowns is solved by the inverse of its matrix, without zero-energy motions (rounding
/// gives these a tiny stiffness). Several layers, each coupled to the next only, are solved by a
/// block-tridiagonal Cholesky factor in float64.
class CoarsestSolve {
public:
  struct Unknowns {
    List<std::int64_t> place; ///< in the fields of the level, layer by layer
    List<std::size_t> first;  ///< of each layer in `place`, and their number
    /// Entries were rounded to float32: a free motion cannot be told from a soft one.
    bool are_rounded = false;
    void begin_layer() { first.push_back(place.size()); }
    /// Number of the unknown at each place of a field of that size, or -1.
    List<std::int32_t> numbers(std::size_t field_size) const;
  };
  /// An entry of the matrix, or a part of one, by the numbers of its row and column.
  using Visit = std::function<void(std::size_t row, std::size_t column, double value)>;

  /// @param unknowns with the end of the last layer
  explicit CoarsestSolve(Unknowns unknowns) : unknowns_(std::move(unknowns)) {}

  const Unknowns& unknowns() const { return unknowns_; }
  /// @param for_each_entry calls its argument for all entries of a symmetric matrix
  /// @return false if the layers are not fixed well enough to be factored
  bool factor(const std::function<void(const Visit&)>& for_each_entry);
  /// u += A^-1 f at the unknowns.
  void add_solution(const float* f, float* u) const;

private:
  std::size_t n_layers() const { return unknowns_.first.size() - 1; }
  Eigen::Index size(std::size_t layer) const {
    return static_cast<Eigen::Index>(unknowns_.first[layer + 1] - unknowns_.first[layer]);
  }
  void invert(Eigen::MatrixXd K);
  bool factor_layers();

  Unknowns unknowns_;
  Eigen::MatrixXf inverse_;                     ///< of a single layer
  std::vector<Eigen::MatrixXd> lower_, beside_; ///< per layer: its factor, and that towards the layer before
  Charge of_matrices_;
};

} // namespace maille::deform
