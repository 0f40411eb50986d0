#pragma once
/// How the nodes of one axis are thinned out for the next coarser level.

#include "elastic/componentwise/componentwise_kernel.hpp"

#include <array>
#include <ranges>
#include <vector>

namespace maille::deform {

/// Every second node and the last; the last interval of the coarse axis spans three where the number of
/// intervals is odd, so intervals differ by a factor below 2 at any depth. Interpolation is linear in the
/// places of the nodes. Two nodes become one that carries both.
class AxisCoarsening {
public:
  /// @param place of the nodes, ascending, in any unit; @param coarsens if false, both levels are the same
  AxisCoarsening(const std::vector<double>& place, bool coarsens);

  bool coarsens() const { return coarsens_; }
  int n_fine() const { return static_cast<int>(left_.size()); }
  int n_coarse() const { return static_cast<int>(first_.size()); }
  const std::vector<double>& coarse_place() const { return coarse_place_; }
  /// Weights of fine node i on coarse nodes left(i) and left(i) + 1.
  int left(int i) const { return left_[i]; }
  double right_weight(int i) const { return right_[i]; }
  /// Support of a coarse node.
  int first(int i) const { return first_[i]; }
  int count(int i) const { return count_[i]; }
  double hat(int i, int k) const { return hat_[i * most_in_support + k]; }
  /// The fine node in the place of a coarse one.
  int fine_place(int i) const { return fine_place_[i]; }
  /// The coarse interval that holds the one from fine node i to the next, and the part of it that this is.
  /// @pre two coarse nodes or more
  int interval(int i) const;
  double part_of_interval(int i) const;
  /// The coarse planes that can be summed up after fine plane `i`, looking one plane ahead.
  std::ranges::iota_view<int, int> coarse_after(int i) const;

  /// For the loops; points into this.
  AxisTransfer view() const;

  /// Weights of the coarse links along this axis: energies of linear displacements are kept.
  std::vector<double> coarse_link(const std::vector<double>& fine) const;
  /// What fine nodes carry, shared out to the coarse ones.
  std::vector<double> coarse_mass(const std::vector<double>& fine) const;

private:
  bool coarsens_;
  std::vector<double> coarse_place_;
  std::vector<int> fine_place_, left_, first_, count_;
  std::vector<float> right_, hat_;
};

/// Views of all three axes, for the kernels' loops.
inline std::array<AxisTransfer, 3> views(const std::array<AxisCoarsening, 3>& t) {
  return {t[0].view(), t[1].view(), t[2].view()};
}

} // namespace maille::deform
