#include "relax/matter_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "relax/matter_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see propagate/cone_kernel.cpp for what that forbids. Every cell and node is computed by the same
// operations in vectors of any length, and sums have 16 parts; so bits depend on whether the machine fuses products with sums, but
// neither on the length of its vectors nor on the number of threads.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, MatterRows::block>;
using VF = hn::VFromD<F>;
using MF = decltype(hn::Gt(hn::Zero(F()), hn::Zero(F())));

/// Rows of scratch: six stresses, three sums of twists, pulls of the edges along x in the four rows of nodes, stiffnesses of the edges
/// along y and along z.
constexpr int n_rows = 15, twist_row = 6, pull_row = 9, y_edge_row = 13, z_edge_row = 14;

/// Coefficients of neighbouring cells: of their own, of one kind of matter, of several kinds.
struct OwnCoefficients {
  const float* first;
  HWY_INLINE VF operator[](int k) const { return hn::LoadU(F(), first + k * MatterRows::block); }
};
struct OneKind {
  const float* table;
  std::int32_t n_kinds;
  MF is_matter;
  HWY_INLINE VF operator[](int k) const {
    return hn::IfThenElseZero(is_matter, hn::Set(F(), table[std::int64_t{k} * n_kinds]));
  }
};
struct SeveralKinds {
  const float* table;
  std::int32_t n_kinds;
  hn::VFromD<hn::RebindToSigned<F>> kinds;
  HWY_INLINE VF operator[](int k) const {
    return hn::GatherIndex(F(), table + std::int64_t{k} * n_kinds, kinds);
  }
};

/// Sums and differences over the eight corners of the cells from x on, of one component.
struct Corners {
  VF along_x, along_y, along_z, yz, xz, xy;
  VF edge_x[4];
  HWY_INLINE Corners(const float* const* rows, int x) {
    const F d;
    VF sum[4];
    for (int r = 0; r < 4; ++r) {
      const VF lower = hn::LoadU(d, rows[r] + x), upper = hn::LoadU(d, rows[r] + x + 1);
      edge_x[r] = hn::Sub(upper, lower);
      sum[r] = hn::Add(lower, upper);
    }
    const VF low = hn::Add(edge_x[0], edge_x[1]), high = hn::Add(edge_x[2], edge_x[3]);
    along_x = hn::Add(low, high);
    xz = hn::Sub(high, low);
    xy = hn::Add(hn::Sub(edge_x[1], edge_x[0]), hn::Sub(edge_x[3], edge_x[2]));
    const VF y_low = hn::Sub(sum[1], sum[0]), y_high = hn::Sub(sum[3], sum[2]);
    along_y = hn::Add(y_low, y_high);
    yz = hn::Sub(y_high, y_low);
    along_z = hn::Add(hn::Sub(sum[2], sum[0]), hn::Sub(sum[3], sum[1]));
  }
};

/// Row p of a product with the mean stiffness.
template<int p, class C>
HWY_INLINE VF whole_stress(const C& c, const VF* strain) {
  const auto times = [&](int q) HWY_ATTR { return hn::Mul(c[mean_coefficient(p, q)], strain[q]); };
  const VF normal = hn::MulAdd(c[mean_coefficient(p, 2)], strain[2],
                               hn::MulAdd(c[mean_coefficient(p, 1)], strain[1], times(0)));
  return hn::Add(normal, hn::MulAdd(c[mean_coefficient(p, 5)], strain[5],
                                    hn::MulAdd(c[mean_coefficient(p, 4)], strain[4], times(3))));
}
/// The same where normal strains and shears are not coupled.
template<int p, class C>
HWY_INLINE VF normal_stress(const C& c, const VF* strain) {
  return hn::MulAdd(
      c[mean_coefficient(p, 2)], strain[2],
      hn::MulAdd(c[mean_coefficient(p, 1)], strain[1], hn::Mul(c[mean_coefficient(p, 0)], strain[0])));
}

template<bool couples_all, class C>
HWY_INLINE void store_stresses(const C& c, const VF* strain, float* rows, std::int64_t stride) {
  const auto put = [&](int p, VF stress) HWY_ATTR { hn::StoreU(stress, F(), rows + p * stride); };
  if constexpr (couples_all) {
    put(0, whole_stress<0>(c, strain));
    put(1, whole_stress<1>(c, strain));
    put(2, whole_stress<2>(c, strain));
    put(3, whole_stress<3>(c, strain));
    put(4, whole_stress<4>(c, strain));
    put(5, whole_stress<5>(c, strain));
  } else {
    put(0, normal_stress<0>(c, strain));
    put(1, normal_stress<1>(c, strain));
    put(2, normal_stress<2>(c, strain));
    put(3, hn::Mul(c[mean_coefficient(3, 3)], strain[3]));
    put(4, hn::Mul(c[mean_coefficient(4, 4)], strain[4]));
    put(5, hn::Mul(c[mean_coefficient(5, 5)], strain[5]));
  }
}

/// What pulls in the cells from x on, into scratch.
template<bool couples_all, class C>
HWY_INLINE void store_pulls(const C& c, const float* const (*u)[4], int x, float* rows, std::int64_t stride) {
  const F d;
  const Corners of_x(u[0], x), of_y(u[1], x), of_z(u[2], x);
  const VF strain[6] = {of_x.along_x,
                        of_y.along_y,
                        of_z.along_z,
                        hn::Add(of_y.along_z, of_z.along_y),
                        hn::Add(of_x.along_z, of_z.along_x),
                        hn::Add(of_x.along_y, of_y.along_x)};
  store_stresses<couples_all>(c, strain, rows, stride);
  const VF about_x = hn::Mul(c[MatterOperator::twist], hn::Add(of_y.xz, of_z.xy)),
           about_y = hn::Mul(c[MatterOperator::twist + 1], hn::Add(of_x.yz, of_z.xy)),
           about_z = hn::Mul(c[MatterOperator::twist + 2], hn::Add(of_x.yz, of_y.xz));
  hn::StoreU(hn::Add(about_y, about_z), d, rows + twist_row * stride);
  hn::StoreU(hn::Add(about_x, about_z), d, rows + (twist_row + 1) * stride);
  hn::StoreU(hn::Add(about_x, about_y), d, rows + (twist_row + 2) * stride);
  const VF edge = c[MatterOperator::edge];
  for (int r = 0; r < 4; ++r)
    hn::StoreU(hn::Mul(edge, of_x.edge_x[r]), d, rows + (pull_row + r) * stride);
  hn::StoreU(c[MatterOperator::edge + 1], d, rows + y_edge_row * stride);
  hn::StoreU(c[MatterOperator::edge + 2], d, rows + z_edge_row * stride);
}

template<bool couples_all>
HWY_INLINE void find_pulls(const MatterOperator& A, const CellRun& run, const float* const (*u)[4],
                           float* rows, std::int64_t stride) {
  const F d;
  const hn::RebindToSigned<F> integer;
  constexpr int block = MatterRows::block;
  const int lanes = static_cast<int>(hn::Lanes(d)), n = run.blocks * block;
  for (int x = 0; x < n; x += lanes) {
    if (A.kind == nullptr) {
      const std::int64_t first =
          std::int64_t{run.cell_slot + x} / block * block * MatterOperator::n_coefficients + x % block;
      store_pulls<couples_all>(OwnCoefficients{A.coefficients + first}, u, x, rows + x, stride);
      continue;
    }
    const auto kinds = hn::LoadU(integer, A.kind + run.cell_slot + x);
    const std::int32_t kind = A.block_kind[(run.cell_slot + x) / block];
    const auto is_matter = hn::RebindMask(d, hn::Gt(kinds, hn::Zero(integer)));
    if (kind > 0)
      store_pulls<couples_all>(OneKind{A.coefficients + kind, A.n_kinds, is_matter}, u, x, rows + x, stride);
    else
      store_pulls<couples_all>(SeveralKinds{A.coefficients, A.n_kinds, kinds}, u, x, rows + x, stride);
  }
  for (int k = 0; k < n_rows; ++k) { // nothing pulls beyond the ends
    rows[k * stride - 1] = 0;
    for (int x = n; x < run.node_blocks * block; x += lanes)
      hn::StoreU(hn::Zero(d), d, rows + k * stride + x);
  }
}

/// Sum, and difference, of what the cells before and after nodes x have in a row of scratch.
HWY_INLINE VF both(const float* row, int x) {
  return hn::Add(hn::LoadU(F(), row + x - 1), hn::LoadU(F(), row + x));
}
HWY_INLINE VF net(const float* row, int x) {
  return hn::Sub(hn::LoadU(F(), row + x - 1), hn::LoadU(F(), row + x));
}
HWY_INLINE void add_to(float* at, VF value) {
  hn::StoreU(hn::Add(hn::LoadU(F(), at), value), F(), at);
}
/// Adds even + (+-) odd_y + (+-) odd_z + (+-)(+-) odd_yz, less the pull of edges, to the four rows.
HWY_INLINE void add_to_rows(float* const* rows, int x, VF even, VF odd_y, VF odd_z, VF odd_yz,
                            const VF* extra) {
  const VF low = hn::Sub(even, odd_z), high = hn::Add(even, odd_z), y_low = hn::Sub(odd_y, odd_yz),
           y_high = hn::Add(odd_y, odd_yz);
  add_to(rows[0] + x, hn::Add(hn::Sub(low, y_low), extra[0]));
  add_to(rows[1] + x, hn::Add(hn::Add(low, y_low), extra[1]));
  add_to(rows[2] + x, hn::Add(hn::Sub(high, y_high), extra[2]));
  add_to(rows[3] + x, hn::Add(hn::Add(high, y_high), extra[3]));
}

HWY_INLINE void add_pulls(const CellRun& run, const float* const (*u)[4], float* const (*forces)[4],
                          const float* rows, std::int64_t stride) {
  const F d;
  const int lanes = static_cast<int>(hn::Lanes(d)), n = run.node_blocks * MatterRows::block;
  const auto row = [&](int k) HWY_ATTR { return rows + k * stride; };
  for (int x = 0; x < n; x += lanes) {
    const VF along_x[4] = {net(row(pull_row), x), net(row(pull_row + 1), x), net(row(pull_row + 2), x),
                           net(row(pull_row + 3), x)};
    add_to_rows(forces[0], x, net(row(0), x), both(row(5), x), both(row(4), x), both(row(twist_row), x),
                along_x);
    const VF y_edge = both(row(y_edge_row), x), z_edge = both(row(z_edge_row), x);
    const auto pull = [&](VF edge, const float* lower, const float* upper) HWY_ATTR {
      return hn::Mul(edge, hn::Sub(hn::LoadU(d, upper + x), hn::LoadU(d, lower + x)));
    };
    const VF y0 = pull(y_edge, u[1][0], u[1][1]), y1 = pull(y_edge, u[1][2], u[1][3]);
    const VF along_y[4] = {hn::Neg(y0), y0, hn::Neg(y1), y1};
    add_to_rows(forces[1], x, net(row(5), x), both(row(1), x),
                hn::Add(both(row(3), x), net(row(twist_row + 1), x)), hn::Zero(d), along_y);
    const VF z0 = pull(z_edge, u[2][0], u[2][2]), z1 = pull(z_edge, u[2][1], u[2][3]);
    const VF along_z[4] = {hn::Neg(z0), hn::Neg(z1), z0, z1};
    add_to_rows(forces[2], x, net(row(4), x), hn::Add(both(row(3), x), net(row(twist_row + 2), x)),
                both(row(2), x), hn::Zero(d), along_z);
  }
}

void add_forces(const MatterOperator& A, const CellRun& run, const float* u, float* forces, float* scratch) {
  const std::int64_t stride = (run.node_blocks + 2) * MatterRows::block;
  float* const rows = scratch + MatterRows::block;
  const float* of_u[3][4];
  float* of_forces[3][4];
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 4; ++r) {
      of_u[c][r] = u + c * A.component_stride + run.node_slot[r];
      of_forces[c][r] = forces + c * A.component_stride + run.node_slot[r];
    }
  if (A.couples_all)
    find_pulls<true>(A, run, of_u, rows, stride);
  else
    find_pulls<false>(A, run, of_u, rows, stride);
  add_pulls(run, of_u, of_forces, rows, stride);
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(add_forces);

std::int64_t matter_scratch_floats(int longest_run) {
  return std::int64_t{16} * (longest_run + 3) * MatterRows::block;
}
void add_matter_forces(const MatterOperator& A, const CellRun& run, const float* u, float* forces,
                       float* scratch) {
  HWY_DYNAMIC_DISPATCH(add_forces)(A, run, u, forces, scratch);
}
} // namespace maille::deform
#endif
