#include "elastic/krylov/kept_body.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace maille::deform {

namespace {

/// Relative distance below which two sets of data count as the same direction.
constexpr double same_direction = 1e-3;
/// Earlier answers that leave more than this of what is asked are no start.
constexpr double too_far = 0.5;

Scene matter_of(const Scene& scene) {
  Scene matter;
  matter.specimen = scene.specimen;
  matter.specimen.label.clear();
  matter.materials = scene.materials;
  matter.plane = scene.plane;
  matter.springs = scene.springs;
  return matter;
}

bool is_same_spring(const FaceSpring& a, const FaceSpring& b) {
  return a.cell == b.cell && a.axis == b.axis && a.upper == b.upper && a.stiffness == b.stiffness &&
         a.direction == b.direction;
}

bool is_same_kind(const Material& a, const Material& b) {
  return a.elasticity.is_isotropic() == b.elasticity.is_isotropic();
}

/// Ratio of two stiffnesses, for the strain in which they differ most.
double ratio_between(const Matrix6& a, const Matrix6& b) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> of(a, b, Eigen::EigenvaluesOnly);
  const double least = of.eigenvalues().minCoeff(), most = of.eigenvalues().maxCoeff();
  return least > 0 ? std::max(most, 1 / least) : std::numeric_limits<double>::infinity();
}

double product(const List<double>& a, const List<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i)
    sum += a[i] * b[i];
  return sum;
}

double product(const std::array<List<double>, 3>& a, const std::array<List<double>, 3>& b) {
  return product(a[0], b[0]) + product(a[1], b[1]) + product(a[2], b[2]);
}

/// Products of data, of earlier questions and the new one (last): of what is prescribed, and of loads.
struct Products {
  Eigen::MatrixXd values, loads;
  explicit Products(Eigen::Index n)
      : values(Eigen::MatrixXd::Zero(n, n)), loads(Eigen::MatrixXd::Zero(n, n)) {}
  /// Both count alike: each over the largest that there is.
  Eigen::MatrixXd of_both() const {
    const auto over_largest = [](const Eigen::MatrixXd& m) -> Eigen::MatrixXd {
      const double most = m.diagonal().maxCoeff();
      return most > 0 ? Eigen::MatrixXd(m / most) : m;
    };
    return over_largest(values) + over_largest(loads);
  }
};

} // namespace

bool EarlierAnswers::find_start(const Scene& scene, const std::vector<Prescribed>& prescribed,
                                Displacement& u) {
  was_spanned_ = false;
  if (answers_.empty())
    return false;
  const std::array<List<double>, 3> loads = loads_of(scene);
  const auto n = static_cast<Eigen::Index>(answers_.size());
  const auto earlier = [&](Eigen::Index i) -> const One& { return answers_[i]; };
  Products products(n + 1);
  std::vector<double> here(static_cast<std::size_t>(n) + 1);
  for (const Prescribed& p : prescribed) {
    for (Eigen::Index i = 0; i < n; ++i)
      here[i] = earlier(i).u(p.component, p.node);
    here.back() = p.value;
    const Eigen::Map<const Eigen::VectorXd> data(here.data(), n + 1);
    products.values.noalias() += data * data.transpose();
  }
  for (Eigen::Index i = 0; i <= n; ++i)
    for (Eigen::Index j = 0; j <= n; ++j)
      products.loads(i, j) = product(i < n ? earlier(i).loads : loads, j < n ? earlier(j).loads : loads);
  const Eigen::MatrixXd all = products.of_both();
  const double size = all(n, n);
  if (!(size > 0))
    return false;
  // Data are normalised, so that small answers count as large ones do; the newest come first.
  Eigen::VectorXd unit = all.diagonal().head(n);
  for (double& entry : unit)
    entry = entry > 0 ? 1 / std::sqrt(entry) : 0;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(same_direction * same_direction);
  decomposition.compute(unit.asDiagonal() * all.topLeftCorner(n, n) * unit.asDiagonal());
  const Eigen::VectorXd part =
      unit.asDiagonal() * decomposition.solve(unit.asDiagonal() * all.col(n).head(n)).eval();
  const double left = size - 2 * part.dot(all.col(n).head(n)) + part.dot(all.topLeftCorner(n, n) * part);
  was_spanned_ = left <= same_direction * same_direction * size;
  if (left > too_far * too_far * size)
    return false;
  u = Displacement(scene.specimen.grid);
  const std::span<double> values = u.values();
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::span<const double> from = earlier(i).u.values();
    for (std::size_t k = 0; part[i] != 0 && k < values.size(); ++k)
      values[k] += part[i] * from[k];
  }
  return true;
}

void EarlierAnswers::add(const Scene& scene, const Displacement& u) {
  if (are_of_before_)
    answers_.clear();
  are_of_before_ = false;
  if (was_spanned_ && !answers_.empty())
    answers_.pop_back(); // the others tell what it told
  else if (answers_.size() == most)
    answers_.erase(answers_.begin());
  answers_.push_back({u, loads_of(scene)});
}

void EarlierAnswers::matter_has_changed() {
  if (answers_.size() > 1)
    answers_.erase(answers_.begin(), answers_.end() - 1);
  are_of_before_ = true;
}

KeptBody::KeptBody(const Scene& scene, int threads)
    : scene_(matter_of(scene)), of_scene_(scene_.specimen.material_id.size() +
                                          scene_.specimen.fibres.size() * sizeof(scene_.specimen.fibres[0])),
      team_(threads) {}

bool KeptBody::is_of(const Scene& question) const {
  const Specimen &here = scene_.specimen, &there = question.specimen;
  return here.grid.cells() == there.grid.cells() && here.grid.spacing() == there.grid.spacing() &&
         here.grid.dimension() == there.grid.dimension() && here.material_id == there.material_id &&
         here.fibre == there.fibre && here.fibres == there.fibres && here.tissue == there.tissue &&
         here.stiffness_ratio == there.stiffness_ratio && scene_.plane == question.plane &&
         std::ranges::equal(scene_.springs, question.springs, is_same_spring) &&
         std::ranges::equal(scene_.materials, question.materials, is_same_kind);
}

double KeptBody::take_materials(const Scene& question) {
  double ratio = 1;
  for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
    const Matrix6 before = maille::stiffness(scene_.materials[i].elasticity),
                  now = maille::stiffness(question.materials[i].elasticity);
    if (before != now)
      ratio = std::max(ratio, ratio_between(now, before));
    scene_.materials[i] = question.materials[i];
  }
  if (ratio > 1) {
    answers.matter_has_changed();
    if (hierarchy && (begins_anew || !hierarchy->take_materials(ratio)))
      hierarchy.reset();
  }
  return ratio;
}

} // namespace maille::deform
