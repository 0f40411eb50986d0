#pragma once
/// The trilinear map of one deformed cell, and its inverse. Private to scene.

#include "warp/mild_inverse.hpp"

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace maille::warping {

using Corners = std::array<Eigen::Vector3d, 8>; ///< corner c is the upper one along axis a if bit a is set

/// x(s) = middle + J s + D s t + E s u + F t u + G s t u, (s, t, u) from -1/2 to 1/2: maps a place at rest in
/// a cell to its deformed place.
class CellMap {
public:
  /// Points within this distance of a face count as inside, so that no place is between two cells.
  static constexpr double slack = 1e-6;

  explicit CellMap(const Corners& x) {
    // Sums and differences along one axis after the other.
    const auto pairs = [](const Corners& from) {
      Corners to;
      for (std::size_t c = 0; c < 4; ++c) {
        to[c] = from[2 * c] + from[2 * c + 1];
        to[c + 4] = from[2 * c + 1] - from[2 * c];
      }
      return to; // the next axis is the lowest bit now
    };
    const Corners term = pairs(pairs(pairs(x))); // bit a: differences along axis a
    middle_ = term[0] / 8;
    jacobian_.col(0) = term[1] / 4;
    jacobian_.col(1) = term[2] / 4;
    jacobian_.col(2) = term[4] / 4;
    st_ = term[3] / 2;
    su_ = term[5] / 2;
    tu_ = term[6] / 2;
    stu_ = term[7];
    jacobian_.computeInverseAndDetWithCheck(inverse_, determinant_, is_invertible_, 0);
    if (is_invertible_)
      spread_ = inverse_.cwiseAbs() *
                ((st_.cwiseAbs() + su_.cwiseAbs() + tu_.cwiseAbs()) / 4 + stu_.cwiseAbs() / 8);
    is_mild_ = is_invertible_ && spread_.maxCoeff() < 0.1;
  }

  Eigen::Vector3d of(const Eigen::Vector3d& s) const { return middle_ + beyond_middle(s); }
  Eigen::Matrix3d jacobian(const Eigen::Vector3d& s) const {
    Eigen::Matrix3d j = jacobian_;
    j.col(0) += st_ * s[1] + su_ * s[2] + stu_ * (s[1] * s[2]);
    j.col(1) += st_ * s[0] + tu_ * s[2] + stu_ * (s[0] * s[2]);
    j.col(2) += su_ * s[0] + tu_ * s[1] + stu_ * (s[0] * s[1]);
    return j;
  }
  /// True if matter is inverted at one or more corners: det J has not the sign of `orientation` there.
  bool is_folded(double orientation) const {
    // J(s) = J (1 + A), row sums of A are at most 6 spreads: below 1 the determinant keeps its sign.
    if (is_mild_)
      return !(orientation * determinant_ > 0);
    return !(least_determinant(orientation) > 0);
  }
  /// True if the map is nearly affine, so that the inverse at the centre is enough for Newton steps.
  bool is_mild() const { return is_mild_; }
  const Eigen::Vector3d& middle() const { return middle_; }
  /// The map for invert. @pre is_mild()
  MildMap mild() const {
    MildMap map;
    map.largest_row = jacobian_.cwiseAbs().rowwise().sum().maxCoeff();
    const Eigen::Vector3d st = inverse_ * st_, su = inverse_ * su_, tu = inverse_ * tu_,
                          stu = inverse_ * stu_;
    for (Eigen::Index a = 0; a < 3; ++a) {
      const auto row = static_cast<std::size_t>(a);
      for (Eigen::Index b = 0; b < 3; ++b)
        map.inverse[3 * row + static_cast<std::size_t>(b)] = inverse_(a, b);
      map.st[row] = st[a];
      map.su[row] = su[a];
      map.tu[row] = tu[a];
      map.stu[row] = stu[a];
      map.spread[row] = spread_[a];
    }
    return map;
  }
  /// Narrows a row of voxels along x, `first` to `last`, to those whose centres may be in the cell. `at` is
  /// the centre with index 0.
  void narrow(const Eigen::Vector3d& at, int& first, int& last) const {
    if (!is_invertible_)
      return;
    const Eigen::Vector3d place = inverse_ * (at - middle_), step = inverse_.col(0);
    double low = first, high = last;
    for (int a = 0; a < 3; ++a) {
      const double reach = 0.5 + 2 * slack + spread_[a];
      if (std::abs(step[a]) < 1e-9) {
        if (std::abs(place[a] + step[a] * low) > reach + 1e-6)
          high = -1;
        continue;
      }
      const double one = (-reach - place[a]) / step[a], other = (reach - place[a]) / step[a];
      low = std::max(low, std::min(one, other) - 1e-6);
      high = std::min(high, std::max(one, other) + 1e-6);
    }
    if (!(low <= high)) {
      last = first - 1;
      return;
    }
    first = static_cast<int>(low) + (static_cast<int>(low) < low ? 1 : 0); // neither is negative
    last = static_cast<int>(high);
  }

  /// The (s, t, u) of a place in the cell, faces included; nothing outside.
  std::optional<Eigen::Vector3d> inverse(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d from_middle = x - middle_;
    if (is_invertible_) {
      const Eigen::Vector3d first = inverse_ * from_middle;
      // The non-affine terms cannot move a place back in from further away.
      if (((first.cwiseAbs() - spread_).array() > 0.5 + slack).any())
        return std::nullopt;
      if (const auto s = refined(from_middle, first))
        if (const auto found = inside(*s))
          return found;
      if (is_mild_)
        return std::nullopt;
    }
    for (unsigned c = 0; c < 8; ++c) // a strongly distorted cell: start from each of its corners
      if (const auto s =
              refined(from_middle, {c & 1U ? 0.3 : -0.3, c & 2U ? 0.3 : -0.3, c & 4U ? 0.3 : -0.3}))
        if (const auto found = inside(*s))
          return found;
    return std::nullopt;
  }

private:
  /// Minimum of det J over the corners, times `orientation`.
  double least_determinant(double orientation) const {
    double least = INFINITY;
    for (unsigned c = 0; c < 8; ++c)
      least = std::min(
          least, orientation *
                     jacobian({c & 1U ? 0.5 : -0.5, c & 2U ? 0.5 : -0.5, c & 4U ? 0.5 : -0.5}).determinant());
    return least;
  }
  Eigen::Vector3d beyond_middle(const Eigen::Vector3d& s) const {
    return jacobian_ * s + st_ * (s[0] * s[1]) + su_ * (s[0] * s[2]) + tu_ * (s[1] * s[2]) +
           stu_ * (s[0] * s[1] * s[2]);
  }
  static std::optional<Eigen::Vector3d> inside(const Eigen::Vector3d& s) {
    if ((s.array().abs() > 0.5 + slack).any())
      return std::nullopt;
    return s;
  }
  /// Newton iteration; for nearly affine maps with the inverse at the centre, which needs no division.
  std::optional<Eigen::Vector3d> refined(const Eigen::Vector3d& from_middle, Eigen::Vector3d s) const {
    constexpr double tolerance = 1e-8; // [voxels], far below slack
    constexpr int most_steps = 30;
    for (int step = 0; step < most_steps; ++step) {
      const Eigen::Vector3d left = from_middle - beyond_middle(s);
      if (left.cwiseAbs().maxCoeff() <= tolerance)
        return s;
      if (is_mild_) {
        s += inverse_ * left;
        continue;
      }
      const Eigen::Matrix3d j = jacobian(s);
      Eigen::Matrix3d back;
      bool is_invertible = false;
      j.computeInverseWithCheck(back, is_invertible, 0);
      if (!is_invertible)
        return std::nullopt;
      s += back * left;
      if (!(s.cwiseAbs().maxCoeff() < 10))
        return std::nullopt;
    }
    return std::nullopt;
  }

  Eigen::Vector3d middle_, st_, su_, tu_, stu_;
  Eigen::Matrix3d jacobian_, inverse_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d spread_ = Eigen::Vector3d::Zero(); ///< upper bound of the non-affine part of the inverse
  double determinant_ = 0;
  bool is_invertible_ = false, is_mild_ = false;
};

} // namespace maille::warping
