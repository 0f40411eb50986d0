#pragma once
/// Coarsening of one axis: which nodes the next coarser level has, and interpolation between both.

#include "elastic/componentwise/componentwise_kernel.hpp"

#include <array>
#include <ranges>
#include <vector>

namespace maille::deform {

/// The coarse axis has every second node and the last one. If the number of intervals is odd, its last
/// interval spans three, so lengths of intervals differ by less than a factor of 2 at any depth.
/// Interpolation is linear in the positions of nodes. An axis of two nodes becomes one node that carries
/// both.
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
  /// The coarse interval that contains the fine interval i, and the share of its length that interval i
  /// takes. @pre at least two coarse nodes
  int interval(int i) const;
  double part_of_interval(int i) const;
  /// Coarse planes whose restriction is complete after fine plane `i`, with one plane of look-ahead.
  std::ranges::iota_view<int, int> coarse_after(int i) const;

  /// For the loops; points into this.
  AxisTransfer view() const;

  /// Weights of the coarse links along this axis, which preserve the energy of linear displacements.
  std::vector<double> coarse_link(const std::vector<double>& fine) const;
  /// Masses of coarse nodes: fine masses distributed by the interpolation weights.
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
