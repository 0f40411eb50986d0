#include "oracle/component_sweep.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace maille::deform {

namespace {

/// What a node's neighbours say about it.
struct Neighbourhood {
  double mean;
  double lowest, highest; ///< the interval that the links leave; empty if lowest > highest
};

constexpr std::array<double, 7> one_over{0, 1.0, 1.0 / 2, 1.0 / 3, 1.0 / 4, 1.0 / 5, 1.0 / 6};

} // namespace

ComponentSweep::ComponentSweep(const LinkTable& table, int component, std::vector<double> u,
                               const std::vector<Prescribed>& prescribed)
    : table_(table), component_(component), u_(std::move(u)) {
  std::vector<bool> is_fixed(u_.size(), false);
  for (const Prescribed& p : prescribed)
    if (p.component == component)
      is_fixed[static_cast<std::size_t>(table.body_node(p.node))] = true;
  for (std::size_t i = 0; i < u_.size(); ++i)
    if (!is_fixed[i] && table.first()[i + 1] > table.first()[i])
      free_.push_back(static_cast<std::int32_t>(i));
}

template<class Rule>
double ComponentSweep::sweep(Rule rule) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  // Raw pointers: this loop is the whole cost of the method.
  const std::int32_t* first = table_.first().data();
  const std::int32_t* neighbour = table_.neighbour().data();
  const double* below = table_.below(component_).data();
  const double* above = table_.above(component_).data();
  double* u = u_.data();
  double largest = 0;
  for (const std::int32_t i : free_) {
    double sum = 0, lowest = -infinity, highest = infinity;
    for (std::int32_t e = first[i]; e < first[i + 1]; ++e) {
      const double v = u[neighbour[e]];
      sum += v;
      lowest = std::max(lowest, v + below[e]);
      highest = std::min(highest, v + above[e]);
    }
    const double mean = sum * one_over[static_cast<std::size_t>(first[i + 1] - first[i])];
    const double next = rule(u[i], Neighbourhood{mean, lowest, highest});
    largest = std::max(largest, std::abs(next - u[i]));
    u[i] = next;
  }
  return largest;
}

double ComponentSweep::relax_elastic() {
  return sweep([](double now, const Neighbourhood& n) {
    // A legal state leaves every node an interval, up to rounding; where that empties it, the node stays, so
    // that rounding does not add up from node to node.
    return n.lowest > n.highest ? now : std::min(std::max(n.mean, n.lowest), n.highest);
  });
}

double ComponentSweep::relax_deformable() {
  return sweep([](double now, const Neighbourhood& n) {
    return n.lowest > n.highest ? 0.5 * n.lowest + 0.5 * n.highest
                                : std::min(std::max(now, n.lowest), n.highest);
  });
}

std::int64_t ComponentSweep::bytes() const {
  return static_cast<std::int64_t>(u_.size() * sizeof(double) + free_.size() * sizeof(std::int32_t));
}

} // namespace maille::deform
