#include "elastic/box/box_multigrid.hpp"

#include "parallel/thread_team.hpp"

#include <algorithm>

namespace maille::deform {

/// The prescribed value at the position of a coarse node, or else the mean of the prescribed values around
/// it.
double BoxStart::prescribed_at(std::size_t level, const float* fine, int c, const Index3& coarse) const {
  const BoxLevel& from = multigrid_.level(level);
  const auto& t = from.transfer();
  const Index3 twin{t[0].fine_place(coarse[0]), t[1].fine_place(coarse[1]), t[2].fine_place(coarse[2])};
  if (!from.may_move(c, twin[0], twin[1], twin[2]))
    return fine[from.offset(c, twin[0], twin[1], twin[2])];
  double sum = 0, weights = 0;
  for (int k = 0; k < t[2].count(coarse[2]); ++k)
    for (int j = 0; j < t[1].count(coarse[1]); ++j)
      for (int i = 0; i < t[0].count(coarse[0]); ++i) {
        const int x = t[0].first(coarse[0]) + i, y = t[1].first(coarse[1]) + j, z = t[2].first(coarse[2]) + k;
        if (from.may_move(c, x, y, z))
          continue;
        const double weight = t[0].hat(coarse[0], i) * t[1].hat(coarse[1], j) * t[2].hat(coarse[2], k);
        sum += weight * double{fine[from.offset(c, x, y, z)]};
        weights += weight;
      }
  return weights > 0 ? sum / weights : 0;
}

void BoxStart::coarsen_prescribed(std::size_t level, const float* fine, float* coarse) {
  const BoxLevel& to = multigrid_.level(level + 1);
  const int* const nodes = to.A().nodes;
  multigrid_.team_for(to).run(nodes[2], [&](int z, int) {
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < nodes[1]; ++y)
        for (int x = 0; x < nodes[0]; ++x)
          if (!to.may_move(c, x, y, z))
            coarse[to.offset(c, x, y, z)] =
                static_cast<float>(prescribed_at(level, fine, c, Index3{x, y, z}));
  });
}

void BoxStart::coarsen_forces(std::size_t level, const float* fine, float* coarse) {
  const BoxLevel &from = multigrid_.level(level), &to = multigrid_.level(level + 1);
  multigrid_.team_for(to).run(to.n_planes(), [&](int z, int) { from.restrict_to(to, z, fine, coarse); });
}

void BoxStart::interpolate(std::size_t level, const float* coarse, float* fine,
                           const std::function<void(int)>& is_done) {
  const BoxLevel &to = multigrid_.level(level), &from = multigrid_.level(level + 1);
  run_stages(multigrid_.team_for(to), to.n_planes(), is_done ? 2 : 1, [&](int stage, int z) {
    if (stage == 1)
      is_done(z);
    else
      to.prolong_from(from, z, coarse, true, fine);
  });
}

/// One cycle for the residual, and the step of least energy along its correction.
void BoxStart::improve(std::size_t level, float* u, const float* forces) {
  BoxLevel& grid = multigrid_.level(level);
  const BoxOperator& A = grid.A();
  ThreadTeam& team = multigrid_.team_for(grid);
  float *const f = grid.f.data(), *const r = grid.r.data();
  const float* pulls = forces;
  if (pulls == nullptr) {
    std::fill_n(grid.u.data(), grid.field_size(), 0.0F);
    pulls = grid.u.data();
  }
  team.run(A.nodes[2], [&](int z, int) { find_box_residual(A, z, pulls, u, f, grid.scratch()); });
  multigrid_.cycle(level);
  const float* const change = grid.u.data();
  std::vector<double> work(A.nodes[2]), curvature(work.size());
  team.run(A.nodes[2], [&](int z, int) {
    const auto plane = static_cast<std::size_t>(z);
    work[plane] = dot_box(A, z, change, f);
    curvature[plane] = apply_box_and_dot(A, z, change, r, grid.scratch());
  });
  double gain = 0, stiffness = 0;
  for (std::size_t z = 0; z < work.size(); ++z)
    gain += work[z], stiffness += curvature[z];
  const float step = gain > 0 && stiffness > 0 ? static_cast<float>(gain / stiffness) : 0;
  for (std::size_t i = 0; i < grid.field_size(); ++i)
    u[i] += step * change[i];
}

void BoxStart::solve(float* u, const float* forces, const std::function<void(int z)>& is_done) {
  const std::size_t n = multigrid_.n_levels();
  std::vector<PaddedArray> states(n), pulls(n);
  const auto state = [&](std::size_t level) { return level == 0 ? u : states[level].data(); };
  const auto pull = [&](std::size_t level) -> const float* {
    return forces == nullptr ? nullptr : level == 0 ? forces : pulls[level].data();
  };
  for (std::size_t level = 0; level + 1 < n; ++level) {
    const std::size_t size = multigrid_.level(level + 1).field_size();
    states[level + 1] = PaddedArray(size);
    coarsen_prescribed(level, state(level), states[level + 1].data());
    if (forces == nullptr)
      continue;
    pulls[level + 1] = PaddedArray(size);
    coarsen_forces(level, pull(level), pulls[level + 1].data());
  }
  for (std::size_t level = n - 1; level > 0; --level) {
    improve(level, state(level), pull(level));
    interpolate(level - 1, state(level), state(level - 1), level == 1 ? is_done : nullptr);
  }
}

} // namespace maille::deform
