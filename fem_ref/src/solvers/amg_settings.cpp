#include "solvers/amg_settings.hpp"

#include <algorithm>
#include <ml_MultiLevelPreconditioner.h>

namespace maille::fem_ref {

/// Rigid motions, which smoothed aggregation must reproduce on every level, one per column. Lengths are in
/// half extents of the body, so that translations and rotations have similar size.
std::vector<double> rigid_motions(const std::vector<Vec3>& positions, int dimension, const Box& around) {
  const auto d = static_cast<std::size_t>(dimension);
  const std::size_t n = positions.size() * d;
  const auto& [lower, upper] = around;
  double half = 0;
  for (std::size_t a = 0; a < 3; ++a)
    half = std::max(half, 0.5 * (upper[a] - lower[a]));
  std::vector<double> motions(n * (d * (d + 1) / 2), 0.0);
  for (std::size_t node = 0; node < positions.size(); ++node) {
    std::size_t column = 0;
    for (; column < d; ++column)
      motions[column * n + d * node + column] = 1;
    for (std::size_t a = 0; a < d; ++a)
      for (std::size_t b = a + 1; b < d; ++b, ++column) {
        const Vec3& x = positions[node];
        motions[column * n + d * node + a] = -(x[b] - 0.5 * (lower[b] + upper[b])) / half;
        motions[column * n + d * node + b] = (x[a] - 0.5 * (lower[a] + upper[a])) / half;
      }
  }
  return motions;
}

Box box_around(const std::vector<Vec3>& positions) {
  Box box{positions.front(), positions.front()};
  for (const Vec3& x : positions)
    for (std::size_t a = 0; a < 3; ++a) {
      box.lower[a] = std::min(box.lower[a], x[a]);
      box.upper[a] = std::max(box.upper[a], x[a]);
    }
  return box;
}

Teuchos::ParameterList amg_settings(int dimension, std::vector<double>& motions) {
  Teuchos::ParameterList list;
  ML_Epetra::SetDefaults("SA", list);
  list.set("ML output", 0);
  list.set("PDE equations", dimension);
  list.set("null space: type", "pre-computed");
  list.set("null space: dimension", dimension * (dimension + 1) / 2);
  list.set("null space: vectors", motions.data());
  list.set("null space: add default vectors", false);
  list.set("aggregation: type", "Uncoupled");
  list.set("aggregation: threshold", 0.0);
  list.set("smoother: type", "Chebyshev");
  list.set("smoother: sweeps", 2);
  list.set("coarse: type", "Amesos-KLU");
  return list;
}

} // namespace maille::fem_ref
