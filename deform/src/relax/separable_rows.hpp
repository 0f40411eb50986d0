#pragma once
/// Rows of a level in float64: weights of the links around a row, and the rows of a dense field around it.

#include "relax/separable_level.hpp"

namespace maille::deform {

/// Weights of the links from one row of a box to its surroundings.
class DoubleBoxRow {
public:
  DoubleBoxRow(const SeparableLevel& level, int y, int z)
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

/// The same of any other body.
class DoubleLinkRow {
public:
  DoubleLinkRow(const SeparableLevel& level, int y, int z) {
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

/// Where there is no neighbour, the row itself: the weight is 0 there.
struct NeighbourRows {
  const double *row, *ym, *yp, *zm, *zp;

  NeighbourRows(const SeparableLevel& level, int y, int z, const double* u) {
    const std::int64_t step_y = level.nodes()[0], step_z = step_y * level.nodes()[1];
    row = u + y * step_y + z * step_z;
    ym = y > 0 ? row - step_y : row;
    yp = y + 1 < level.nodes()[1] ? row + step_y : row;
    zm = z > 0 ? row - step_z : row;
    zp = z + 1 < level.nodes()[2] ? row + step_z : row;
  }
};

} // namespace maille::deform
