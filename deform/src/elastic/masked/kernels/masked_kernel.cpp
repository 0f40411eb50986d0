#include "elastic/masked/masked_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/masked/kernels/masked_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Every cell and
// node is computed by the same operations in vectors of any length, and sums have 16 parts; so bits depend on
// whether the machine fuses products with sums, but neither on the length of its vectors nor on the number of
// threads.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, MaskedRows::block>;
using VF = hn::VFromD<F>;
using MF = decltype(hn::Gt(hn::Zero(F()), hn::Zero(F())));

/// Sources of coefficients of adjacent cells: their own, those of one kind, those of several kinds.
struct OwnCoefficients {
  const float* first;
  HWY_INLINE VF operator[](int k) const { return hn::LoadU(F(), first + k * MaskedRows::block); }
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

/// The four rows of nodes of a run, in one component of a field.
struct Rows {
  std::int64_t slot[4];
  explicit HWY_INLINE Rows(const CellRun& run)
      : slot{run.node_slot[0], run.node_slot[1], run.node_slot[2], run.node_slot[3]} {}
};

/// Sums and differences over the eight corners of the cells from x on, of one component.
struct Corners {
  VF along_x, along_y, along_z, yz, xz, xy;
  VF edge_x[4];
  HWY_INLINE Corners(const float* u, const Rows& rows, int x) {
    const F d;
    VF sum[4];
    for (int r = 0; r < 4; ++r) {
      const VF lower = hn::LoadU(d, u + rows.slot[r] + x), upper = hn::LoadU(d, u + rows.slot[r] + x + 1);
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

/// Stresses of adjacent cells: mean stresses, sums of twists, edge forces along x in the four rows of nodes,
/// and edge stiffnesses along y and z.
struct Pulls {
  VF stress[6], twist[3], along_x[4], y_edge, z_edge;
  VF bend[6]; ///< of thin cells, by component and the axis across: x y, x z, y x, y z, z x, z y

  HWY_INLINE Pulls() : Pulls(hn::Zero(F())) {}
  explicit HWY_INLINE Pulls(VF all)
      : stress{all, all, all, all, all, all}, twist{all, all, all}, along_x{all, all, all, all}, y_edge(all),
        z_edge(all), bend{all, all, all, all, all, all} {}
};

/// Bending stresses across an axis, from the differences of the two faces: along the next axis, along the one
/// after it, and in shear.
template<class C>
HWY_INLINE void bend(const C& c, int across, VF first, VF second, VF shear, VF& of_first, VF& of_second,
                     VF& of_shear) {
  const int at = MaskedOperator::bending + 6 * across;
  const VF mixed = c[at + 1], first_shear = c[at + 2], second_shear = c[at + 4];
  of_first = hn::MulAdd(c[at], first, hn::MulAdd(mixed, second, hn::Mul(first_shear, shear)));
  of_second = hn::MulAdd(mixed, first, hn::MulAdd(c[at + 3], second, hn::Mul(second_shear, shear)));
  of_shear = hn::MulAdd(first_shear, first, hn::MulAdd(second_shear, second, hn::Mul(c[at + 5], shear)));
}

template<bool couples_all, class C>
HWY_INLINE void set_stresses(const C& c, const VF* strain, VF* stress) {
  if constexpr (couples_all) {
    stress[0] = whole_stress<0>(c, strain);
    stress[1] = whole_stress<1>(c, strain);
    stress[2] = whole_stress<2>(c, strain);
    stress[3] = whole_stress<3>(c, strain);
    stress[4] = whole_stress<4>(c, strain);
    stress[5] = whole_stress<5>(c, strain);
  } else {
    stress[0] = normal_stress<0>(c, strain);
    stress[1] = normal_stress<1>(c, strain);
    stress[2] = normal_stress<2>(c, strain);
    stress[3] = hn::Mul(c[mean_coefficient(3, 3)], strain[3]);
    stress[4] = hn::Mul(c[mean_coefficient(4, 4)], strain[4]);
    stress[5] = hn::Mul(c[mean_coefficient(5, 5)], strain[5]);
  }
}

/// Stresses of the cells from x on.
template<bool couples_all, bool bends, class C>
HWY_INLINE void find_pulls(const C& c, const float* const* u, const Rows& at, int x, Pulls& pulls) {
  const Corners of_x(u[0], at, x), of_y(u[1], at, x), of_z(u[2], at, x);
  const VF strain[6] = {of_x.along_x,
                        of_y.along_y,
                        of_z.along_z,
                        hn::Add(of_y.along_z, of_z.along_y),
                        hn::Add(of_x.along_z, of_z.along_x),
                        hn::Add(of_x.along_y, of_y.along_x)};
  set_stresses<couples_all>(c, strain, pulls.stress);
  const VF twist_x = hn::Add(of_y.xz, of_z.xy), twist_y = hn::Add(of_x.yz, of_z.xy),
           twist_z = hn::Add(of_x.yz, of_y.xz);
  VF about_x = hn::Mul(c[MaskedOperator::twist], twist_x),
     about_y = hn::Mul(c[MaskedOperator::twist + 1], twist_y),
     about_z = hn::Mul(c[MaskedOperator::twist + 2], twist_z);
  if constexpr (bends) {
    VF more_x, more_y, more_z;
    bend(c, 0, of_y.xy, of_z.xz, twist_x, pulls.bend[2], pulls.bend[4], more_x);
    bend(c, 1, of_z.yz, of_x.xy, twist_y, pulls.bend[5], pulls.bend[0], more_y);
    bend(c, 2, of_x.xz, of_y.yz, twist_z, pulls.bend[1], pulls.bend[3], more_z);
    about_x = hn::Add(about_x, more_x);
    about_y = hn::Add(about_y, more_y);
    about_z = hn::Add(about_z, more_z);
  }
  pulls.twist[0] = hn::Add(about_y, about_z);
  pulls.twist[1] = hn::Add(about_x, about_z);
  pulls.twist[2] = hn::Add(about_x, about_y);
  const VF edge = c[MaskedOperator::edge];
  for (int r = 0; r < 4; ++r)
    pulls.along_x[r] = hn::Mul(edge, of_x.edge_x[r]);
  pulls.y_edge = c[MaskedOperator::edge + 1];
  pulls.z_edge = c[MaskedOperator::edge + 2];
}

template<bool couples_all, bool bends>
HWY_INLINE void find_pulls_of_run(const MaskedOperator& A, const CellRun& run, const float* const* u, int x,
                                  Pulls& pulls) {
  constexpr int block = MaskedRows::block;
  const F d;
  const hn::RebindToSigned<F> integer;
  const Rows rows(run);
  if (A.kind == nullptr) {
    const std::int64_t at = run.cell_slot;
    constexpr int n = MaskedOperator::coefficients_of(bends);
    const std::int64_t first = block * (at + std::int64_t{n} * (x / block)) + x % block;
    find_pulls<couples_all, bends>(OwnCoefficients{A.coefficients + first}, u, rows, x, pulls);
    return;
  }
  const std::int64_t at = std::int64_t{run.cell_slot} + x;
  const auto kinds =
      hn::PromoteTo(integer, hn::LoadU(hn::Rebind<std::uint8_t, decltype(integer)>(), A.kind + at));
  const std::int32_t kind = A.block_kind[at / block];
  const auto is_matter = hn::RebindMask(d, hn::Gt(kinds, hn::Zero(integer)));
  if (kind > 0)
    find_pulls<couples_all, bends>(OneKind{A.coefficients + kind, A.n_kinds, is_matter}, u, rows, x, pulls);
  else
    find_pulls<couples_all, bends>(SeveralKinds{A.coefficients, A.n_kinds, kinds}, u, rows, x, pulls);
}

/// Values of the cells on the lower side of nodes, from the present vector of cells and the one before. They
/// stay in registers, because a load across two vectors that were just stored stalls.
#if HWY_TARGET == HWY_SCALAR
HWY_INLINE VF lower_side(VF before, VF) {
  return before;
}
#else
template<class V>
HWY_INLINE V lower_side(V before, V here) {
  const hn::DFromV<V> d;
  if constexpr (hn::MaxLanes(hn::DFromV<V>()) == 4)
    return hn::CombineShiftRightBytes<12>(d, here, before);
  else
    return hn::CombineShiftRightBytes<12>(d, here, hn::ConcatLowerUpper(d, here, before));
}
#endif
/// Sum and difference of the cells on both sides of a node.
HWY_INLINE VF both(VF before, VF here) {
  return hn::Add(lower_side(before, here), here);
}
HWY_INLINE VF net(VF before, VF here) {
  return hn::Sub(lower_side(before, here), here);
}
HWY_INLINE void add_to(float* at, VF value) {
  hn::StoreU(hn::Add(hn::LoadU(F(), at), value), F(), at);
}
/// Adds even +- odd_y +- odd_z +- odd_yz, less the edge forces, to the four rows.
HWY_INLINE void add_to_rows(float* forces, const Rows& at, int x, VF even, VF odd_y, VF odd_z, VF odd_yz,
                            const VF* extra) {
  const VF low = hn::Sub(even, odd_z), high = hn::Add(even, odd_z), y_low = hn::Sub(odd_y, odd_yz),
           y_high = hn::Add(odd_y, odd_yz);
  add_to(forces + at.slot[0] + x, hn::Add(hn::Sub(low, y_low), extra[0]));
  add_to(forces + at.slot[1] + x, hn::Add(hn::Add(low, y_low), extra[1]));
  add_to(forces + at.slot[2] + x, hn::Add(hn::Sub(high, y_high), extra[2]));
  add_to(forces + at.slot[3] + x, hn::Add(hn::Add(high, y_high), extra[3]));
}

/// Adds the forces of cells to the nodes from x on, the lower corners of the cells `here`. @param before
/// stresses of the vector of cells before
template<bool bends>
HWY_INLINE void add_pulls(const Pulls& before, const Pulls& here, const float* const* u, float* const* forces,
                          const Rows& at, int x) {
  const F d;
  const auto net_stress = [&](int p) HWY_ATTR { return net(before.stress[p], here.stress[p]); };
  const VF along_x[4] = {net(before.along_x[0], here.along_x[0]), net(before.along_x[1], here.along_x[1]),
                         net(before.along_x[2], here.along_x[2]), net(before.along_x[3], here.along_x[3])};
  const VF lower_xy = lower_side(before.stress[5], here.stress[5]),
           lower_xz = lower_side(before.stress[4], here.stress[4]),
           both_yz = both(before.stress[3], here.stress[3]);
  const auto net_bend = [&](VF sum, int p) HWY_ATTR {
    return bends ? hn::Add(sum, net(before.bend[p], here.bend[p])) : sum;
  };
  const auto both_bend = [&](int p)
                             HWY_ATTR { return bends ? both(before.bend[p], here.bend[p]) : hn::Zero(d); };
  add_to_rows(forces[0], at, x, net_stress(0), net_bend(hn::Add(lower_xy, here.stress[5]), 0),
              net_bend(hn::Add(lower_xz, here.stress[4]), 1), both(before.twist[0], here.twist[0]), along_x);
  const VF y_edge = both(before.y_edge, here.y_edge), z_edge = both(before.z_edge, here.z_edge);
  const auto pull = [&](VF edge, const float* of_u, int lower, int upper) HWY_ATTR {
    return hn::Mul(edge,
                   hn::Sub(hn::LoadU(d, of_u + at.slot[upper] + x), hn::LoadU(d, of_u + at.slot[lower] + x)));
  };
  const VF y0 = pull(y_edge, u[1], 0, 1), y1 = pull(y_edge, u[1], 2, 3);
  const VF along_y[4] = {hn::Neg(y0), y0, hn::Neg(y1), y1};
  add_to_rows(forces[1], at, x, hn::Sub(lower_xy, here.stress[5]),
              net_bend(both(before.stress[1], here.stress[1]), 2),
              hn::Add(both_yz, net(before.twist[1], here.twist[1])), both_bend(3), along_y);
  const VF z0 = pull(z_edge, u[2], 0, 2), z1 = pull(z_edge, u[2], 1, 3);
  const VF along_z[4] = {hn::Neg(z0), hn::Neg(z1), z0, z1};
  add_to_rows(forces[2], at, x, hn::Sub(lower_xz, here.stress[4]),
              hn::Add(both_yz, net(before.twist[2], here.twist[2])),
              net_bend(both(before.stress[2], here.stress[2]), 4), both_bend(5), along_z);
}

template<bool couples_all, bool bends>
HWY_INLINE void add_run(const MaskedOperator& A, const CellRun& run, const float* const* u,
                        float* const* forces) {
  constexpr int block = MaskedRows::block;
  const int lanes = static_cast<int>(hn::Lanes(F()));
  const Rows at(run);
  Pulls before, here;
  int x = 0;
  for (; x < run.blocks() * block; x += lanes) {
    find_pulls_of_run<couples_all, bends>(A, run, u, x, here);
    add_pulls<bends>(before, here, u, forces, at, x);
    before = here;
  }
  if (x < run.node_blocks() * block) // the upper corners of the last cell
    add_pulls<bends>(before, Pulls(), u, forces, at, x);
}

void add_forces(const MaskedOperator& A, const CellRun* runs, std::size_t n_runs, const float* u,
                float* forces) {
  const std::int64_t stride = A.component_stride;
  const float* const of_u[3] = {u, u + stride, u + 2 * stride};
  float* const of_forces[3] = {forces, forces + stride, forces + 2 * stride};
  for (std::size_t i = 0; i < n_runs; ++i)
    if (A.couples_all)
      runs[i].bends ? add_run<true, true>(A, runs[i], of_u, of_forces)
                    : add_run<true, false>(A, runs[i], of_u, of_forces);
    else
      runs[i].bends ? add_run<false, true>(A, runs[i], of_u, of_forces)
                    : add_run<false, false>(A, runs[i], of_u, of_forces);
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(add_forces);

void add_matter_forces(const MaskedOperator& A, std::span<const CellRun> runs, const float* u,
                       float* forces) {
  HWY_DYNAMIC_DISPATCH(add_forces)(A, runs.data(), runs.size(), u, forces);
}
} // namespace maille::deform
#endif
