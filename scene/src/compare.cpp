#include "maille/scene/answer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille {

namespace {

/// Sums of squares without overflow: numbers are divided by a power of two, which is exact, so that the
/// largest is near one.
class Squares {
public:
  void add(double value) { largest_ = std::max(largest_, std::abs(value)); }
  void fix_scale() {
    int exponent = 0;
    if (largest_ > 0 && std::isfinite(largest_))
      std::frexp(largest_, &exponent);
    // 2^-exponent may overflow, its half does not.
    half_scale_ = std::ldexp(1.0, -(exponent / 2));
    rest_ = std::ldexp(1.0, -(exponent - exponent / 2));
  }
  double square(double value) const {
    const double scaled = value * half_scale_ * rest_;
    return scaled * scaled;
  }
  /// Root of a sum of scaled squares, unscaled.
  double root(double sum) const { return std::sqrt(sum) / half_scale_ / rest_; }

private:
  double largest_ = 0, half_scale_ = 1, rest_ = 1;
};

/// part / whole; 0 for 0 / 0, infinite for other parts over 0.
double ratio(double part, double whole) {
  if (part == 0)
    return 0;
  return whole > 0 ? part / whole : std::numeric_limits<double>::infinity();
}

} // namespace

ErrorNorms compare(const Scene& scene, const Displacement& answer, const Displacement& reference) {
  const Grid& grid = scene.specimen.grid;
  std::vector<bool> counted(grid.n_nodes(), true);
  for (const Prescribed& p : scene.prescribed)
    counted[p.node] = false;
  Squares differences, references;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const auto i = static_cast<std::size_t>(node);
    counted[i] = counted[i] && scene.specimen.is_node(grid.node_at(node));
    for (int b = 0; counted[i] && b < grid.dimension(); ++b) {
      differences.add(answer(b, node) - reference(b, node));
      references.add(reference(b, node));
    }
  }
  differences.fix_scale();
  references.fix_scale();

  double difference_sq = 0, reference_sq = 0, largest_difference_sq = 0, largest_reference_sq = 0;
  std::int64_t n = 0;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    if (!counted[node])
      continue;
    double d_sq = 0, r_sq = 0;
    for (int b = 0; b < grid.dimension(); ++b) {
      d_sq += differences.square(answer(b, node) - reference(b, node));
      r_sq += references.square(reference(b, node));
    }
    difference_sq += d_sq;
    reference_sq += r_sq;
    largest_difference_sq = std::max(largest_difference_sq, d_sq);
    largest_reference_sq = std::max(largest_reference_sq, r_sq);
    ++n;
  }
  if (n == 0)
    return {};
  return {.relative_l2 = ratio(differences.root(difference_sq), references.root(reference_sq)),
          .relative_max =
              ratio(differences.root(largest_difference_sq), references.root(largest_reference_sq)),
          .rms = differences.root(difference_sq / static_cast<double>(n))};
}

} // namespace maille
