#include "world/touch/allowed_twist.hpp"

#include "lattice/tolerances.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <span>

namespace maille::deform {

namespace {

constexpr std::size_t most_binding = 16; ///< more than six, because some may be nearly equal
/// Relative regularisation of the diagonal: nearly equal rows then have a unique solution.
constexpr double regularisation = 1e-10;

/// Active constraints with their multipliers.
class Binding {
public:
  explicit Binding(std::span<const Twist> rows) : rows_(rows) {}

  bool is_full() const { return n_ == most_binding; }
  bool has(std::size_t row) const {
    return std::find(set_.begin(), set_.begin() + n_, row) != set_.begin() + n_;
  }

  /// Adds a constraint and releases those whose multipliers would become negative.
  void add(std::size_t row, const Twist& wanted, std::span<const double> least) {
    set_[n_] = row;
    forces_[n_++] = 0;
    while (n_ > 0 && !settle(wanted, least)) {
    }
  }

  Twist applied(Twist twist) const {
    for (std::size_t i = 0; i < n_; ++i)
      twist += forces_[i] * rows_[set_[i]];
    return twist;
  }

private:
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_binding, most_binding>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_binding, 1>;

  /// Moves towards the multipliers of the whole set until one becomes 0. @return true if it reached them
  bool settle(const Twist& wanted, std::span<const double> least) {
    const auto n = static_cast<Eigen::Index>(n_);
    Matrix gram(n, n);
    Vector right(n);
    for (std::size_t i = 0; i < n_; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      right[row] = least[set_[i]] - rows_[set_[i]].dot(wanted);
      for (std::size_t j = 0; j < n_; ++j)
        gram(row, static_cast<Eigen::Index>(j)) = rows_[set_[i]].dot(rows_[set_[j]]);
      gram(row, row) *= 1 + regularisation;
    }
    const Vector found = gram.llt().solve(right);
    double part = 1;
    for (std::size_t i = 0; i < n_; ++i)
      if (const double aim = found[static_cast<Eigen::Index>(i)]; aim < 0)
        part = std::min(part, forces_[i] / (forces_[i] - aim));
    const double nothing = 1e-14 * found.cwiseAbs().maxCoeff();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < n_; ++i) {
      const double force = forces_[i] + part * (found[static_cast<Eigen::Index>(i)] - forces_[i]);
      if (part < 1 && force <= nothing)
        continue;
      set_[kept] = set_[i];
      forces_[kept++] = force;
    }
    n_ = kept;
    return part >= 1;
  }

  std::span<const Twist> rows_;
  std::array<std::size_t, most_binding> set_{};
  std::array<double, most_binding> forces_{};
  std::size_t n_ = 0;
};

} // namespace

void TwistConstraints::add(const Eigen::Vector3d& normal, const Eigen::Vector3d& point, double gap) {
  if (n_ == most)
    return;
  rows_[n_] << normal, point.cross(normal) / arm_;
  normals_[n_] = normal;
  points_[n_] = point;
  gaps_[n_++] = gap;
}

Twist TwistConstraints::allowed(const Twist& wanted, double margin) const {
  Least least;
  for (std::size_t i = 0; i < n_; ++i)
    least[i] = margin - gaps_[i];
  const Twist straight = nearest(wanted, least);
  const Eigen::Vector3d turn = straight.tail<3>() / arm_;
  bool is_bent = false;
  for (std::size_t i = 0; i < n_; ++i)
    if (const double bend = -0.5 * normals_[i].dot(turn.cross(turn.cross(points_[i]))); bend > 0) {
      least[i] += 1.2 * bend; // the resulting rotation may be slightly larger
      is_bent = true;
    }
  return is_bent ? nearest(wanted, least) : straight;
}

/// Active-set method of Lawson and Hanson for the least distance: the most violated constraint enters.
Twist TwistConstraints::nearest(const Twist& wanted, const Least& least) const {
  Binding binding(std::span<const Twist>(rows_.data(), n_));
  const double near = tolerance * wanted.norm();
  Twist twist = wanted;
  for (int round = 0; round < iteration_cap && !binding.is_full(); ++round) {
    std::size_t worst = n_;
    double missing = near;
    for (std::size_t i = 0; i < n_; ++i)
      if (const double one = least[i] - rows_[i].dot(twist); one > missing && !binding.has(i)) {
        missing = one;
        worst = i;
      }
    if (worst == n_)
      break;
    binding.add(worst, wanted, least);
    twist = binding.applied(wanted);
  }
  return twist;
}

} // namespace maille::deform
