#include "elastic/componentwise/componentwise_kernel.hpp"
#include "elastic/componentwise/componentwise_level.hpp"
#include "elastic/componentwise/componentwise_rows.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/componentwise/componentwise_double.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Rows begin
// anywhere, so vectors are loaded unaligned; what does not fill one is done node by node.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::VFromD<D>;

/// A vector of the weights of a row.
struct BoxVectors {
  const DoubleBoxRow& w;
  HWY_INLINE V of(double factor, const double* per_node) const {
    return hn::Mul(hn::Set(D(), factor), hn::LoadU(D(), per_node));
  }
  HWY_INLINE V x_link(int x) const { return of(w.factor_along, w.along + x); }
  HWY_INLINE V y_below(int x) const { return of(w.factor_y_below, w.mass + x); }
  HWY_INLINE V y_above(int x) const { return of(w.factor_y_above, w.mass + x); }
  HWY_INLINE V z_below(int x) const { return of(w.factor_z_below, w.mass + x); }
  HWY_INLINE V z_above(int x) const { return of(w.factor_z_above, w.mass + x); }
};

struct LinkVectors {
  const DoubleLinkRow& w;
  HWY_INLINE V of(const float* links) const {
    return hn::PromoteTo(D(), hn::LoadU(hn::Rebind<float, D>(), links));
  }
  HWY_INLINE V x_link(int x) const { return of(w.along + x); }
  HWY_INLINE V y_below(int x) const { return of(w.below_y + x); }
  HWY_INLINE V y_above(int x) const { return of(w.above_y + x); }
  HWY_INLINE V z_below(int x) const { return of(w.below_z + x); }
  HWY_INLINE V z_above(int x) const { return of(w.above_z + x); }
};

HWY_INLINE V difference(const double* to, const double* from, int x) {
  return hn::Sub(hn::LoadU(D(), to + x), hn::LoadU(D(), from + x));
}

/// Adds the link forces on a node of a row to `sum`.
template<class Row>
double pulled(const Row& w, const NeighbourRows& n, int x, int nx, double sum) {
  const double here = n.row[x];
  if (x > 0)
    sum += w.x_link(x - 1) * (n.row[x - 1] - here);
  if (x + 1 < nx)
    sum += w.x_link(x) * (n.row[x + 1] - here);
  sum += w.y_below(x) * (n.ym[x] - here) + w.y_above(x) * (n.yp[x] - here);
  sum += w.z_below(x) * (n.zm[x] - here) + w.z_above(x) * (n.zp[x] - here);
  return sum;
}

/// The same for a vector of nodes, none of them at an end of the row.
template<class Vectors>
HWY_INLINE V pulled(const Vectors& w, const NeighbourRows& n, int x, V sum) {
  sum = hn::MulAdd(w.x_link(x - 1), difference(n.row - 1, n.row, x), sum);
  sum = hn::MulAdd(w.x_link(x), difference(n.row + 1, n.row, x), sum);
  sum = hn::MulAdd(w.y_below(x), difference(n.ym, n.row, x), sum);
  sum = hn::MulAdd(w.y_above(x), difference(n.yp, n.row, x), sum);
  sum = hn::MulAdd(w.z_below(x), difference(n.zm, n.row, x), sum);
  return hn::MulAdd(w.z_above(x), difference(n.zp, n.row, x), sum);
}

template<class Row, class Vectors>
double residual_of_rows(const ComponentwiseLevel& level, int z, const double* u, const double* f,
                        double scale, float* r) {
  const D d;
  const hn::Rebind<float, D> d_float;
  const int nx = level.nodes()[0], lanes = static_cast<int>(hn::Lanes(d));
  double largest = 0;
  V largest_of_lanes = hn::Zero(d);
  for (int y = 0; y < level.nodes()[1]; ++y) {
    const float* const inverse = level.A().inverse_diagonal[y + std::int64_t{1} * level.nodes()[1] * z];
    if (inverse == nullptr)
      continue;
    const Row w(level, y, z);
    const Vectors vectors{w};
    const NeighbourRows n(level, y, z, u);
    const double* const forces =
        f == nullptr ? nullptr : f + nx * (y + std::int64_t{1} * level.nodes()[1] * z);
    float* const target = r + y * level.A().row_stride + z * level.A().slab_stride;
    const auto one = [&](int x) {
      const double sum = inverse[x] > 0 ? pulled(w, n, x, nx, forces == nullptr ? 0 : forces[x]) : 0;
      largest = std::max(largest, std::abs(sum));
      target[x] = static_cast<float>(scale * sum);
    };
    one(0);
    int x = 1;
    for (; x + lanes < nx; x += lanes) {
      const V sum = pulled(vectors, n, x, forces == nullptr ? hn::Zero(d) : hn::LoadU(d, forces + x));
      const V may_move = hn::PromoteTo(d, hn::LoadU(d_float, inverse + x));
      const V residual = hn::IfThenElseZero(hn::Gt(may_move, hn::Zero(d)), sum);
      largest_of_lanes = hn::Max(largest_of_lanes, hn::Abs(residual));
      hn::StoreU(hn::DemoteTo(d_float, hn::Mul(hn::Set(d, scale), residual)), d_float, target + x);
    }
    for (; x < nx; ++x)
      one(x);
  }
  return std::max(largest, hn::GetLane(hn::MaxOfLanes(d, largest_of_lanes)));
}

template<class Row, class Vectors>
void forces_of_rows(const ComponentwiseLevel& level, int z, const double* u, double scale, double* forces) {
  const D d;
  const int nx = level.nodes()[0], lanes = static_cast<int>(hn::Lanes(d));
  for (int y = 0; y < level.nodes()[1]; ++y) {
    const Row w(level, y, z);
    const Vectors vectors{w};
    const NeighbourRows n(level, y, z, u);
    double* const target = forces + level.node({0, y, z});
    target[0] = -scale * pulled(w, n, 0, nx, 0);
    int x = 1;
    for (; x + lanes < nx; x += lanes)
      hn::StoreU(hn::Mul(hn::Set(d, -scale), pulled(vectors, n, x, hn::Zero(d))), d, target + x);
    for (; x < nx; ++x)
      target[x] = -scale * pulled(w, n, x, nx, 0);
  }
}

template<class Row, class Vectors>
double energy_of_rows(const ComponentwiseLevel& level, int z, const double* u) {
  const D d;
  const int nx = level.nodes()[0], lanes = static_cast<int>(hn::Lanes(d));
  double sum = 0;
  const auto add = [](V weight, V change, V to)
                       HWY_ATTR { return hn::MulAdd(weight, hn::Mul(change, change), to); };
  for (int y = 0; y < level.nodes()[1]; ++y) {
    const Row w(level, y, z);
    const Vectors vectors{w};
    const NeighbourRows n(level, y, z, u);
    V of_row = hn::Zero(d);
    int x = 0;
    for (; x + lanes < nx; x += lanes) {
      of_row = add(vectors.y_above(x), difference(n.yp, n.row, x), of_row);
      of_row = add(vectors.z_above(x), difference(n.zp, n.row, x), of_row);
      of_row = add(vectors.x_link(x), difference(n.row + 1, n.row, x), of_row);
    }
    sum += hn::GetLane(hn::SumOfLanes(d, of_row));
    for (; x < nx; ++x) {
      const double along_x = x + 1 < nx ? n.row[x + 1] - n.row[x] : 0, along_y = n.yp[x] - n.row[x],
                   along_z = n.zp[x] - n.row[x];
      sum += (x + 1 < nx ? w.x_link(x) : 0) * along_x * along_x + w.y_above(x) * along_y * along_y +
             w.z_above(x) * along_z * along_z;
    }
  }
  return 0.5 * sum;
}

double residual(const ComponentwiseLevel& level, int z, const double* u, const double* f, double scale,
                float* r) {
  return level.weights().is_box() ? residual_of_rows<DoubleBoxRow, BoxVectors>(level, z, u, f, scale, r)
                                  : residual_of_rows<DoubleLinkRow, LinkVectors>(level, z, u, f, scale, r);
}

void forces(const ComponentwiseLevel& level, int z, const double* u, double scale, double* f) {
  if (level.weights().is_box())
    forces_of_rows<DoubleBoxRow, BoxVectors>(level, z, u, scale, f);
  else
    forces_of_rows<DoubleLinkRow, LinkVectors>(level, z, u, scale, f);
}

double energy(const ComponentwiseLevel& level, int z, const double* u) {
  return level.weights().is_box() ? energy_of_rows<DoubleBoxRow, BoxVectors>(level, z, u)
                                  : energy_of_rows<DoubleLinkRow, LinkVectors>(level, z, u);
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(residual);
HWY_EXPORT(forces);
HWY_EXPORT(energy);

double find_true_residual(const ComponentwiseLevel& level, int z, const double* u, const double* f,
                          double scale, float* r) {
  return HWY_DYNAMIC_DISPATCH(residual)(level, z, u, f, scale, r);
}

void find_forces(const ComponentwiseLevel& level, int z, const double* u, double scale, double* f) {
  HWY_DYNAMIC_DISPATCH(forces)(level, z, u, scale, f);
}

double energy_of_plane(const ComponentwiseLevel& level, int z, const double* u) {
  return HWY_DYNAMIC_DISPATCH(energy)(level, z, u);
}

double force_on(const ComponentwiseLevel& level, const Index3& at, const double* u) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      Index3 near = at, other = at;
      other[axis] += side;
      if (side < 0)
        near = other;
      const double weight = level.weight(near, axis);
      if (weight > 0)
        sum += weight * (u[level.node(at)] - u[level.node(other)]);
    }
  return sum;
}

} // namespace maille::deform
#endif
