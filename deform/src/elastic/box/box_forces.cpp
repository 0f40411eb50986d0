#include "elastic/box/box_solver.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace maille::deform {

/// The right-hand side of the multigrid on one plane, in units of scale_. @return the plane's part of u . K u
double BoxSolver::residual_of_plane(const Displacement& u, int z, double& largest) {
  BoxLevel& level = multigrid_->finest();
  const BoxOperator& A = level.A();
  const double* force = multigrid_->forces_of_plane(u, z);
  const std::size_t first = multigrid_->in_plane() * static_cast<std::size_t>(z);
  double energy = 0;
  for (int c = 0; c < 3; ++c) {
    const auto b = static_cast<std::size_t>(c);
    const double* of_u = u.component[b].data() + first;
    const double* load = loads_[b].empty() ? nullptr : loads_[b].data() + first;
    for (int y = 0; y < A.nodes[1]; ++y) {
      float* const target = level.f.data() + level.offset(c, 0, y, z);
      const float* const inverse = A.inverse[c][y + std::int64_t{1} * A.nodes[1] * z];
      for (int x = 0; x < A.nodes[0]; ++x) {
        const double value = (load == nullptr ? 0 : load[x] / unit_) - force[x];
        energy += of_u[x] * force[x];
        target[x] = inverse[x] > 0 ? static_cast<float>(value / scale_) : 0;
        largest = std::max(largest, std::abs(static_cast<double>(target[x])));
      }
      of_u += A.nodes[0], force += A.nodes[0];
      load = load == nullptr ? nullptr : load + A.nodes[0];
    }
  }
  return energy;
}

/// Sets energy_ too. @return the largest residual in units of scale_
double BoxSolver::find_residual(const Displacement& u) {
  std::vector<double> largest(multigrid_->sums().size(), 0);
  energy_ = multigrid_->sum_over_planes(
      [&](int z) { return residual_of_plane(u, z, largest[static_cast<std::size_t>(z)]); });
  return *std::ranges::max_element(largest);
}

void BoxSolver::precondition(const Displacement& residual, Displacement& correction) {
  BoxLevel& level = multigrid_->finest();
  const Index3& n = task_.scene.specimen.grid.nodes();
  const double size = largest_entry(residual);
  const auto for_each_row = [&](auto&& visit) {
    multigrid_->team_for(level).run(n[2], [&](int z, int) {
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < n[1]; ++y)
          visit(static_cast<std::size_t>(c),
                static_cast<std::size_t>(task_.scene.specimen.grid.node({0, y, z})), level.offset(c, 0, y, z),
                level.A().inverse[c][y + std::int64_t{1} * n[1] * z]);
    });
  };
  for_each_row([&](std::size_t c, std::size_t node, std::int64_t at, const float* inverse) {
    for (int x = 0; x < n[0]; ++x) {
      const double value = residual.component[c][node + static_cast<std::size_t>(x)];
      level.f.data()[at + x] = inverse[x] > 0 && size > 0 ? static_cast<float>(value / size) : 0;
    }
  });
  multigrid_->precondition();
  for_each_row([&](std::size_t c, std::size_t node, std::int64_t at, const float* inverse) {
    for (int x = 0; x < n[0]; ++x)
      correction.component[c][node + static_cast<std::size_t>(x)] =
          inverse[x] > 0 ? size / unit_ * double{level.u.data()[at + x]} : 0;
  });
}

/// u . K u of one plane in units of unit_: of free components, what pulls less the residual. @pre nothing is
/// prescribed there
double BoxSolver::work_from_residual(const Displacement& u, int z) const {
  const std::size_t n = multigrid_->in_plane(), first = n * static_cast<std::size_t>(z);
  double sum = 0;
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t i = first; i < first + n && !loads_[b].empty(); ++i)
      sum += u.component[b][i] * loads_[b][i];
  return sum / unit_ - work_of_residual_[static_cast<std::size_t>(z)];
}

void BoxSolver::find_energy_and_reactions(const Displacement& u, Answer& answer) {
  const auto& prescribed = task_.scene.prescribed;
  std::vector<std::size_t> order(prescribed.size()); // by node, so that planes find theirs
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto node_of = [&](std::size_t i) { return static_cast<std::size_t>(prescribed[i].node); };
  std::ranges::sort(order, {}, node_of);
  answer.reaction.resize(prescribed.size());
  const double twice = multigrid_->sum_over_planes([&](int z) {
    const std::size_t n = multigrid_->in_plane(), first = n * static_cast<std::size_t>(z);
    auto at = std::ranges::lower_bound(order, first, {}, node_of);
    const auto is_here = [&] { return at != order.end() && node_of(*at) < first + n; };
    if (!work_of_residual_.empty() && !is_here())
      return work_from_residual(u, z);
    const double* const force = multigrid_->forces_of_plane(u, z);
    double sum = 0;
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < n; ++i)
        sum += u.component[b][first + i] * force[b * n + i];
    for (; is_here(); ++at) {
      const auto b = static_cast<std::size_t>(prescribed[*at].component);
      answer.reaction[*at] =
          unit_ * force[b * n + node_of(*at) - first] - (loads_[b].empty() ? 0 : loads_[b][node_of(*at)]);
    }
    return sum;
  });
  answer.strain_energy = 0.5 * unit_ * twice;
}

} // namespace maille::deform
