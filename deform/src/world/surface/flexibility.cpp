#include "world/surface/flexibility.hpp"

#include "elastic/masked/masked_solver.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "elastic/model/stiffness_blocks.hpp"
#include "elastic/multigrid/chebyshev.hpp"
#include "lattice/tolerances.hpp"
#include "maille/plugins/sparse_cholesky.hpp"

#include <Eigen/Geometry>
#include <Eigen/QR>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Orthonormal basis of the shifts and rotations of all nodes.
Eigen::MatrixXd rigid_motions(const Specimen& body, const std::vector<std::int64_t>& nodes) {
  const int d = body.grid.dimension();
  const auto n = static_cast<Eigen::Index>(nodes.size());
  Eigen::MatrixXd places(3, n);
  for (Eigen::Index i = 0; i < n; ++i)
    places.col(i) = Eigen::Vector3d::Map(body.position(body.grid.node_at(nodes[i])).data());
  places.colwise() -= places.rowwise().mean().eval();
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(d * n, d == 2 ? 3 : 6);
  for (Eigen::Index i = 0; i < n; ++i)
    for (int a = 0; a < d; ++a) {
      motions(d * i + a, a) = 1;
      for (int turn = 0; turn < (d == 2 ? 1 : 3); ++turn) {
        const Eigen::Vector3d axis = Eigen::Vector3d::Unit(d == 2 ? 2 : turn);
        motions(d * i + a, d + turn) = axis.cross(Eigen::Vector3d(places.col(i)))[a];
      }
    }
  Eigen::HouseholderQR<Eigen::MatrixXd> factor(motions);
  return factor.householderQ() * Eigen::MatrixXd::Identity(motions.rows(), motions.cols());
}

/// In 3D, above this number of components, a column by multigrid is faster than factor and solve.
constexpr std::int64_t most_factored = 3'000;

/// Relative residual of columns without inertia: far below the differences between nearly redundant contacts.
/// Everything else is solved to `tolerance`.
constexpr double of_columns = 1e-7;
/// Reduction of the residual in one float32 solve. A smaller value loses more to rounding; a larger one takes
/// more rounds.
constexpr double reduction = 1e-5;
/// Safety factor on the requested reduction: conjugate gradients minimise a different norm.
constexpr double safely = 0.2;
constexpr std::int64_t most_column_bytes = std::int64_t{1} << 30;
/// Largest supernodal factor, in numbers of 8 bytes: 320 MB. Ordering more than `most_ordered` components
/// takes seconds, and their factor exceeds this size.
constexpr double most_factor_numbers = 4e7;
constexpr std::int64_t most_ordered = 200'000;
/// Number of columns from which one solve for the total force is faster than the sum of columns.
constexpr std::ptrdiff_t most_summed = 500;
/// Columns per solve: fewer read the factor more often, more take more memory.
constexpr std::size_t columns_at_once = 48;

/// Cholesky factor of the stiffness of the free components.
class FactorOfFree {
public:
  /// @param fixed by node of the body
  FactorOfFree(const FixedMask& fixed, Eigen::Index dimension) {
    for (Eigen::Index i = 0; i < dimension * static_cast<Eigen::Index>(fixed.n_nodes()); ++i)
      if (!fixed(i % dimension, i / dimension))
        free_.push_back(i);
  }
  /// @return false if the matrix is not positive definite
  bool make(std::unique_ptr<SparseCholesky> factor, const Eigen::SparseMatrix<double>& lower) {
    if (factor->factor(lower) > 0)
      factor_ = std::move(factor);
    return is_made();
  }
  bool is_made() const { return factor_ != nullptr; }
  Eigen::MatrixXd solve(const Eigen::MatrixXd& forces) const {
    Eigen::MatrixXd answer = Eigen::MatrixXd::Zero(forces.rows(), forces.cols());
    answer(free_, Eigen::all) = factor_->solve(forces(free_, Eigen::all));
    return answer;
  }
  std::span<const Eigen::Index> free() const { return free_; }

private:
  std::vector<Eigen::Index> free_;
  std::unique_ptr<SparseCholesky> factor_;
};

class FactoredStiffness : public BodyStiffness {
public:
  FactoredStiffness(const Scene& scene, const std::vector<std::int64_t>& nodes, const FixedMask& fixed,
                    const Eigen::VectorXd& inertia);
  Eigen::VectorXd solve(const Eigen::VectorXd& forces, double) override { return factor_.solve(forces); }
  Eigen::VectorXd forces(const Eigen::VectorXd& displacement) const override {
    return stiffness_ * displacement;
  }
  double force_at(std::int64_t component, const Eigen::VectorXd& displacement) const override {
    return stiffness_.col(component).dot(displacement); // the matrix is symmetric
  }

private:
  Eigen::SparseMatrix<double> stiffness_;
  FactorOfFree factor_;
};

FactoredStiffness::FactoredStiffness(const Scene& scene, const std::vector<std::int64_t>& nodes,
                                     const FixedMask& fixed, const Eigen::VectorXd& inertia)
    : factor_(fixed, scene.dimension()) {
  const StiffnessBlocks blocks(scene.specimen, LatticeElasticity(scene), nodes);
  stiffness_ = blocks.lower(FixedMask(nodes.size())).selfadjointView<Eigen::Lower>();
  Eigen::SparseMatrix<double> lower = blocks.lower(fixed);
  for (Eigen::Index column = 0; column < lower.cols() && inertia.size() > 0; ++column)
    lower.coeffRef(column, column) += inertia[factor_.free()[column]];
  if (!factor_.make(simplicial_cholesky(lower), lower))
    throw std::invalid_argument("Flexibility: a body that is held so that no rigid motion is left");
}

/// Iterative refinement: residuals in float64, corrections by conjugate gradients with multigrid in float32.
/// If allowed, a supernodal factor is made for the first set of columns.
class MultigridStiffness : public BodyStiffness {
public:
  MultigridStiffness(const Scene& scene, std::vector<std::int64_t> nodes, const FixedMask& fixed,
                     const Eigen::VectorXd& inertia, int threads);
  /// @return true if the factor was made @throws std::runtime_error without CHOLMOD
  bool make_factor();
  void factor_if_asked() { may_factor_ = true; }
  void prepare() override;
  Eigen::VectorXd solve(const Eigen::VectorXd& forces, double accuracy) override;
  Eigen::MatrixXd solve_all(const Eigen::MatrixXd& forces, double accuracy) override;
  Eigen::VectorXd forces(const Eigen::VectorXd& displacement) const override;
  double force_at(std::int64_t component, const Eigen::VectorXd& displacement) const override;

private:
  static LatticeElasticity with_inertia(const Scene& scene, const std::vector<std::int64_t>& nodes,
                                        const Eigen::VectorXd& inertia, ThreadTeam& team);
  void hold(Eigen::VectorXd& values) const;
  void spread(const Eigen::VectorXd& values, Displacement& field) const;
  Eigen::VectorXd gathered(const Displacement& field) const;
  static std::vector<Prescribed> prescribed(const std::vector<std::int64_t>& nodes, const FixedMask& fixed);

  const Specimen& body_;
  std::vector<std::int64_t> nodes_;
  const FixedMask& fixed_;
  Eigen::VectorXd inertia_;
  mutable ThreadTeam team_;
  LatticeElasticity elasticity_; ///< with inertia as springs
  MaskedMultigrid multigrid_;
  MaskedSystem system_;
  bool may_factor_ = false;
  FactorOfFree factor_;
};

MultigridStiffness::MultigridStiffness(const Scene& scene, std::vector<std::int64_t> nodes,
                                       const FixedMask& fixed, const Eigen::VectorXd& inertia, int threads)
    : body_(scene.specimen), nodes_(std::move(nodes)), fixed_(fixed), inertia_(inertia), team_(threads),
      elasticity_(with_inertia(scene, nodes_, inertia, team_)),
      multigrid_(std::make_unique<MaskedLevel>(scene, elasticity_, prescribed(nodes_, fixed), team_),
                 relaxation_steps(largest_contrast(scene)), team_),
      system_(body_.grid, elasticity_, multigrid_, team_), factor_(fixed, 3) {}

LatticeElasticity MultigridStiffness::with_inertia(const Scene& scene, const std::vector<std::int64_t>& nodes,
                                                   const Eigen::VectorXd& inertia, ThreadTeam& team) {
  LatticeElasticity elasticity(scene, team);
  List<NodalSpring> springs;
  for (std::size_t i = 0; i < nodes.size() && inertia.size() > 0; ++i)
    springs.push_back(
        {nodes[i], Eigen::Matrix3d(inertia.segment<3>(3 * static_cast<Eigen::Index>(i)).asDiagonal())});
  elasticity.set_springs(std::move(springs));
  return elasticity;
}

std::vector<Prescribed> MultigridStiffness::prescribed(const std::vector<std::int64_t>& nodes,
                                                       const FixedMask& fixed) {
  std::vector<Prescribed> list;
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (fixed(b, i))
        list.push_back({nodes[i], static_cast<int>(b), 0, true});
  return list;
}

void MultigridStiffness::hold(Eigen::VectorXd& values) const {
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (fixed_(i % 3, i / 3))
      values[i] = 0;
}

void MultigridStiffness::spread(const Eigen::VectorXd& values, Displacement& field) const {
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    for (int b = 0; b < 3; ++b)
      field(b, nodes_[i]) = values[3 * static_cast<Eigen::Index>(i) + b];
}

Eigen::VectorXd MultigridStiffness::gathered(const Displacement& field) const {
  Eigen::VectorXd values(3 * static_cast<Eigen::Index>(nodes_.size()));
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    for (int b = 0; b < 3; ++b)
      values[3 * static_cast<Eigen::Index>(i) + b] = field(b, nodes_[i]);
  return values;
}

bool MultigridStiffness::make_factor() {
  std::vector<std::int32_t> group;
  const Eigen::SparseMatrix<double> lower = StiffnessBlocks(body_, elasticity_, nodes_).lower(fixed_, &group);
  auto factor = supernodal_cholesky(lower, group, true);
  return factor->n_numbers() <= most_factor_numbers && factor_.make(std::move(factor), lower);
}

void MultigridStiffness::prepare() {
  if (!std::exchange(may_factor_, false) || 3 * std::ssize(nodes_) > most_ordered)
    return;
  try {
    make_factor();
  } catch (const std::runtime_error&) { // without CHOLMOD, multigrid is used
  }
}

Eigen::MatrixXd MultigridStiffness::solve_all(const Eigen::MatrixXd& forces, double accuracy) {
  prepare();
  return factor_.is_made() ? factor_.solve(forces) : BodyStiffness::solve_all(forces, accuracy);
}

Eigen::VectorXd MultigridStiffness::solve(const Eigen::VectorXd& forces, double accuracy) {
  if (factor_.is_made())
    return factor_.solve(forces);
  Eigen::VectorXd residual = forces, answer = Eigen::VectorXd::Zero(forces.size());
  hold(residual);
  Displacement field(body_.grid), correction(body_.grid);
  const double enough = accuracy * residual.norm();
  double left = residual.norm();
  for (int round = 0; round < iteration_cap && left > enough; ++round) {
    spread(residual, field);
    system_.find_direction(field, iteration_cap, std::max(reduction, safely * enough / left), correction);
    answer += gathered(correction);
    spread(answer, field);
    elasticity_.apply(field, correction, team_);
    residual = forces - gathered(correction);
    hold(residual);
    if (const double before = std::exchange(left, residual.norm()); !(left < before))
      break; // at rounding level
  }
  return answer;
}

Eigen::VectorXd MultigridStiffness::forces(const Eigen::VectorXd& displacement) const {
  Displacement field(body_.grid), pulls(body_.grid);
  spread(displacement, field);
  elasticity_.apply(field, pulls, team_);
  Eigen::VectorXd forces = gathered(pulls);
  if (inertia_.size() > 0)
    forces -= inertia_.cwiseProduct(displacement);
  return forces;
}

double MultigridStiffness::force_at(std::int64_t component, const Eigen::VectorXd& displacement) const {
  const std::int64_t node = nodes_[component / 3];
  double force = 0;
  body_.for_each_cell_at(body_.grid.node_at(node), [&](std::int64_t cell) {
    Eigen::Matrix<double, 3, 8> u;
    int own = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const std::int64_t at = body_.grid.corner(body_.grid.cell_at(cell), corner);
      if (at == node)
        own = corner;
      const auto place = std::ranges::lower_bound(nodes_, at) - nodes_.begin();
      u.col(corner) = displacement.segment<3>(3 * place);
    }
    force += elasticity_.cell_forces<3>(cell, u)(component % 3, own);
  });
  return force;
}

} // namespace

Eigen::MatrixXd BodyStiffness::solve_all(const Eigen::MatrixXd& forces, double accuracy) {
  Eigen::MatrixXd answer(forces.rows(), forces.cols());
  for (Eigen::Index i = 0; i < forces.cols(); ++i)
    answer.col(i) = solve(forces.col(i), accuracy);
  return answer;
}

Flexibility::Flexibility(const Scene& scene, const std::vector<std::int64_t>& fixed,
                         const Eigen::VectorXd& inertia, bool floats, int threads, StiffnessSolver solver)
    : column_accuracy_(inertia.size() > 0 ? tolerance : of_columns), dimension_(scene.dimension()) {
  std::vector<std::int64_t> nodes = nodes_of_matter(scene.specimen);
  const int d = scene.dimension();
  if (floats)
    rigid_ = rigid_motions(scene.specimen, nodes);
  fixed_ = FixedMask(nodes.size());
  for (const std::int64_t component : fixed)
    fixed_.fix(component / d, static_cast<std::uint8_t>(1U << (component % d)));
  const bool is_small = d == 2 || n_components() <= most_factored;
  if (solver == StiffnessSolver::factor || (solver == StiffnessSolver::quickest && is_small)) {
    stiffness_ = std::make_unique<FactoredStiffness>(scene, nodes, fixed_, inertia);
    return;
  }
  auto stiffness = std::make_unique<MultigridStiffness>(scene, std::move(nodes), fixed_, inertia, threads);
  if (solver == StiffnessSolver::quickest)
    stiffness->factor_if_asked();
  if (solver == StiffnessSolver::quickest && inertia.size() > 0)
    stiffness->prepare(); // all steps share the factor, and momentum needs exact columns
  if (solver == StiffnessSolver::supernodal && !stiffness->make_factor())
    throw std::runtime_error("Flexibility: the factor would have too many numbers");
  stiffness_ = std::move(stiffness);
}

Eigen::VectorXd Flexibility::force_for_column(std::int64_t component) const {
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(n_components());
  if (rigid_.size() > 0 || !is_fixed(component))
    unit[component] = 1;
  if (rigid_.size() > 0)
    unit -= rigid_ * rigid_.row(component).transpose();
  return unit;
}

template<class Values>
void Flexibility::take_rigid_motions_from(Values& values) const {
  if (rigid_.size() > 0)
    values -= rigid_ * (rigid_.transpose() * values).eval();
}

void Flexibility::find_columns(std::span<const std::int64_t> components) {
  std::vector<std::int64_t> wanted;
  for (const std::int64_t component : components) {
    const auto [entry, is_new] = columns_.try_emplace(component);
    entry->second.is_used = true;
    if (is_new)
      wanted.push_back(component);
  }
  for (std::size_t first = 0; first < wanted.size(); first += columns_at_once) {
    const auto some = std::span(wanted).subspan(first, std::min(columns_at_once, wanted.size() - first));
    Eigen::MatrixXd forces(n_components(), std::ssize(some));
    for (std::size_t i = 0; i < some.size(); ++i)
      forces.col(static_cast<Eigen::Index>(i)) = force_for_column(some[i]);
    Eigen::MatrixXd found = stiffness_->solve_all(forces, column_accuracy_);
    take_rigid_motions_from(found);
    for (std::size_t i = 0; i < some.size(); ++i)
      columns_[some[i]].values = found.col(static_cast<Eigen::Index>(i));
  }
}

const Eigen::VectorXd& Flexibility::column(std::int64_t component) {
  find_columns({&component, 1});
  return columns_[component].values;
}

const Eigen::MatrixXd& Flexibility::compliance(const std::vector<std::int64_t>& components) {
  find_columns(components);
  if (components == kept_components_)
    return kept_compliance_;
  const std::vector<std::int64_t> before = std::exchange(kept_components_, components);
  const Eigen::MatrixXd known = std::move(kept_compliance_);
  const auto n = std::ssize(components);
  const Eigen::Map<const Eigen::VectorX<std::int64_t>> component(components.data(), n);
  Eigen::VectorX<Eigen::Index> place(n); // among the components known before; -1: new
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto at = std::ranges::lower_bound(before, component[i]);
    place[i] = at != before.end() && *at == component[i] ? at - before.begin() : -1;
  }
  kept_compliance_.resize(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const Eigen::VectorXd& column = columns_[component[j]].values;
    for (Eigen::Index i = 0; i < n; ++i)
      kept_compliance_(i, j) =
          place[i] >= 0 && place[j] >= 0 ? known(place[i], place[j]) : column[component[i]];
  }
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < j; ++i)
      if (place[i] < 0 || place[j] < 0) // mean of the entries of both columns
        kept_compliance_(i, j) = kept_compliance_(j, i) =
            0.5 * (kept_compliance_(i, j) + kept_compliance_(j, i));
  return kept_compliance_;
}

void Flexibility::watch(const std::vector<std::int32_t>& nodes) {
  watched_ = nodes;
  for (auto& [component, column] : columns_)
    column.watched.resize(0);
}

const Eigen::VectorXd& Flexibility::watched_column(std::int64_t component) {
  const Eigen::VectorXd& whole = column(component);
  Eigen::VectorXd& part = columns_[component].watched;
  const Eigen::Index n = dimension_ * std::ssize(watched_);
  if (watches_all())
    return whole;
  if (part.size() != n) {
    part.resize(n);
    for (std::size_t i = 0; i < watched_.size(); ++i)
      part.segment(dimension_ * static_cast<Eigen::Index>(i), dimension_) =
          whole.segment(std::int64_t{dimension_} * watched_[i], dimension_);
  }
  return part;
}

Eigen::VectorXd Flexibility::moved_by(const Eigen::VectorXd& forces,
                                      std::span<const std::int64_t> components) {
  if (std::ssize(components) < most_summed) {
    find_columns(components);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(n_components());
    for (const std::int64_t component : components)
      sum += forces[component] * columns_[component].values;
    return sum;
  }
  Eigen::VectorXd balanced = forces;
  take_rigid_motions_from(balanced);
  Eigen::VectorXd sum = stiffness_->solve(balanced, tolerance);
  take_rigid_motions_from(sum);
  return sum;
}

void Flexibility::forget_unused() {
  const auto bytes = static_cast<std::int64_t>(columns_.size() * sizeof(double)) * n_components();
  const bool are_many = bytes > most_column_bytes;
  std::erase_if(columns_, [&](auto& column) { return are_many && !column.second.is_used; });
  for (auto& [component, column] : columns_)
    column.is_used = false;
}

Eigen::VectorXd Flexibility::solve(const Eigen::VectorXd& forces) const {
  return stiffness_->solve(forces, tolerance);
}

Eigen::VectorXd Flexibility::moved(const Eigen::VectorXd& prescribed) const {
  if (rigid_.size() > 0)
    return rigid_ * (rigid_.transpose() * prescribed);
  Eigen::VectorXd given = prescribed;
  for (Eigen::Index i = 0; i < given.size(); ++i)
    if (!is_fixed(i))
      given[i] = 0;
  if (given.isZero(0))
    return given;
  return given - solve(stiffness_->forces(given));
}

} // namespace maille::deform
