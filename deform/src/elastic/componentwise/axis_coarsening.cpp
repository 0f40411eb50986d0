#include "elastic/componentwise/axis_coarsening.hpp"

#include <algorithm>

namespace maille::deform {

AxisCoarsening::AxisCoarsening(const std::vector<double>& place, bool coarsens)
    : coarsens_(coarsens && place.size() > 1) {
  const auto n = static_cast<int>(place.size());
  std::vector<int>& kept = fine_place_;
  if (!coarsens_)
    for (int i = 0; i < n; ++i)
      kept.push_back(i);
  else
    for (int k = 0; k < std::max(1, (n - 1) / 2); ++k)
      kept.push_back(2 * k);
  if (coarsens_ && n > 2)
    kept.push_back(n - 1);
  for (const int i : kept)
    coarse_place_.push_back(place[i]);

  const auto n_coarse = kept.size();
  first_.assign(n_coarse, n);
  count_.assign(n_coarse, 0);
  hat_.assign(n_coarse * most_in_support, 0);
  const auto share = [&](int fine, std::size_t coarse, float weight) {
    first_[coarse] = std::min(first_[coarse], fine);
    const int k = fine - first_[coarse];
    hat_[coarse * most_in_support + static_cast<std::size_t>(k)] = weight;
    count_[coarse] = k + 1;
  };
  std::size_t coarse = 0;
  for (int i = 0; i < n; ++i) {
    while (coarse + 1 < n_coarse && kept[coarse + 1] <= i)
      ++coarse;
    const auto k = static_cast<std::size_t>(i);
    const bool is_between = kept[coarse] != i && coarse + 1 < n_coarse;
    const double right =
        is_between ? (place[k] - coarse_place_[coarse]) / (coarse_place_[coarse + 1] - coarse_place_[coarse])
                   : 0;
    left_.push_back(static_cast<int>(coarse));
    right_.push_back(static_cast<float>(right));
    share(i, coarse, 1 - right_.back());
    if (is_between)
      share(i, coarse + 1, right_.back());
  }
}

std::ranges::iota_view<int, int> AxisCoarsening::coarse_after(int i) const {
  const auto is_after = [&](int coarse) {
    const int last = first(coarse) + count(coarse) - 1;
    return i == (!coarsens_ || last == n_fine() - 1 ? last : last - 1);
  };
  int begin = std::max(0, left(i) - 1);
  const int most = std::min(n_coarse(), left(i) + 2);
  while (begin < most && !is_after(begin))
    ++begin;
  int end = begin;
  while (end < most && is_after(end))
    ++end;
  return {begin, end};
}

AxisTransfer AxisCoarsening::view() const {
  return {n_fine(),      n_coarse(),  coarsens_,    first_.data(),
          count_.data(), hat_.data(), left_.data(), right_.data()};
}

int AxisCoarsening::interval(int i) const {
  return std::min(left(i), n_coarse() - 2);
}

double AxisCoarsening::part_of_interval(int i) const {
  const double end = left(i + 1) > interval(i) ? 1 : right_weight(i + 1);
  return end - right_weight(i);
}

std::vector<double> AxisCoarsening::coarse_link(const std::vector<double>& fine) const {
  if (!coarsens_)
    return fine;
  std::vector<double> coarse(n_coarse() - 1, 0);
  for (int i = 0; i + 1 < n_fine() && n_coarse() > 1; ++i)
    coarse[interval(i)] += part_of_interval(i) * part_of_interval(i) * fine[i];
  return coarse;
}

std::vector<double> AxisCoarsening::coarse_mass(const std::vector<double>& fine) const {
  if (!coarsens_)
    return fine;
  std::vector<double> coarse(n_coarse(), 0);
  for (int i = 0; i < n_coarse(); ++i)
    for (int k = 0; k < count(i); ++k)
      coarse[i] += hat(i, k) * fine[first(i) + k];
  return coarse;
}

} // namespace maille::deform
