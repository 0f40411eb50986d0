#include "relax/separable_double.hpp"

#include "relax/separable_rows.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

template<class Row>
double residual_of_plane(const SeparableLevel& level, int z, const double* u, const double* f, double scale,
                         float* r) {
  const int nx = level.nodes()[0];
  double largest = 0;
  for (int y = 0; y < level.nodes()[1]; ++y) {
    const float* const inverse = level.A().inverse_diagonal[y + std::int64_t{1} * level.nodes()[1] * z];
    if (inverse == nullptr)
      continue;
    const Row w(level, y, z);
    const NeighbourRows n(level, y, z, u);
    const double* const forces =
        f == nullptr ? nullptr : f + nx * (y + std::int64_t{1} * level.nodes()[1] * z);
    float* const target = r + y * level.A().row_stride + z * level.A().slab_stride;
    const auto at = [&](int x, double before, double after) {
      const double here = n.row[x];
      double sum = forces == nullptr ? 0 : forces[x];
      sum += before + after;
      sum += w.y_below(x) * (n.ym[x] - here) + w.y_above(x) * (n.yp[x] - here);
      sum += w.z_below(x) * (n.zm[x] - here) + w.z_above(x) * (n.zp[x] - here);
      sum = inverse[x] > 0 ? sum : 0;
      largest = std::max(largest, std::abs(sum));
      target[x] = static_cast<float>(scale * sum);
    };
    const auto pull = [&](int x) { return w.x_link(x) * (n.row[x + 1] - n.row[x]); };
    if (nx == 1) {
      at(0, 0, 0);
      continue;
    }
    at(0, 0, pull(0));
    for (int x = 1; x + 1 < nx; ++x)
      at(x, -pull(x - 1), pull(x));
    at(nx - 1, -pull(nx - 2), 0);
  }
  return largest;
}

template<class Row>
double energy_of_rows(const SeparableLevel& level, int z, const double* u) {
  const int nx = level.nodes()[0];
  double sum = 0;
  for (int y = 0; y < level.nodes()[1]; ++y) {
    const Row w(level, y, z);
    const NeighbourRows n(level, y, z, u);
    for (int x = 0; x < nx; ++x) {
      const double along_y = n.yp[x] - n.row[x], along_z = n.zp[x] - n.row[x];
      sum += w.y_above(x) * along_y * along_y + w.z_above(x) * along_z * along_z;
    }
    for (int x = 0; x + 1 < nx; ++x) {
      const double along_x = n.row[x + 1] - n.row[x];
      sum += w.x_link(x) * along_x * along_x;
    }
  }
  return 0.5 * sum;
}

} // namespace

double find_true_residual(const SeparableLevel& level, int z, const double* u, const double* f, double scale,
                          float* r) {
  return level.weights().is_box() ? residual_of_plane<DoubleBoxRow>(level, z, u, f, scale, r)
                                  : residual_of_plane<DoubleLinkRow>(level, z, u, f, scale, r);
}

double energy_of_plane(const SeparableLevel& level, int z, const double* u) {
  return level.weights().is_box() ? energy_of_rows<DoubleBoxRow>(level, z, u)
                                  : energy_of_rows<DoubleLinkRow>(level, z, u);
}

double force_on(const SeparableLevel& level, const Index3& at, const double* u) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      Index3 near = at, other = at;
      other[static_cast<std::size_t>(axis)] += side;
      if (side < 0)
        near = other;
      const double weight = level.weight(near, axis);
      if (weight > 0)
        sum += weight * (u[level.node(at)] - u[level.node(other)]);
    }
  return sum;
}

} // namespace maille::deform
