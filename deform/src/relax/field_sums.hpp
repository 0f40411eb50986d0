#pragma once
/// Sums over the entries of displacement fields.

#include "maille/scene/answer.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>

namespace maille::deform {

/// Same bits for any number of threads: parts are fixed, and added in their order.
class FieldSums {
public:
  FieldSums(const Grid& grid, ThreadTeam& team)
      : team_(team), n_(static_cast<std::size_t>(grid.n_nodes())), parts_((n_ + per_part - 1) / per_part) {}

  double dot(const Displacement& a, const Displacement& b) {
    for_each_part([&](std::size_t part, std::size_t first, std::size_t end) {
      double sum = 0;
      for (std::size_t c = 0; c < a.component.size(); ++c)
        for (std::size_t i = first; i < end; ++i)
          sum += a.component[c][i] * b.component[c][i];
      parts_[part] = sum;
    });
    double sum = 0;
    for (const double part : parts_)
      sum += part;
    return sum;
  }
  /// y = factor x + keep y
  void add(double factor, const Displacement& x, double keep, Displacement& y) {
    for_each_part([&](std::size_t, std::size_t first, std::size_t end) {
      for (std::size_t c = 0; c < x.component.size(); ++c)
        for (std::size_t i = first; i < end; ++i)
          y.component[c][i] = factor * x.component[c][i] + keep * y.component[c][i];
    });
  }

private:
  static constexpr std::size_t per_part = 4096;

  template<class Visit>
  void for_each_part(const Visit& visit) {
    team_.run(static_cast<int>(parts_.size()), [&](int part, int) {
      const auto i = static_cast<std::size_t>(part);
      visit(i, i * per_part, std::min(n_, (i + 1) * per_part));
    });
  }

  ThreadTeam& team_;
  std::size_t n_;
  std::vector<double> parts_;
};

} // namespace maille::deform
