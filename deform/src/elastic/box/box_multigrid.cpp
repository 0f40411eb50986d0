#include "elastic/box/box_multigrid.hpp"

#include "elastic/krylov/chebyshev.hpp"
#include "parallel/thread_team.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Levels with fewer nodes are not worth waking threads for.
constexpr std::int64_t nodes_worth_threads = 4000;

void* scratch_of(std::size_t bytes) {
  thread_local AlignedArray<double> scratch;
  if (scratch.bytes() < bytes)
    scratch = AlignedArray<double>(bytes / sizeof(double) + 1);
  return scratch.data();
}

std::array<AxisTransfer, 3> views(const BoxLevel& fine) {
  const auto& t = fine.transfer();
  return {t[0].view(), t[1].view(), t[2].view()};
}

} // namespace

BoxMultigrid::BoxMultigrid(std::unique_ptr<BoxLevel> finest, int steps, ThreadTeam& team) : team_(team) {
  levels_.push_back(std::move(finest));
  sums_.resize(static_cast<std::size_t>(levels_[0]->A().nodes[2]));
  while (!BoxCoarsest::is_small(*levels_.back()) && !is_thin_end()) {
    std::unique_ptr<BoxLevel> next = levels_.back()->coarser();
    if (next == nullptr)
      break;
    weights_.push_back(chebyshev_weights(levels_.back()->largest_eigenvalue(), steps));
    const AxisCoarsening& along_z = levels_.back()->transfer()[2];
    auto& triggered = triggered_.emplace_back(static_cast<std::size_t>(along_z.n_fine()));
    for (int z = 0; z < along_z.n_coarse(); ++z)
      triggered[static_cast<std::size_t>(along_z.trigger(z))].push_back(z);
    levels_.push_back(std::move(next));
  }
  if (coarsest_ == nullptr) {
    coarsest_ = std::make_unique<BoxCoarsest>(*levels_.back());
    coarsest_->factor();
  }
}

/// Whether the level so far is the last: thin, and held well enough.
bool BoxMultigrid::is_thin_end() {
  if (!BoxCoarsest::is_thin(*levels_.back(), finest().n_nodes()))
    return false;
  coarsest_ = std::make_unique<BoxCoarsest>(*levels_.back());
  if (!coarsest_->factor())
    coarsest_ = nullptr;
  return coarsest_ != nullptr;
}

void BoxMultigrid::set_penalties(std::vector<PenaltyLink> links) {
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    levels_[level]->set_penalties(links);
    if (level + 1 < levels_.size())
      links = levels_[level]->coarse_links(links);
  }
  coarsest_->factor();
}

ThreadTeam& BoxMultigrid::team_for(const BoxLevel& level) {
  return level.n_nodes() < nodes_worth_threads ? alone_ : team_;
}

void* BoxMultigrid::scratch() const {
  return scratch_of(static_cast<std::size_t>(box_scratch_bytes(levels_[0]->A())));
}

std::size_t BoxMultigrid::in_plane() const {
  const BoxOperator& A = levels_[0]->A();
  return static_cast<std::size_t>(A.nodes[0]) * static_cast<std::size_t>(A.nodes[1]);
}

const double* BoxMultigrid::forces_of_plane(const Displacement& u, int z) const {
  thread_local AlignedArray<double> forces;
  if (forces.size() < 3 * in_plane())
    forces = AlignedArray<double>(3 * in_plane());
  apply_box(levels_[0]->A(), z, u.values().data(), forces.data(), scratch());
  return forces.data();
}

double BoxMultigrid::total() const {
  double sum = 0;
  for (const double part : sums_)
    sum += part;
  return sum;
}

double BoxMultigrid::precondition(float step) {
  cycle(0, step);
  if (levels_.size() > 1) // summed up on the way
    return total();
  return sum_over_planes(
      [&](int z) { return dot_box(finest().A(), z, finest().u.data(), finest().f.data()); });
}

void BoxMultigrid::cycle(std::size_t level, float step) {
  if (level + 1 == levels_.size()) {
    BoxLevel& last = *levels_[level];
    for (int z = 0; z < last.A().nodes[2] && step != 0; ++z)
      start_box(last.A(), z, 0, step, last.r.data(), last.f.data(), last.u.data());
    coarsest_->solve(last);
    return;
  }
  go_down(level, step);
  cycle(level + 1, 0);
  come_up(level);
}

void BoxMultigrid::relax(const BoxLevel& level, int z, float weight, const float* u, float* next) const {
  relax_box(level.A(), z, weight, level.f.data(), u, next, scratch());
  level.penalties().relax(z, weight, u, next);
}

/// Fields u and r take turns, so that the last step leaves its result in u.
void BoxMultigrid::go_down(std::size_t level, float step) {
  BoxLevel &fine = *levels_[level], &coarse = *levels_[level + 1];
  const BoxOperator& A = fine.A();
  const auto& weights = weights_[level];
  const auto transfer = views(fine);
  const int steps = static_cast<int>(weights.size());
  float *const f = fine.f.data(), *const r = fine.r.data();
  const auto after = [&](int number) {
    return (steps - 1 - number) % 2 == 0 ? fine.u.data() : fine.r.data();
  };
  run_stages(team_for(fine), A.nodes[2], steps + 2, [&](int stage, int z) {
    if (stage == 0)
      start_box(A, z, weights[0], step, r, f, after(0)); // which leaves r as it is for other planes
    else if (stage < steps)
      relax(fine, z, weights[static_cast<std::size_t>(stage)], after(stage - 1), after(stage));
    else if (stage == steps) {
      find_box_residual(A, z, f, fine.u.data(), r, scratch());
      fine.penalties().subtract(z, fine.u.data(), r);
    } else
      for (const int z_coarse : triggered_[level][static_cast<std::size_t>(z)])
        for (int c = 0; c < 3; ++c)
          restrict_plane(coarse.component(c), fine.component(c), transfer.data(), z_coarse,
                         r + c * A.component_stride, coarse.f.data() + c * coarse.A().component_stride,
                         static_cast<float*>(scratch()));
  });
}

void BoxMultigrid::come_up(std::size_t level) {
  BoxLevel &fine = *levels_[level], &coarse = *levels_[level + 1];
  const BoxOperator& A = fine.A();
  const auto& weights = weights_[level];
  const auto transfer = views(fine);
  const int steps = static_cast<int>(weights.size());
  float *const u = fine.u.data(), *const f = fine.f.data(), *const r = fine.r.data();
  run_stages(team_for(fine), A.nodes[2], steps + 2, [&](int stage, int z) {
    if (stage == 0)
      for (int c = 0; c < 3; ++c)
        prolong_plane(coarse.component(c), fine.component(c), transfer.data(), z,
                      coarse.u.data() + c * coarse.A().component_stride, false, u + c * A.component_stride,
                      static_cast<float*>(scratch()));
    else if (stage <= steps)
      relax(fine, z, weights[static_cast<std::size_t>(steps - stage)], stage % 2 == 1 ? u : r,
            stage % 2 == 1 ? r : u);
    else if (level == 0)
      sums_[static_cast<std::size_t>(z)] = dot_box(A, z, steps % 2 == 0 ? u : r, f);
  });
  if (steps % 2 != 0)
    std::swap(fine.u, fine.r);
}

std::int64_t BoxMultigrid::bytes() const {
  auto sum = coarsest_->bytes() + static_cast<std::int64_t>(sums_.size() * sizeof(double));
  for (const auto& level : levels_)
    sum += level->bytes();
  return sum;
}

} // namespace maille::deform
