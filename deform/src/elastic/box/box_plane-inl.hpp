/// The operator of a box, row by row. Included once per kind of vector, by box_kernel.cpp and
/// box_double_kernel.cpp; see cone_kernel.cpp for what that forbids.
#if defined(MAILLE_BOX_PLANE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MAILLE_BOX_PLANE_INL
#undef MAILLE_BOX_PLANE_INL
#else
#define MAILLE_BOX_PLANE_INL
#endif

#include "elastic/box/box_terms-inl.hpp"

#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

/// The operator on one plane, row by row, with nodes in vectors along x. The first pass over a row stores
/// three numbers per node and component: its contributions to the force at its left neighbour, at itself, and
/// at its right neighbour. The second pass adds them.
template<class D, class Load>
class BoxPlane {
public:
  using T = hn::TFromD<D>;
  using V = hn::VFromD<D>;
  static constexpr int line = line_of_floats;

  HWY_INLINE BoxPlane(const BoxOperator& A, const BoxAxis<T>& x_axis, void* scratch)
      : A_(A), x_(x_axis), numbers_(A.coefficients),
        length_((A.nodes[0] + line - 1) / line * line + 2 * line),
        end_(static_cast<int>(hwy::RoundUpTo(static_cast<std::size_t>(A.nodes[0]), hn::Lanes(D())))),
        rows_(static_cast<T*>(scratch)) {
    for (int c = 0; c < 3; ++c) { // no neighbours beyond the ends
      row_of(c, 2)[-1] = 0;
      row_of(c, 0)[end_] = 0;
    }
  }

  /// Calls visit(x, force along x, y, z) for the vectors of row y, z.
  /// @param load load(row, x) is a vector of the dense or padded row that starts there, of whatever numbers
  ///        it is
  template<class Row, class Visit>
  HWY_INLINE void for_row(int y, int z, const Row* const* row, std::int64_t y_stride, std::int64_t z_stride,
                          const Load& load, Visit&& visit) const {
    const bool is_regular = is_regular_at(1, y) && is_regular_at(2, z);
    const std::int64_t below_y = y > 0 ? -y_stride : 0, above_y = y + 1 < A_.nodes[1] ? y_stride : 0;
    const std::int64_t below_z = z > 0 ? -z_stride : 0, above_z = z + 1 < A_.nodes[2] ? z_stride : 0;
    const Row* around[3][9];
    for (int c = 0; c < 3; ++c)
      for (int j = 0; j < 9; ++j)
        around[c][j] = row[c] +
                       (j % 3 == 0   ? below_y
                        : j % 3 == 2 ? above_y
                                     : 0) +
                       (j < 3   ? below_z
                        : j > 5 ? above_z
                                : 0);
    if (is_regular && A_.coefficients.is_aligned && !A_.coefficients.is_thin())
      first_pass<true, false>(y, z, around, load);
    else if (is_regular)
      first_pass<true, true>(y, z, around, load);
    else
      first_pass<false, true>(y, z, around, load);
    second_pass(visit);
  }

private:
  HWY_INLINE bool is_regular_at(int axis, int i) const {
    return A_.axis[axis].mass[i - 1] == 1 && A_.axis[axis].mass[i] == 1;
  }
  /// Row `kind` (0 left, 1 itself, 2 right) of the contributions of component c.
  HWY_INLINE T* row_of(int c, int kind) const { return rows_ + (3 * c + kind) * length_ + line; }

  template<bool is_regular, bool couples, class Rows>
  HWY_NOINLINE void first_pass(int y, int z, const Rows& around, const Load& load) const {
    using Y = std::conditional_t<is_regular, RegularNode<D>, AnyNode<D>>;
    const Y along_y(A_.axis[1], y), along_z(A_.axis[2], z);
    const int lanes = static_cast<int>(hn::Lanes(D()));
    for (int x = 0; x < end_; x += lanes)
      if (x < line || x >= A_.end_of_regular_lines * line)
        combine_vector<is_regular, true, couples>(x, along_y, along_z, around, load);
      else
        combine_vector<is_regular, false, couples>(x, along_y, along_z, around, load);
  }

  template<bool is_regular, bool has_ends, bool couples, class Y, class Rows>
  HWY_INLINE void combine_vector(int x, const Y& along_y, const Y& along_z, const Rows& around,
                                 const Load& load) const {
    AlongX<D> out[3];
    const auto of = [&](int c) HWY_ATTR {
      V u[9];
      for (int j = 0; j < 9; ++j)
        u[j] = load(around[c][j], x);
      return Products<D>(along_y, along_z, u);
    };
    if constexpr (couples) {
      const Products<D> of_x = of(0), of_y = of(1), of_z = of(2);
      combine<0, is_regular, has_ends>(numbers_, of_x, out);
      combine<1, is_regular, has_ends>(numbers_, of_y, out);
      combine<2, is_regular, has_ends>(numbers_, of_z, out);
      if (!A_.coefficients.is_aligned) {
        combine_rest<is_regular, has_ends>(numbers_, of_x, 0, out);
        combine_rest<is_regular, has_ends>(numbers_, of_y, 1, out);
        combine_rest<is_regular, has_ends>(numbers_, of_z, 2, out);
      }
      if (A_.coefficients.is_thin()) {
        combine_bending<is_regular, has_ends, D>(A_.coefficients, of_x, 0, out);
        combine_bending<is_regular, has_ends, D>(A_.coefficients, of_y, 1, out);
        combine_bending<is_regular, has_ends, D>(A_.coefficients, of_z, 2, out);
      }
    } else {
      combine<0, is_regular, has_ends>(numbers_, of(0), out);
      combine<1, is_regular, has_ends>(numbers_, of(1), out);
      combine<2, is_regular, has_ends>(numbers_, of(2), out);
    }
    for (int c = 0; c < 3; ++c)
      if constexpr (has_ends)
        keep_at_ends(c, x, out[c]);
      else
        keep(c, x, out[c]);
  }

  HWY_INLINE void keep(int c, int x, const AlongX<D>& o) const {
    const D d;
    const V outer = hn::Sub(o.mass, o.link), inner = hn::Add(o.mass, o.link);
    hn::Store(hn::Add(outer, o.change), d, row_of(c, 0) + x);
    hn::Store(hn::MulAdd(hn::Set(d, T{2}), inner, o.share), d, row_of(c, 1) + x);
    hn::Store(hn::Sub(outer, o.change), d, row_of(c, 2) + x);
  }

  HWY_INLINE void keep_at_ends(int c, int x, const AlongX<D>& o) const {
    const D d;
    const V mass_below = hn::LoadU(d, x_.mass + x - 1), mass_above = hn::Load(d, x_.mass + x);
    const V link_below = hn::LoadU(d, x_.link + x - 1), link_above = hn::Load(d, x_.link + x);
    const V zero = hn::Zero(d), one = hn::Set(d, T{1}), mass = hn::Add(mass_below, mass_above);
    const V ends = hn::Sub(hn::IfThenElse(hn::Gt(mass_below, zero), one, zero),
                           hn::IfThenElse(hn::Gt(mass_above, zero), one, zero)); // -1 first, 1 last
    const V left = hn::NegMulAdd(link_below, o.link, hn::MulAdd(mass_below, o.mass, o.change));
    const V right = hn::NegMulAdd(link_above, o.link, hn::MulSub(mass_above, o.mass, o.change));
    V here = hn::MulAdd(hn::Add(link_below, link_above), o.link, hn::Mul(mass, o.mass));
    here = hn::MulAdd(hn::Mul(hn::Set(d, T{0.5}), mass), o.share, here);
    here = hn::MulAdd(ends, hn::MulAdd(hn::Set(d, T{2}), o.transpose, o.change), here);
    hn::Store(left, d, row_of(c, 0) + x);
    hn::Store(here, d, row_of(c, 1) + x);
    hn::Store(right, d, row_of(c, 2) + x);
  }

  template<class Visit>
  HWY_INLINE void second_pass(Visit&& visit) const {
    const D d;
    const int lanes = static_cast<int>(hn::Lanes(d));
    const auto sum = [&](int c, int x) HWY_ATTR {
      return hn::Add(hn::Load(d, row_of(c, 1) + x),
                     hn::Add(hn::LoadU(d, row_of(c, 2) + x - 1), hn::LoadU(d, row_of(c, 0) + x + 1)));
    };
    for (int x = 0; x < end_; x += lanes)
      visit(x, sum(0, x), sum(1, x), sum(2, x));
  }

  const BoxOperator& A_;
  BoxAxis<T> x_;
  BoxNumbers<T> numbers_;
  int length_, end_; ///< of a row of scratch, and of the vectors that hold nodes
  T* rows_;
};

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#endif
