#include "elastic/componentwise/componentwise_multigrid.hpp"

#include "parallel/thread_team.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>

namespace maille::deform {

namespace {

/// A level with fewer free nodes is solved directly: 60 by 60 numbers fit the first cache.
constexpr std::int64_t most_unknowns_solved_directly = 64;
/// Levels with fewer nodes are not worth waking threads for.
constexpr std::int64_t nodes_worth_threads = 30000;

/// Two Jacobi steps that damp what the coarser level cannot see: Chebyshev's weights for the eigenvalues 0.5
/// to 2 of the operator over its diagonal, which has none above 2 (Gershgorin).
constexpr std::array<float, 2> step_weights{0.5617F, 1.3895F};

float* scratch_of(std::size_t size) {
  thread_local AlignedArray<float> scratch;
  if (scratch.size() < size)
    scratch = AlignedArray<float>(size);
  return scratch.data();
}

std::size_t scratch_size(const ComponentwiseLevel& fine) {
  return static_cast<std::size_t>(2 * fine.A().row_stride + 6 * line_of_floats);
}

std::array<AxisTransfer, 3> views(const ComponentwiseLevel& fine) {
  const auto& t = fine.transfer();
  return {t[0].view(), t[1].view(), t[2].view()};
}

} // namespace

ComponentwiseMultigrid::ComponentwiseMultigrid(std::unique_ptr<ComponentwiseLevel> finest, ThreadTeam& team)
    : team_(team) {
  levels_.push_back(std::move(finest));
  sums_.resize(static_cast<std::size_t>(levels_[0]->nodes()[2]));
  while (levels_.back()->n_nodes() > most_unknowns_solved_directly) {
    std::unique_ptr<ComponentwiseLevel> next = levels_.back()->coarser();
    if (next == nullptr)
      break;
    const AxisCoarsening& along_z = levels_.back()->transfer()[2];
    auto& triggered = triggered_.emplace_back(static_cast<std::size_t>(along_z.n_fine()));
    for (int z = 0; z < along_z.n_coarse(); ++z)
      triggered[static_cast<std::size_t>(along_z.trigger(z))].push_back(z);
    levels_.push_back(std::move(next));
  }
  factor_coarsest();
}

ThreadTeam& ComponentwiseMultigrid::team_for(const ComponentwiseLevel& level) {
  return level.n_nodes() < nodes_worth_threads ? alone_ : team_;
}

double ComponentwiseMultigrid::precondition() {
  cycle(0, Start::zero, sums_.data());
  double sum = 0;
  for (const double part : sums_)
    sum += part;
  return sum;
}

void ComponentwiseMultigrid::cycle(std::size_t level, Start start, double* dot_per_plane) {
  ComponentwiseLevel& here = *levels_[level];
  if (level + 1 == levels_.size()) {
    solve_coarsest(start == Start::zero);
    for (int z = 0; dot_per_plane != nullptr && z < here.nodes()[2]; ++z)
      dot_per_plane[z] = dot(here.A(), z, here.u.data(), here.f.data());
    return;
  }
  go_down(level, start);
  cycle(level + 1, Start::zero, nullptr);
  come_up(level, dot_per_plane);
}

void ComponentwiseMultigrid::go_down(std::size_t level, Start start) {
  ComponentwiseLevel& fine = *levels_[level];
  ComponentwiseLevel& coarse = *levels_[level + 1];
  const ComponentwiseOperator& A = fine.A();
  float *const u = fine.u.data(), *const f = fine.f.data(), *const r = fine.r.data();
  const auto transfer = views(fine);
  const int first = start == Start::coarser ? 1 : 0; // a stage more, ahead of the others
  run_stages(team_for(fine), A.nodes[2], 4 + first, [&](int stage, int z) {
    if (stage < first)
      prolong_plane(coarse.A(), A, transfer.data(), z, coarse.u.data(), true, u,
                    scratch_of(scratch_size(fine)));
    else if (stage == first && start == Start::zero)
      start_relaxation(A, z, step_weights[0], f, r);
    else if (stage == first)
      relax_plane(A, z, step_weights[0], f, u, r);
    else if (stage == first + 1)
      relax_plane(A, z, step_weights[1], f, r, u);
    else if (stage == first + 2)
      find_residual(A, z, f, u, r);
    else
      for (const int z_coarse : triggered_[level][static_cast<std::size_t>(z)])
        restrict_plane(coarse.A(), A, transfer.data(), z_coarse, r, coarse.f.data(),
                       scratch_of(scratch_size(fine)));
  });
}

void ComponentwiseMultigrid::come_up(std::size_t level, double* dot_per_plane) {
  ComponentwiseLevel& fine = *levels_[level];
  ComponentwiseLevel& coarse = *levels_[level + 1];
  const ComponentwiseOperator& A = fine.A();
  float *const u = fine.u.data(), *const f = fine.f.data(), *const r = fine.r.data();
  const auto transfer = views(fine);
  run_stages(team_for(fine), A.nodes[2], dot_per_plane == nullptr ? 3 : 4, [&](int stage, int z) {
    if (stage == 0)
      prolong_plane(coarse.A(), A, transfer.data(), z, coarse.u.data(), false, u,
                    scratch_of(scratch_size(fine)));
    else if (stage == 1)
      relax_plane(A, z, step_weights[1], f, u, r);
    else if (stage == 2)
      relax_plane(A, z, step_weights[0], f, r, u);
    else
      dot_per_plane[z] = dot(A, z, u, f);
  });
}

void ComponentwiseMultigrid::restrict_to(std::size_t level, const PaddedArray& fine_values) {
  ComponentwiseLevel &fine = *levels_[level - 1], &coarse = *levels_[level];
  const auto transfer = views(fine);
  team_for(fine).run(coarse.nodes()[2], [&](int z, int) {
    restrict_plane(coarse.A(), fine.A(), transfer.data(), z, fine_values.data(), coarse.f.data(),
                   scratch_of(scratch_size(fine)));
  });
}

void ComponentwiseMultigrid::solve_from_coarsest(bool has_forces) {
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    ComponentwiseLevel& here = *levels_[level];
    here.clear(here.u);
    here.place_fixed(here.u.data());
    if (level > 0 && has_forces)
      restrict_to(level, levels_[level - 1]->f);
    else if (level > 0)
      here.clear(here.f);
  }
  solve_coarsest(false);
  for (std::size_t level = levels_.size() - 1; level-- > 0;) {
    cycle(level, Start::coarser, nullptr);
  }
}

/// The pseudo-inverse: where nothing is fixed on the coarsest level, shifts stay out of the correction.
void ComponentwiseMultigrid::factor_coarsest() {
  const ComponentwiseLevel& coarsest = *levels_.back();
  std::vector<Index3> places;
  for (std::int64_t node = 0; node < coarsest.n_nodes(); ++node)
    if (const Index3 at = coarsest.node_at(node); coarsest.may_move(at)) {
      places.push_back(at);
      unknowns_.push_back(coarsest.offset(at));
    }
  const auto n = static_cast<Eigen::Index>(unknowns_.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Index3& at = places[static_cast<std::size_t>(i)];
    A(i, i) = coarsest.diagonal(at);
    for (std::size_t a = 0; a < 3; ++a) {
      Index3 next = at;
      ++next[a];
      const auto place = std::ranges::find(unknowns_, coarsest.offset(next));
      if (next[a] >= coarsest.nodes()[a] || place == unknowns_.end())
        continue;
      const Eigen::Index j = place - unknowns_.begin();
      A(i, j) = A(j, i) = -coarsest.weight(at, static_cast<int>(a));
    }
  }
  inverse_.resize(unknowns_.size() * unknowns_.size());
  if (n == 0)
    return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(A);
  const double smallest = 1e-11 * modes.eigenvalues()(n - 1);
  const Eigen::VectorXd inverted =
      modes.eigenvalues().unaryExpr([&](double value) { return value > smallest ? 1 / value : 0.0; });
  Eigen::Map<Eigen::MatrixXd>(inverse_.data(), n, n) =
      modes.eigenvectors() * inverted.asDiagonal() * modes.eigenvectors().transpose();
}

void ComponentwiseMultigrid::solve_coarsest(bool starts_from_zero) {
  ComponentwiseLevel& coarsest = *levels_.back();
  if (starts_from_zero)
    coarsest.clear(coarsest.u);
  for (int z = 0; z < coarsest.nodes()[2]; ++z)
    find_residual(coarsest.A(), z, coarsest.f.data(), coarsest.u.data(), coarsest.r.data());
  const std::size_t n = unknowns_.size();
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < n; ++j)
      sum += inverse_[i * n + j] * double{coarsest.r.data()[unknowns_[j]]};
    coarsest.u.data()[unknowns_[i]] += static_cast<float>(sum);
  }
}

std::int64_t ComponentwiseMultigrid::bytes() const {
  auto sum = static_cast<std::int64_t>((inverse_.size() + sums_.size()) * sizeof(double));
  for (const auto& level : levels_)
    sum += level->bytes();
  return sum;
}

} // namespace maille::deform
