#include "elastic/nested/extrapolation.hpp"

#include "elastic/resample/interpolation.hpp"

#include <fmt/format.h>

namespace maille::deform {

namespace {

constexpr double largest_ratio = 0.5, no_ratio = 0.75, largest_difference = 0.25;

std::size_t of(std::int64_t i) {
  return static_cast<std::size_t>(i);
}

/// fine - coarse at the nodes of `coarse` that are nodes of the body, 0 elsewhere.
Displacement difference(const Grid& fine, const Displacement& u, const LatticeAnswer& coarse) {
  const Grid& grid = coarse.body.grid;
  Displacement out(grid);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    Index3 at = grid.node_at(node);
    if (!coarse.body.is_node(at))
      continue;
    for (int a = 0; a < grid.dimension(); ++a)
      at[of(a)] *= 2;
    const std::int64_t twin = fine.node(at);
    for (int b = 0; b < grid.dimension(); ++b)
      out(b, node) = u(b, twin) - coarse.u(b, node);
  }
  return out;
}

/// Euclidean products over components at a node, or over all of them.
struct Products {
  double change = 0, mixed = 0, coarse = 0; ///< (u_h - u_2h)^2, its product with u_2h - u_4h, (u_2h - u_4h)^2

  void add(const Displacement& finer, std::int64_t twin, const Displacement& coarser, std::int64_t node) {
    for (int b = 0; b < static_cast<int>(coarser.component.size()); ++b) {
      const double first = finer(b, twin), second = coarser(b, node);
      change += first * first, mixed += first * second, coarse += second * second;
    }
  }
  double ratio() const { return coarse > 0 ? mixed / coarse : 0; }
};

/// What is missing, over the last change.
double factor_of(double ratio) {
  const double q = std::clamp(ratio, 0.0, largest_ratio);
  return q / (1 - q);
}

double norm(const Displacement& u) {
  double sum = 0;
  for (const auto& component : u.component)
    for (const double value : component)
      sum += value * value;
  return std::sqrt(sum);
}

/// Node by node of the coarsest lattice.
class ObservedRatios {
public:
  ObservedRatios(const Grid& finer, const Displacement& change, const Grid& grid, const Displacement& coarse)
      : factor(of(grid.n_nodes()), 0) {
    std::vector<Products> products(factor.size());
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      Index3 at = grid.node_at(node);
      for (int a = 0; a < grid.dimension(); ++a)
        at[of(a)] *= 2;
      products[of(node)].add(change, finer.node(at), coarse, node);
      Products& p = products[of(node)];
      all_.change += p.change, all_.mixed += p.mixed, all_.coarse += p.coarse;
    }
    for (std::size_t node = 0; node < factor.size(); ++node) {
      const double ratio = products[node].ratio();
      factor[node] = factor_of(ratio > no_ratio ? all_.ratio() : ratio);
      n_free_ += products[node].coarse > 0 ? 1 : 0;
      n_used_ += factor[node] > 0 ? 1 : 0;
    }
  }
  double of_the_body() const { return all_.ratio(); }
  double share() const {
    return n_free_ > 0 ? static_cast<double>(n_used_) / static_cast<double>(n_free_) : 0;
  }

  std::vector<double> factor;

private:
  Products all_;
  std::int64_t n_free_ = 0, n_used_ = 0;
};

void add_where_free(const std::vector<double>& correction, const std::vector<Prescribed>& prescribed, int b,
                    std::vector<double>& u) {
  std::vector<double> kept;
  for (const Prescribed& p : prescribed)
    if (p.component == b)
      kept.push_back(u[of(p.node)]);
  for (std::size_t i = 0; i < u.size(); ++i)
    u[i] += correction[i];
  auto value = kept.begin();
  for (const Prescribed& p : prescribed)
    if (p.component == b)
      u[of(p.node)] = *value++;
}

} // namespace

Extrapolated extrapolate(const LatticeAnswer& twice, const LatticeAnswer& four_times, const CoupledTask& task,
                         Displacement& u) {
  const Specimen& body = task.scene.specimen;
  Displacement change = difference(body.grid, u, twice);
  const Displacement coarse = difference(twice.body.grid, twice.u, four_times);
  ObservedRatios ratios(twice.body.grid, change, four_times.body.grid, coarse);
  Extrapolated result;
  result.bytes = bytes_of(change) + bytes_of(coarse) + (body.grid.n_nodes() + twice.body.grid.n_nodes()) * 8;
  const double size = norm(twice.u), changed = norm(change);
  if (changed > largest_difference * size) {
    result.reason = fmt::format("the last two lattices differ by {:.2g} %", 100 * changed / size);
    return result;
  }
  if (!(ratios.of_the_body() > 0 && ratios.of_the_body() <= no_ratio)) {
    result.reason = fmt::format("differences of three lattices show a ratio of {:.2g}", ratios.of_the_body());
    return result;
  }
  result.share = ratios.share();
  std::vector<double> factor(of(twice.body.grid.n_nodes()), 0), correction(of(body.grid.n_nodes()), 0);
  interpolate(four_times.body, ratios.factor, twice.body, factor, task.team);
  for (int b = 0; b < body.grid.dimension(); ++b) {
    std::vector<double>& missing = change.component[of(b)];
    for (std::size_t i = 0; i < missing.size(); ++i)
      missing[i] *= factor[i];
    interpolate(twice.body, missing, body, correction, task.team);
    add_where_free(correction, task.prescribed, b, u.component[of(b)]);
  }
  return result;
}

} // namespace maille::deform
