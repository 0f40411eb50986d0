#include "elastic/tied/tied_links.hpp"

#include "elastic/componentwise/componentwise_solver.hpp"
#include "elastic/links/interval_field.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

TiedLinks::TiedLinks(const Scene& scene,
                     const std::function<double(const Index3& tail, int axis, int component)>& weight) {
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  n_nodes_ = static_cast<std::size_t>(grid.n_nodes());
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 tail = grid.node_at(node);
    for (int axis = 0; axis < 3; ++axis) {
      bool is_link = false;
      body.for_each_cell_at_link(tail, axis, [&](std::int64_t) { is_link = true; });
      Index3 head = tail;
      ++head[static_cast<std::size_t>(axis)];
      for (int b = 0; b < 3 && is_link; ++b) {
        const auto k = static_cast<std::size_t>(b);
        links_[k].push_back({node, grid.node(head), weight(tail, axis, b)});
        axes_[k].push_back(static_cast<std::int8_t>(axis));
      }
    }
  }
}

TiedLinks links_of_matter(const Scene& scene, const CellModuli& moduli) {
  return TiedLinks(scene, [&](const Index3& tail, int axis, int component) {
    return link_weight(scene.specimen, moduli, tail, axis, component);
  });
}

void TiedLinks::add_forces(const Displacement& u, double factor, Displacement& forces,
                           ThreadTeam& team) const {
  team.run(3, [&](int b, int) {
    for (const Link& link : links_[static_cast<std::size_t>(b)]) {
      const double pull = factor * link.weight * (u(b, link.far) - u(b, link.near));
      forces(b, link.far) += pull;
      forces(b, link.near) -= pull;
    }
  });
}

Displacement TiedLinks::diagonal() const {
  Displacement diagonal(3, n_nodes_);
  for (std::size_t b = 0; b < 3; ++b)
    for (const Link& link : links_[b]) {
      diagonal(b, link.near) += link.weight;
      diagonal(b, link.far) += link.weight;
    }
  return diagonal;
}

void TiedLinks::set_limits(const Scene& scene, const LinkLimits& limits) {
  for (int b = 0; b < 3; ++b) {
    const auto k = static_cast<std::size_t>(b);
    const IntervalField ranges(scene, limits, b);
    limits_[k].resize(links_[k].size());
    for (std::size_t i = 0; i < links_[k].size(); ++i) {
      const auto near = static_cast<std::size_t>(links_[k][i].near);
      limits_[k][i] = {ranges.low(axes_[k][i], near), ranges.high(axes_[k][i], near), 0, 0};
    }
  }
}

void TiedLinks::begin(const Displacement& u, ThreadTeam& team) {
  team.run(3, [&](int b, int) {
    const auto k = static_cast<std::size_t>(b);
    for (std::size_t i = 0; i < links_[k].size(); ++i) {
      Limit& limit = limits_[k][i];
      limit.part = std::clamp(u(b, links_[k][i].far) - u(b, links_[k][i].near), limit.low, limit.high);
      limit.multiplier = 0;
    }
  });
}

void TiedLinks::add_pull_to_parts(double factor, Displacement& forces, ThreadTeam& team) const {
  team.run(3, [&](int b, int) {
    const auto k = static_cast<std::size_t>(b);
    for (std::size_t i = 0; i < links_[k].size(); ++i) {
      const Link& link = links_[k][i];
      const double pull = factor * link.weight * (limits_[k][i].part - limits_[k][i].multiplier);
      forces(b, link.far) += pull;
      forces(b, link.near) -= pull;
    }
  });
}

TiedLinks::Round TiedLinks::take(const Displacement& u, double forward, ThreadTeam& team) {
  std::array<Round, 3> rounds{};
  team.run(3, [&](int b, int) {
    const auto k = static_cast<std::size_t>(b);
    Round& round = rounds[k];
    for (std::size_t i = 0; i < links_[k].size(); ++i) {
      Limit& limit = limits_[k][i];
      const double stretch = u(b, links_[k][i].far) - u(b, links_[k][i].near);
      const double beyond = forward * stretch + (1 - forward) * limit.part + limit.multiplier;
      const double part = std::clamp(beyond, limit.low, limit.high);
      round.moved = std::max(round.moved, std::abs(part - limit.part));
      round.apart = std::max(round.apart, std::abs(stretch - part));
      limit.part = part;
      limit.multiplier = beyond - part;
    }
  });
  Round largest;
  for (const Round& round : rounds)
    largest = {std::max(largest.apart, round.apart), std::max(largest.moved, round.moved)};
  return largest;
}

void TiedLinks::scale_multipliers(double factor) {
  for (auto& limits : limits_)
    for (Limit& limit : limits)
      limit.multiplier *= factor;
}

std::int64_t TiedLinks::n_active() const {
  std::int64_t n = 0;
  for (const auto& limits : limits_)
    n += std::ranges::count_if(limits, [](const Limit& limit) { return limit.multiplier != 0; });
  return n;
}

} // namespace maille::deform
