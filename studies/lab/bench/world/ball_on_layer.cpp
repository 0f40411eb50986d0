#include "bench/world/ball_on_layer.hpp"

#include <Eigen/Dense>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

namespace maille::lab {

namespace {

using std::numbers::pi;

constexpr int points = 60;
/// Of waves: as short as a twelfth of the layer they know nothing of its ground (e^-24).
constexpr double shortest_wave = 12;
constexpr int waves = 400;

/// What a layer is stiffer by than a half-space, for a wave: 1 less the ratio of their surfaces' shifts under
/// the same pressure. @param x wave number times thickness
double missing_of_half_space(double x, double poisson_ratio) {
  const double k = 3 - 4 * poisson_ratio;
  return 1 - (2 * k * std::sinh(2 * x) - 4 * x) / (2 * k * std::cosh(2 * x) + 1 + k * k + 4 * x * x);
}

class Layer {
public:
  Layer(double ball, double depth, double thickness, double poisson_ratio)
      : ball_(ball), depth_(depth), thickness_(thickness) {
    for (int i = 0; i < waves; ++i)
      missing_.push_back(missing_of_half_space(wave(i), poisson_ratio));
  }

  /// Pressure's density in the transformed sense, at the middles of equal parts of the contact's radius, and
  /// at its end, where it has to be 0.
  struct Density {
    Eigen::VectorXd at;
    double end;
  };
  Density density(double radius) const {
    const double part = radius / points;
    std::vector<double> table; // by distance of two points in half parts, 0 for one point
    for (int i = 0; i <= 4 * points; ++i)
      table.push_back(kernel(0.5 * part * i));
    // Points are at odd numbers of half parts, the end at an even one.
    const auto pull = [&](int one, int other) {
      return (table[static_cast<std::size_t>(std::abs(one - other))] +
              table[static_cast<std::size_t>(one + other)]) *
             part / pi;
    };
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(points, points);
    Eigen::VectorXd given(points);
    for (int i = 0; i < points; ++i) {
      given[i] = shape((i + 0.5) * part);
      for (int j = 0; j < points; ++j)
        matrix(i, j) -= pull(2 * i + 1, 2 * j + 1);
    }
    Density density{matrix.partialPivLu().solve(given), shape(radius)};
    for (int j = 0; j < points; ++j)
      density.end += pull(2 * points, 2 * j + 1) * density.at[j];
    return density;
  }

private:
  double wave(int i) const { return (i + 0.5) * shortest_wave / waves; }
  /// Abel's transform of how deep the ball is in.
  double shape(double t) const { return 2 / pi * (depth_ - 0.5 * t * std::log((ball_ + t) / (ball_ - t))); }
  double kernel(double apart) const {
    double sum = 0;
    for (int i = 0; i < waves; ++i)
      sum += missing_[static_cast<std::size_t>(i)] * std::cos(wave(i) * apart / thickness_);
    return sum * shortest_wave / waves / thickness_;
  }

  double ball_, depth_, thickness_;
  std::vector<double> missing_;
};

} // namespace

LayerContact ball_on_layer(double ball, double depth, double thickness, double youngs_modulus,
                           double poisson_ratio) {
  const Layer layer(ball, depth, thickness, poisson_ratio);
  double low = 0, high = std::sqrt(2 * ball * depth - depth * depth); // where the ball meets the plane
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (layer.density(middle).end > 0 ? low : high) = middle;
  }
  const Eigen::VectorXd density = layer.density(low).at;
  const double part = low / points;
  const Eigen::ArrayXd places = part * (Eigen::ArrayXd::LinSpaced(points, 0, points - 1) + 0.5);
  const double sum = density.sum() * part, moment = (density.array() * places.square()).sum() * part;
  // Of Hertz's pressure the mean square distance from the middle is two fifths of the contact's.
  return {pi * youngs_modulus / (1 - poisson_ratio * poisson_ratio) * sum, std::sqrt(2.5 * 2 * moment / sum)};
}

} // namespace maille::lab
