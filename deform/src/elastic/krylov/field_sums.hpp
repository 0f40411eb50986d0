#pragma once
/// Sums over the entries of displacement fields.

#include "elastic/krylov/coupled_task.hpp"

#include <algorithm>
#include <vector>

namespace maille::deform {

/// Same bits for any number of threads: parts are fixed, and added in their order.
class FieldSums {
public:
  /// @param nodes_per_part > 0
  FieldSums(const Grid& grid, ThreadTeam& team, std::int64_t nodes_per_part = 4096)
      : team_(team), n_(static_cast<std::size_t>(grid.n_nodes())),
        per_part_(static_cast<std::size_t>(nodes_per_part)), n_parts_((n_ + per_part_ - 1) / per_part_) {}

  /// Parts are planes across the last axis.
  explicit FieldSums(const CoupledTask& task)
      : FieldSums(
            task.scene.specimen.grid, task.team,
            task.scene.specimen.grid.n_nodes() /
                task.scene.specimen.grid.nodes()[static_cast<std::size_t>(task.scene.dimension()) - 1]) {}

  /// The sum of what visit(first node, end) returns for each part.
  template<class Visit>
  auto sum(const Visit& visit) {
    std::vector<decltype(visit(std::size_t{}, std::size_t{}))> parts(n_parts_);
    for_each_part(
        [&](std::size_t part, std::size_t first, std::size_t end) { parts[part] = visit(first, end); });
    decltype(visit(std::size_t{}, std::size_t{})) total{};
    for (const auto& part : parts)
      total += part;
    return total;
  }
  double dot(const Displacement& a, const Displacement& b) {
    return sum([&](std::size_t first, std::size_t end) {
      double of_part = 0;
      for (std::size_t c = 0; c < a.n_components(); ++c)
        for (std::size_t i = first; i < end; ++i)
          of_part += a(c, i) * b(c, i);
      return of_part;
    });
  }
  /// y = factor x + keep y.
  void add(double factor, const Displacement& x, double keep, Displacement& y) {
    for_each_part([&](std::size_t, std::size_t first, std::size_t end) {
      for (std::size_t c = 0; c < x.n_components(); ++c)
        for (std::size_t i = first; i < end; ++i)
          y(c, i) = factor * x(c, i) + keep * y(c, i);
    });
  }

private:
  template<class Visit>
  void for_each_part(const Visit& visit) {
    team_.run(static_cast<int>(n_parts_), [&](int part, int) {
      const auto i = static_cast<std::size_t>(part);
      visit(i, i * per_part_, std::min(n_, (i + 1) * per_part_));
    });
  }

  ThreadTeam& team_;
  std::size_t n_, per_part_, n_parts_;
};

} // namespace maille::deform
