#include "elastic/limits/active_links.hpp"

#include "elastic/componentwise/componentwise_solver.hpp"

#include <utility>

namespace maille::deform {

ActiveLinks::ActiveLinks(const Scene& scene, const CellModuli& moduli, const LinkLimits& limits,
                         int component, const FixedMask& fixed, std::size_t place, double rho)
    : scene_(scene), moduli_(moduli), fixed_(fixed), place_(place), component_(component), rho_(rho),
      ranges_(scene, limits, component), is_known_(fixed.n_nodes(), 0) {}

ActiveLinks::Link ActiveLinks::link_at(int axis, std::size_t node) const {
  const Grid& grid = scene_.specimen.grid;
  Link link;
  link.axis = axis;
  link.near = node;
  link.far = node + static_cast<std::size_t>(grid.stride(axis));
  link.low = ranges_.low(axis, node);
  link.high = ranges_.high(axis, node);
  link.weight =
      link_weight(scene_.specimen, moduli_, grid.node_at(static_cast<std::int64_t>(node)), axis, component_);
  return link;
}

/// Most rows have no active link.
void ActiveLinks::find_in_plane(int z, const double* u, double rounding, List<Link>& found) const {
  const Grid& grid = scene_.specimen.grid;
  const Index3& nodes = grid.nodes();
  const int rows = scene_.dimension() == 3 ? nodes[1] : 1;
  for (int row = 0; row < rows; ++row)
    for (int axis = 0; axis < scene_.dimension(); ++axis) {
      const Index3 at = scene_.dimension() == 3 ? Index3{0, row, z} : Index3{0, z, 0};
      const auto a = static_cast<std::size_t>(axis);
      const auto first = static_cast<std::size_t>(grid.node(at));
      if (!ranges_.is_any_outside_in_row(axis, at, u, rounding))
        continue;
      const std::size_t step = static_cast<std::size_t>(grid.stride(axis));
      const auto n = static_cast<std::size_t>(nodes[0] - (a == 0 ? 1 : 0));
      for (std::size_t node = first; node < first + n; ++node) {
        const double d = u[node + step] - u[node];
        if (std::max(ranges_.low(axis, node) - d, d - ranges_.high(axis, node)) > rounding &&
            (is_known_[node] >> axis & 1) == 0 && !(is_fixed(node) && is_fixed(node + step)))
          found.push_back(link_at(axis, node));
      }
    }
}

void ActiveLinks::add_violated(std::span<const double> u, double rounding, ThreadTeam& team) {
  std::vector<List<Link>> of_plane(ranges_.n_planes());
  team.run(ranges_.n_planes(), [&](int z, int) { find_in_plane(z, u.data(), rounding, of_plane[z]); });
  const std::size_t before = links_.size();
  std::size_t n = before;
  for (const auto& found : of_plane)
    n += found.size();
  links_.reserve(n); // doubled it would be more than half of all that is needed
  for (const auto& found : of_plane)
    links_.insert(links_.end(), found.begin(), found.end());
  for (std::size_t i = before; i < links_.size(); ++i) {
    std::uint8_t& known = is_known_[links_[i].near];
    known = static_cast<std::uint8_t>(known | 1 << links_[i].axis);
  }
}

/// A coarse link's multiplier is as much per length on the two fine links in its place, and falls off
/// linearly across.
/// @param reached nodes whose y was 0 before
void ActiveLinks::spread(const Link& coarse, const Grid& coarse_grid, std::vector<double>& y,
                         std::vector<std::size_t>& reached) const {
  const Grid& grid = scene_.specimen.grid;
  const Index3 centre = coarse_grid.node_at(static_cast<std::int64_t>(coarse.near));
  Index3 first{}, last{};
  for (std::size_t a = 0; a < 3; ++a) {
    const bool is_own = static_cast<int>(a) == coarse.axis;
    first[a] = is_own ? 2 * centre[a] : std::max(0, 2 * centre[a] - 1);
    last[a] = std::min(2 * centre[a] + 1, grid.nodes()[a] - 1);
  }
  for (int z = first[2]; z <= last[2]; ++z)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int x = first[0]; x <= last[0]; ++x) {
        const Index3 at{x, j, z};
        double part = 0.5;
        for (std::size_t a = 0; a < 3; ++a)
          part *= static_cast<int>(a) != coarse.axis && at[a] != 2 * centre[a] ? 0.5 : 1;
        const auto node = static_cast<std::size_t>(grid.node(at));
        if (y[node] == 0)
          reached.push_back(node);
        y[node] += part * coarse.y;
      }
}

void ActiveLinks::begin_with(const ActiveLinks& coarse) {
  std::vector<double> y(fixed_.n_nodes());
  std::vector<std::size_t> reached;
  for (int axis = 0; axis < scene_.dimension(); ++axis) {
    for (const Link& link : coarse.links_)
      if (link.axis == axis && link.y != 0)
        spread(link, coarse.scene_.specimen.grid, y, reached);
    std::ranges::sort(reached);
    for (const std::size_t node : reached) {
      const double found = std::exchange(y[node], 0.0); // a node that was reached twice was back at 0 between
      Link link = link_at(axis, node);
      if (found == 0 || link.weight == 0 || (is_fixed(link.near) && is_fixed(link.far)))
        continue;
      link.y = found * (coarse.rho_ / rho_);
      is_known_[node] = static_cast<std::uint8_t>(is_known_[node] | 1 << axis);
      links_.push_back(link);
    }
    reached.clear();
  }
}

void ActiveLinks::begin_with(const List<KeptMultiplier>& multipliers) {
  for (const KeptMultiplier& kept : multipliers) {
    if (kept.component != component_)
      continue;
    Link link = link_at(kept.axis, static_cast<std::size_t>(kept.node));
    if (link.weight == 0 || (is_fixed(link.near) && is_fixed(link.far)))
      continue;
    link.y = kept.pull / rho_;
    is_known_[link.near] = static_cast<std::uint8_t>(is_known_[link.near] | 1 << kept.axis);
    links_.push_back(link);
  }
}

void ActiveLinks::keep_multipliers(List<KeptMultiplier>& multipliers) const {
  for (const Link& link : links_)
    if (const double y = link.excess(link.v); y != 0) // as update_multipliers() would have it
      multipliers.push_back({component_, link.axis, static_cast<std::int64_t>(link.near), rho_ * y});
}

ActiveLinks::Slope ActiveLinks::slope_at(double step) const {
  Slope sum;
  for (const Link& link : links_) {
    const double excess = link.excess(link.v + step * link.change);
    sum.first += link.weight * link.change * excess;
    sum.second += excess != 0 ? link.weight * link.change * link.change : 0;
  }
  return {rho_ * sum.first, rho_ * sum.second};
}

void ActiveLinks::update_forces(std::span<const double> u, std::span<double> residual) {
  for (Link& link : links_) {
    link.v = u[link.far] - u[link.near] + link.y;
    const double force = rho_ * link.weight * link.excess(link.v), more = force - link.force;
    link.force = force;
    if (!is_fixed(link.near))
      residual[link.near] += more;
    if (!is_fixed(link.far))
      residual[link.far] -= more;
  }
}

void ActiveLinks::update_multipliers() {
  for (Link& link : links_)
    link.y = link.excess(link.v);
}

void ActiveLinks::set_penalties(List<PenaltyLink>& penalties) {
  for (Link& link : links_) {
    link.was_outside = link.excess(link.v) != 0;
    if (link.was_outside)
      penalties.push_back({component_, link.axis, static_cast<std::int64_t>(link.near), rho_ * link.weight});
  }
}

std::size_t ActiveLinks::n_changed() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      links_, [](const Link& link) { return link.was_outside != (link.excess(link.v) != 0); }));
}

std::size_t ActiveLinks::n_outside() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(links_, [](const Link& link) { return link.excess(link.v) != 0; }));
}

double ActiveLinks::gap() const {
  double sum = 0;
  for (const Link& link : links_) {
    const double difference = link.excess(link.v) - link.y;
    sum += link.weight * difference * difference;
  }
  return sum;
}

void ActiveLinks::add_forces(std::span<double> forces) const {
  for (const Link& link : links_) {
    forces[link.near] -= link.force;
    forces[link.far] += link.force;
  }
}

} // namespace maille::deform
