/// Contributions of a vector of nodes of a box to forces. Included once per vector instruction set, by
/// box_kernel.cpp and box_double_kernel.cpp; see cone_kernel.cpp for the restrictions.
#if defined(MAILLE_BOX_TERMS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MAILLE_BOX_TERMS_INL
#undef MAILLE_BOX_TERMS_INL
#else
#define MAILLE_BOX_TERMS_INL
#endif

#include "elastic/box/box_kernel.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Operators along an axis at a node whose two cells are regular (see BoxCoefficients). There T = -D.
template<class D>
struct RegularNode {
  using V = hn::VFromD<D>;
  V two;
  HWY_INLINE RegularNode(const BoxAxis<double>&, int) : two(hn::Set(D(), 2)) {}
  HWY_INLINE V mass(V below, V here, V above) const { return hn::MulAdd(two, here, hn::Add(below, above)); }
  HWY_INLINE V link(V below, V here, V above) const { return hn::MulSub(two, here, hn::Add(below, above)); }
  HWY_INLINE V difference(V below, V, V above) const { return hn::Sub(above, below); }
  HWY_INLINE V transpose(V below, V, V above) const { return hn::Sub(below, above); }
  HWY_INLINE V share(V here) const { return here; }
};

/// The same at any node: weights are 0 where there is no cell.
template<class D>
struct AnyNode {
  using V = hn::VFromD<D>;
  using T = hn::TFromD<D>;
  V mass_below, mass_above, mass_here, link_below, link_above, link_here, is_below, is_above, is_here, half;

  HWY_INLINE AnyNode(const BoxAxis<double>& axis, int i) {
    const D d;
    const auto set = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<T>(value)); };
    const double m0 = axis.mass[i - 1], m1 = axis.mass[i], l0 = axis.link[i - 1], l1 = axis.link[i];
    const double c0 = m0 > 0 ? 1 : 0, c1 = m1 > 0 ? 1 : 0;
    mass_below = set(m0), mass_above = set(m1), mass_here = set(m0 + m1);
    link_below = set(l0), link_above = set(l1), link_here = set(l0 + l1);
    is_below = set(c0), is_above = set(c1), is_here = set(c0 - c1);
    half = set(0.5 * (m0 + m1));
  }
  HWY_INLINE V mass(V below, V here, V above) const {
    return hn::MulAdd(mass_here, here, hn::MulAdd(mass_above, above, hn::Mul(mass_below, below)));
  }
  HWY_INLINE V link(V below, V here, V above) const {
    return hn::NegMulAdd(link_above, above, hn::NegMulAdd(link_below, below, hn::Mul(link_here, here)));
  }
  HWY_INLINE V difference(V below, V here, V above) const {
    return hn::MulAdd(is_here, here, hn::NegMulAdd(is_below, below, hn::Mul(is_above, above)));
  }
  HWY_INLINE V transpose(V below, V here, V above) const {
    return hn::MulAdd(is_here, here, hn::NegMulAdd(is_above, above, hn::Mul(is_below, below)));
  }
  HWY_INLINE V share(V here) const { return hn::Mul(half, here); }
};

/// Coefficients as the loops use them.
template<class T>
struct BoxNumbers {
  T strain[3][3][3][3], minor[3][3][3][3], edge[3], self[3], pair[3];
  T x_y[3][3], x_z[3][3], y_z[3][3]; ///< sums of strain[i][a][j][b] and strain[i][b][j][a], negative
  T minor_x_y[3][3], minor_x_z[3][3], minor_y_z[3][3];

  explicit BoxNumbers(const BoxCoefficients& c) {
    for (int i = 0; i < 3; ++i) {
      edge[i] = static_cast<T>(c.edge[i]);
      self[i] = static_cast<T>(c.twist_self[i]);
      pair[i] = static_cast<T>(c.twist_pair[i]);
      for (int a = 0; a < 3; ++a)
        for (int j = 0; j < 3; ++j)
          for (int b = 0; b < 3; ++b) {
            strain[i][a][j][b] = static_cast<T>(c.strain[i][a][j][b]);
            const bool is_major = (i == j && a == b) || (i == a && j == b) || (i == b && j == a);
            minor[i][a][j][b] = is_major ? T{0} : strain[i][a][j][b];
          }
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        x_y[i][j] = -(strain[i][0][j][1] + strain[i][1][j][0]);
        x_z[i][j] = -(strain[i][0][j][2] + strain[i][2][j][0]);
        y_z[i][j] = -(strain[i][1][j][2] + strain[i][2][j][1]);
        minor_x_y[i][j] = -(minor[i][0][j][1] + minor[i][1][j][0]);
        minor_x_z[i][j] = -(minor[i][0][j][2] + minor[i][2][j][0]);
        minor_y_z[i][j] = -(minor[i][1][j][2] + minor[i][2][j][1]);
      }
  }
};

/// Products of operators along y (first letter) and z of one component.
template<class D>
struct Products {
  using V = hn::VFromD<D>;
  V MM, LM, ML, LL, DM, MD, DL, LD, DD, TM, MT, TL, LT, TD, DT, LE, EL, EE;

  /// u[3 k + j]: vectors of the nine rows around, j along y and k along z
  template<class Y, class Z>
  HWY_INLINE Products(const Y& y, const Z& z, const V* u) {
    V m[3], l[3], d[3], t[3], e[3];
    for (int j = 0; j < 3; ++j) {
      m[j] = z.mass(u[j], u[3 + j], u[6 + j]);
      l[j] = z.link(u[j], u[3 + j], u[6 + j]);
      d[j] = z.difference(u[j], u[3 + j], u[6 + j]);
      t[j] = z.transpose(u[j], u[3 + j], u[6 + j]);
      e[j] = z.share(u[3 + j]);
    }
    MM = y.mass(m[0], m[1], m[2]), LM = y.link(m[0], m[1], m[2]);
    ML = y.mass(l[0], l[1], l[2]), LL = y.link(l[0], l[1], l[2]);
    DM = y.difference(m[0], m[1], m[2]), DL = y.difference(l[0], l[1], l[2]);
    TM = y.transpose(m[0], m[1], m[2]), TL = y.transpose(l[0], l[1], l[2]);
    MD = y.mass(d[0], d[1], d[2]), LD = y.link(d[0], d[1], d[2]);
    MT = y.mass(t[0], t[1], t[2]), LT = y.link(t[0], t[1], t[2]);
    DD = y.difference(d[0], d[1], d[2]);
    TD = y.transpose(d[0], d[1], d[2]), DT = y.difference(t[0], t[1], t[2]);
    LE = y.link(e[0], e[1], e[2]), EL = y.share(l[1]), EE = y.share(e[1]);
  }
};

/// Operands of the operators along x for one component of the force: L_x link + M_x mass + D_x difference +
/// T_x transpose + E_x share. At regular cells T_x = -D_x, so `difference` minus `transpose` is stored, and
/// `transpose` for the ends of rows.
template<class D>
struct AlongX {
  using V = hn::VFromD<D>;
  V link, mass, change, transpose, share;
};

/// Contribution of one component of the displacement, for materials aligned with the grid. Components come in
/// turn, x, y, z, so that the live values fit the registers.
template<int j, bool is_regular, bool has_ends, class D>
HWY_INLINE void combine(const BoxNumbers<hn::TFromD<D>>& n, const Products<D>& u, AlongX<D>* out) {
  const D d;
  const auto k = [d](auto value) HWY_ATTR { return hn::Set(d, value); };
  const auto& s = n.strain;
  const auto own_mass = hn::MulAdd(k(s[j][2][j][2]), u.ML, hn::Mul(k(s[j][1][j][1]), u.LM));
  const auto own_link = hn::Mul(k(s[j][0][j][0]), u.MM);
  if constexpr (j == 0) {
    out[0].link = hn::MulAdd(k(n.edge[0]), u.EE, own_link);
    out[0].mass = hn::MulAdd(k(n.self[0]), u.LL, own_mass);
    out[0].share = hn::Zero(d);
    if constexpr (!is_regular || has_ends) {
      out[1].transpose = hn::MulAdd(k(n.pair[2]), u.DL, hn::Mul(k(s[1][0][0][1]), u.DM));
      out[2].transpose = hn::MulAdd(k(n.pair[1]), u.LD, hn::Mul(k(s[2][0][0][2]), u.MD));
    }
    if constexpr (is_regular) {
      out[1].change = hn::NegMulAdd(k(n.pair[2]), u.DL, hn::Mul(k(n.x_y[1][0]), u.DM));
      out[2].change = hn::NegMulAdd(k(n.pair[1]), u.LD, hn::Mul(k(n.x_z[2][0]), u.MD));
    } else {
      out[1].change = hn::MulSub(k(s[1][1][0][0]), u.TM, out[1].transpose);
      out[2].change = hn::MulSub(k(s[2][2][0][0]), u.MT, out[2].transpose);
    }
  } else if constexpr (j == 1) {
    out[1].link = hn::MulAdd(k(n.self[1]), u.ML, own_link);
    out[1].mass = own_mass;
    out[1].share = hn::Mul(k(n.edge[1]), u.LE);
    if constexpr (!is_regular || has_ends)
      out[0].transpose = hn::Mul(k(s[0][0][1][1]), u.DM);
    if constexpr (is_regular) {
      out[0].change = hn::NegMulAdd(k(n.pair[2]), u.DL, hn::Mul(k(n.x_y[0][1]), u.DM));
      out[2].link = hn::Mul(k(-n.pair[0]), u.DD);
      out[2].mass = hn::Mul(k(n.y_z[2][1]), u.DD);
    } else {
      out[0].change = hn::MulAdd(k(n.pair[2]), u.TL, hn::Mul(k(s[0][1][1][0]), u.TM));
      out[0].change = hn::Sub(out[0].change, out[0].transpose);
      out[2].link = hn::Mul(k(n.pair[0]), u.TD);
      out[2].mass = hn::MulAdd(k(s[2][2][1][1]), u.DT, hn::Mul(k(s[2][1][1][2]), u.TD));
    }
  } else {
    out[2].link = hn::Add(out[2].link, hn::MulAdd(k(n.self[2]), u.LM, own_link));
    out[2].mass = hn::Add(out[2].mass, own_mass);
    out[2].share = hn::Mul(k(n.edge[2]), u.EL);
    const auto along_x = hn::Mul(k(s[0][0][2][2]), u.MD);
    if constexpr (!is_regular || has_ends)
      out[0].transpose = hn::Add(out[0].transpose, along_x);
    if constexpr (is_regular) {
      out[0].change = hn::MulAdd(k(n.x_z[0][2]), u.MD, hn::NegMulAdd(k(n.pair[1]), u.LD, out[0].change));
      out[1].link = hn::NegMulAdd(k(n.pair[0]), u.DD, out[1].link);
      out[1].mass = hn::MulAdd(k(n.y_z[1][2]), u.DD, out[1].mass);
    } else {
      const auto change = hn::MulAdd(k(n.pair[1]), u.LT, hn::MulSub(k(s[0][2][2][0]), u.MT, along_x));
      out[0].change = hn::Add(out[0].change, change);
      out[1].link = hn::MulAdd(k(n.pair[0]), u.DT, out[1].link);
      out[1].mass = hn::MulAdd(k(s[1][2][2][1]), u.DT, hn::MulAdd(k(s[1][1][2][2]), u.TD, out[1].mass));
    }
  }
}

/// The terms that combine() omits: coupling of normal strains and shears with other shears.
template<bool is_regular, bool has_ends, class D, class P = Products<D>>
HWY_INLINE void combine_rest(const BoxNumbers<hn::TFromD<D>>& n, const P& u, int j, AlongX<D>* out) {
  const D d;
  const auto k = [d](auto value) HWY_ATTR { return hn::Set(d, value); };
  for (int i = 0; i < 3; ++i) {
    const auto& s = n.minor[i];
    AlongX<D>& o = out[i];
    o.link = hn::MulAdd(k(s[0][j][0]), u.MM, o.link);
    o.mass = hn::MulAdd(k(s[1][j][1]), u.LM, hn::MulAdd(k(s[2][j][2]), u.ML, o.mass));
    if constexpr (is_regular) {
      o.mass = hn::MulAdd(k(n.minor_y_z[i][j]), u.DD, o.mass);
      o.change = hn::MulAdd(k(n.minor_x_y[i][j]), u.DM, hn::MulAdd(k(n.minor_x_z[i][j]), u.MD, o.change));
      if constexpr (has_ends)
        o.transpose = hn::MulAdd(k(s[0][j][1]), u.DM, hn::MulAdd(k(s[0][j][2]), u.MD, o.transpose));
    } else {
      o.mass = hn::MulAdd(k(s[1][j][2]), u.TD, hn::MulAdd(k(s[2][j][1]), u.DT, o.mass));
      const auto t = hn::MulAdd(k(s[0][j][1]), u.DM, hn::Mul(k(s[0][j][2]), u.MD));
      o.transpose = hn::Add(o.transpose, t);
      o.change = hn::MulAdd(k(s[1][j][0]), u.TM, hn::MulAdd(k(s[2][j][0]), u.MT, hn::Sub(o.change, t)));
    }
  }
}

/// Bending terms of thin boxes: as strains, with the link across in place of the mass.
template<bool is_regular, bool has_ends, class D, class P = Products<D>>
HWY_INLINE void combine_bending(const BoxCoefficients& c, const P& u, int j, AlongX<D>* out) {
  const D d;
  const auto k = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<hn::TFromD<D>>(value)); };
  for (int i = 0; i < 3; ++i) {
    AlongX<D>& o = out[i];
    if (c.bends[0] && i != 0 && j != 0) {
      const auto& s = c.bending[0][i];
      o.link = hn::MulAdd(k(s[1][j][1]), u.LM, hn::MulAdd(k(s[2][j][2]), u.ML, o.link));
      o.link = hn::MulAdd(k(s[1][j][2]), u.TD, hn::MulAdd(k(s[2][j][1]), u.DT, o.link));
    }
    auto t = hn::Zero(d), change = t;
    if (c.bends[1] && i != 1 && j != 1) {
      const auto& s = c.bending[1][i];
      o.link = hn::MulAdd(k(s[0][j][0]), u.LM, o.link);
      o.mass = hn::MulAdd(k(s[2][j][2]), u.LL, o.mass);
      t = hn::Mul(k(s[0][j][2]), u.LD);
      change = hn::Mul(k(s[2][j][0]), u.LT);
    }
    if (c.bends[2] && i != 2 && j != 2) {
      const auto& s = c.bending[2][i];
      o.link = hn::MulAdd(k(s[0][j][0]), u.ML, o.link);
      o.mass = hn::MulAdd(k(s[1][j][1]), u.LL, o.mass);
      t = hn::MulAdd(k(s[0][j][1]), u.DL, t);
      change = hn::MulAdd(k(s[1][j][0]), u.TL, change);
    }
    if constexpr (!is_regular || has_ends)
      o.transpose = hn::Add(o.transpose, t);
    o.change = hn::Add(o.change, hn::Sub(change, t));
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#endif
