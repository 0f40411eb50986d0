#include "elastic/corotated/quasi_newton.hpp"

#include <ranges>

namespace maille::deform {

void QuasiNewton::apply(Displacement& field,
                        const std::function<void(Displacement&, Displacement&)>& precondition) {
  std::vector<double> share;
  for (const Pair& pair : pairs_ | std::views::reverse) {
    share.push_back(pair.inverse * sums_.dot(pair.step, field));
    sums_.add(-share.back(), pair.change, 1, field);
  }
  Displacement corrected(grid_);
  precondition(field, corrected);
  field = std::move(corrected);
  for (const Pair& pair : pairs_) {
    sums_.add(share.back() - pair.inverse * sums_.dot(pair.change, field), pair.step, 1, field);
    share.pop_back();
  }
}

void QuasiNewton::remember(Displacement step, Displacement change_of_gradient, double slope) {
  const double curvature = sums_.dot(step, change_of_gradient);
  if (!(curvature > -least_curvature * slope))
    return;
  if (pairs_.size() == most_pairs)
    pairs_.pop_front();
  pairs_.push_back({std::move(step), std::move(change_of_gradient), 1 / curvature});
}

} // namespace maille::deform
