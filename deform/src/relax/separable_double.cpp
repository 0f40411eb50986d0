#include "relax/separable_double.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Weights of the links from one row of a box to its surroundings.
class BoxRow {
public:
  BoxRow(const SeparableLevel& level, int y, int z)
      : x_link_(level.weights().axis_link[0].data()), x_mass_(level.weights().axis_mass[0].data()) {
    const LinkWeights& w = level.weights();
    const auto link = [&](std::size_t axis, int i) {
      return i >= 0 && i + 1 < level.nodes()[axis] ? w.axis_link[axis][static_cast<std::size_t>(i)] : 0.0;
    };
    const double y_mass = w.axis_mass[1][static_cast<std::size_t>(y)];
    const double z_mass = w.axis_mass[2][static_cast<std::size_t>(z)];
    along_x_ = y_mass * z_mass;
    y_below_ = link(1, y - 1) * z_mass;
    y_above_ = link(1, y) * z_mass;
    z_below_ = link(2, z - 1) * y_mass;
    z_above_ = link(2, z) * y_mass;
  }
  double x_link(int x) const { return along_x_ * x_link_[x]; }
  double y_below(int x) const { return y_below_ * x_mass_[x]; }
  double y_above(int x) const { return y_above_ * x_mass_[x]; }
  double z_below(int x) const { return z_below_ * x_mass_[x]; }
  double z_above(int x) const { return z_above_ * x_mass_[x]; }

private:
  const double *x_link_, *x_mass_;
  double along_x_, y_below_, y_above_, z_below_, z_above_;
};

class LinkRow {
public:
  LinkRow(const SeparableLevel& level, int y, int z) {
    const SeparableOperator& A = level.A();
    const std::int64_t at = y * A.row_stride + z * A.slab_stride;
    x_link_ = A.link[0] + at;
    y_above_ = A.link[1] + at;
    z_above_ = A.link[2] + at;
    y_below_ = y > 0 ? y_above_ - A.row_stride : y_above_ + (A.nodes[1] - 1) * A.row_stride;
    z_below_ = z > 0 ? z_above_ - A.slab_stride : z_above_ + (A.nodes[2] - 1) * A.slab_stride;
  }
  double x_link(int x) const { return double{x_link_[x]}; }
  double y_below(int x) const { return double{y_below_[x]}; }
  double y_above(int x) const { return double{y_above_[x]}; }
  double z_below(int x) const { return double{z_below_[x]}; }
  double z_above(int x) const { return double{z_above_[x]}; }

private:
  const float *x_link_, *y_below_, *y_above_, *z_below_, *z_above_;
};

struct Neighbours {
  const double *row, *ym, *yp, *zm, *zp;

  Neighbours(const SeparableLevel& level, int y, int z, const double* u) {
    const std::int64_t step_y = level.nodes()[0], step_z = step_y * level.nodes()[1];
    row = u + y * step_y + z * step_z;
    ym = y > 0 ? row - step_y : row;
    yp = y + 1 < level.nodes()[1] ? row + step_y : row;
    zm = z > 0 ? row - step_z : row;
    zp = z + 1 < level.nodes()[2] ? row + step_z : row;
  }
};

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
    const Neighbours n(level, y, z, u);
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
    const Neighbours n(level, y, z, u);
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
  return level.weights().is_box() ? residual_of_plane<BoxRow>(level, z, u, f, scale, r)
                                  : residual_of_plane<LinkRow>(level, z, u, f, scale, r);
}

double energy_of_plane(const SeparableLevel& level, int z, const double* u) {
  return level.weights().is_box() ? energy_of_rows<BoxRow>(level, z, u) : energy_of_rows<LinkRow>(level, z, u);
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
