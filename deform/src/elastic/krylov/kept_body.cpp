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
/// Largest share of the question that a useful start may leave unexplained; answers nearer to each other than
/// this part of the way ahead support no polynomial.
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

Eigen::MatrixXd over_largest(const Eigen::MatrixXd& m) {
  const double most = m.diagonal().maxCoeff();
  return most > 0 ? Eigen::MatrixXd(m / most) : m;
}

} // namespace

/// Products of the data of earlier answers and of the new question (last). What is prescribed and loads count
/// alike: each over the largest that there is.
Eigen::MatrixXd EarlierAnswers::products_with(const Scene& scene,
                                              const std::vector<Prescribed>& prescribed) const {
  const Loads loads = loads_of(scene);
  const auto n = static_cast<Eigen::Index>(answers_.size());
  const auto earlier = [&](Eigen::Index i) -> const One& { return answers_[i]; };
  Eigen::MatrixXd of_values = Eigen::MatrixXd::Zero(n + 1, n + 1), of_loads = of_values;
  std::vector<double> here(static_cast<std::size_t>(n) + 1);
  for (const Prescribed& p : prescribed) {
    for (Eigen::Index i = 0; i < n; ++i)
      here[i] = earlier(i).u(p.component, p.node);
    here.back() = p.value;
    const Eigen::Map<const Eigen::VectorXd> data(here.data(), n + 1);
    of_values.noalias() += data * data.transpose();
  }
  for (Eigen::Index i = 0; i <= n; ++i)
    for (Eigen::Index j = 0; j <= n; ++j)
      of_loads(i, j) = product(i < n ? earlier(i).loads : loads, j < n ? earlier(j).loads : loads);
  return over_largest(of_values) + over_largest(of_loads);
}

Displacement EarlierAnswers::mean(const Scene& scene, const Eigen::VectorXd& weights) const {
  Displacement u(scene.specimen.grid);
  const std::span<double> values = u.values();
  for (std::size_t i = 0; i < answers_.size(); ++i) {
    const double weight = weights[static_cast<Eigen::Index>(i)];
    const std::span<const double> from = answers_[i].u.values();
    for (std::size_t k = 0; weight != 0 && k < values.size(); ++k)
      values[k] += weight * from[k];
  }
  return u;
}

bool EarlierAnswers::find_start(const Scene& scene, const std::vector<Prescribed>& prescribed,
                                Displacement& u) {
  was_spanned_ = false;
  if (answers_.empty())
    return false;
  const auto n = static_cast<Eigen::Index>(answers_.size());
  const Eigen::MatrixXd all = products_with(scene, prescribed);
  const double size = all(n, n);
  if (!(size > 0))
    return false;
  // Normalised data give small answers the same weight as large ones; the newest come first.
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
  u = mean(scene, part);
  return true;
}

std::optional<bool> EarlierAnswers::find_course(const Scene& scene, const std::vector<Prescribed>& prescribed,
                                                Displacement& u) {
  was_spanned_ = false;
  if (answers_.empty())
    return std::nullopt;
  const auto n = static_cast<Eigen::Index>(answers_.size()), last = n - 1;
  const Eigen::MatrixXd all = products_with(scene, prescribed);
  const Eigen::VectorXd ahead = Eigen::VectorXd::Unit(n + 1, n) - Eigen::VectorXd::Unit(n + 1, last);
  const double way = ahead.dot(all * ahead);
  Eigen::VectorXd weights = Eigen::VectorXd::Unit(n, last);
  double left = way > std::pow(same_direction, 4) * all(n, n) ? way : 0; // else the question is the last one
  if (left > 0) {
    // Places along the way, the last answer's 0 and the new question's 1; rest has no data.
    const Eigen::VectorXd products = all * ahead;
    std::vector<double> places{0};
    std::vector<Eigen::Index> support{last};
    for (Eigen::Index i = last - 1; i >= -1; --i) {
      const double place = ((i < 0 ? 0 : products[i]) - products[last]) / way;
      if (std::ranges::all_of(places, [&](double other) { return std::abs(place - other) > too_far; })) {
        places.push_back(place);
        support.push_back(i);
      }
    }
    Eigen::VectorXd polynomial = Eigen::VectorXd::Zero(n + 1);
    for (std::size_t i = 0; i < places.size(); ++i) {
      double weight = 1; // of Lagrange
      for (std::size_t j = 0; j < places.size(); ++j)
        weight *= j == i ? 1 : (1 - places[j]) / (places[i] - places[j]);
      if (support[i] >= 0)
        polynomial[support[i]] = weight;
    }
    const Eigen::VectorXd beyond = Eigen::VectorXd::Unit(n + 1, n) - polynomial;
    if (const double of_polynomial = beyond.dot(all * beyond); of_polynomial < way && places.size() > 2) {
      weights = polynomial.head(n);
      left = of_polynomial;
    }
  }
  u = mean(scene, weights);
  return left <= same_direction * same_direction * way;
}

void EarlierAnswers::add(const Scene& scene, const Displacement& u) {
  if (are_of_before_)
    answers_.clear();
  are_of_before_ = false;
  if (was_spanned_ && !answers_.empty())
    answers_.pop_back(); // it depends on the others
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

double KeptBody::adopt_materials(const Scene& question) {
  double ratio = 1;
  bool has_changed = false;
  for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
    const Matrix6 before = maille::stiffness(scene_.materials[i].elasticity),
                  now = maille::stiffness(question.materials[i].elasticity);
    if (before != now)
      ratio = std::max(ratio, ratio_between(now, before));
    has_changed = has_changed || before != now || scene_.materials[i].law != question.materials[i].law;
    scene_.materials[i] = question.materials[i];
  }
  if (has_changed)
    answers.matter_has_changed();
  if (ratio > 1) {
    if (hierarchy && (begins_anew || !hierarchy->adopt_materials(ratio)))
      hierarchy.reset();
  }
  return ratio;
}

} // namespace maille::deform
