#pragma once
/// Rows of a level in float64: weights of the links around a row, and the rows of a dense field around it.

#include "elastic/componentwise/componentwise_level.hpp"

namespace maille::deform {

/// Weights of the links from one row of a box to its surroundings: factors that the row's nodes share, times
/// one number a node.
struct DoubleBoxRow {
  const double *along, *mass; ///< per node of the row
  double factor_along, factor_y_below, factor_y_above, factor_z_below, factor_z_above;

  DoubleBoxRow(const ComponentwiseLevel& level, int y, int z)
      : along(level.weights().axis_link[0].data()), mass(level.weights().axis_mass[0].data()) {
    const LinkWeights& w = level.weights();
    const auto link = [&](std::size_t axis, int i) {
      return i >= 0 && i + 1 < level.nodes()[axis] ? w.axis_link[axis][i] : 0.0;
    };
    const double y_mass = w.axis_mass[1][y];
    const double z_mass = w.axis_mass[2][z];
    factor_along = y_mass * z_mass;
    factor_y_below = link(1, y - 1) * z_mass;
    factor_y_above = link(1, y) * z_mass;
    factor_z_below = link(2, z - 1) * y_mass;
    factor_z_above = link(2, z) * y_mass;
  }
  double x_link(int x) const { return factor_along * along[x]; }
  double y_below(int x) const { return factor_y_below * mass[x]; }
  double y_above(int x) const { return factor_y_above * mass[x]; }
  double z_below(int x) const { return factor_z_below * mass[x]; }
  double z_above(int x) const { return factor_z_above * mass[x]; }
};

/// The same of any other body: a number per link.
struct DoubleLinkRow {
  const float *along, *below_y, *above_y, *below_z, *above_z;

  DoubleLinkRow(const ComponentwiseLevel& level, int y, int z) {
    const ComponentwiseOperator& A = level.A();
    const std::int64_t at = y * A.row_stride + z * A.slab_stride;
    along = A.link[0] + at;
    above_y = A.link[1] + at;
    above_z = A.link[2] + at;
    below_y = y > 0 ? above_y - A.row_stride : above_y + (A.nodes[1] - 1) * A.row_stride;
    below_z = z > 0 ? above_z - A.slab_stride : above_z + (A.nodes[2] - 1) * A.slab_stride;
  }
  double x_link(int x) const { return double{along[x]}; }
  double y_below(int x) const { return double{below_y[x]}; }
  double y_above(int x) const { return double{above_y[x]}; }
  double z_below(int x) const { return double{below_z[x]}; }
  double z_above(int x) const { return double{above_z[x]}; }
};

/// Where there is no neighbour, the row itself: the weight is 0 there.
struct NeighbourRows {
  const double *row, *ym, *yp, *zm, *zp;

  NeighbourRows(const ComponentwiseLevel& level, int y, int z, const double* u) {
    const std::int64_t step_y = level.nodes()[0], step_z = step_y * level.nodes()[1];
    row = u + y * step_y + z * step_z;
    ym = y > 0 ? row - step_y : row;
    yp = y + 1 < level.nodes()[1] ? row + step_y : row;
    zm = z > 0 ? row - step_z : row;
    zp = z + 1 < level.nodes()[2] ? row + step_z : row;
  }
};

} // namespace maille::deform
