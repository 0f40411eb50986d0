#pragma once
/// Which parts of a skin are near one another, and which cross.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace maille::deform {

/// Boxes of space, each with the numbers of what touches it.
class BinnedBoxes {
public:
  explicit BinnedBoxes(double edge) : edge_(edge) {}
  void add(std::int32_t number, const Eigen::AlignedBox3d& box) {
    for_each_key(box, [&](const Key& key) { list_.push_back({key, number}); });
  }
  void sort() { std::ranges::sort(list_); }
  /// Calls visit(number) for all that share a bin with a box, perhaps several times each.
  template<class Visit>
  void visit(const Eigen::AlignedBox3d& box, Visit&& visit) const {
    for_each_key(box, [&](const Key& key) {
      for (auto entry = std::ranges::lower_bound(list_, key, {}, &Entry::first);
           entry != list_.end() && entry->first == key; ++entry)
        visit(entry->second);
    });
  }

private:
  using Key = std::array<int, 3>;
  using Entry = std::pair<Key, std::int32_t>;
  template<class Visit>
  void for_each_key(const Eigen::AlignedBox3d& box, Visit&& visit) const {
    Key first, last, key;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto i = static_cast<Eigen::Index>(a);
      first[a] = static_cast<int>(std::floor(box.min()[i] / edge_));
      last[a] = static_cast<int>(std::floor(box.max()[i] / edge_));
    }
    for (key[2] = first[2]; key[2] <= last[2]; ++key[2])
      for (key[1] = first[1]; key[1] <= last[1]; ++key[1])
        for (key[0] = first[0]; key[0] <= last[0]; ++key[0])
          visit(key);
  }
  double edge_;
  std::vector<Entry> list_;
};

/// In two dimensions; touching counts.
inline bool do_segments_cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                              const Eigen::Vector3d& d) {
  const auto side = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
  };
  return side(a, b, c) * side(a, b, d) <= 0 && side(c, d, a) * side(c, d, b) <= 0;
}

/// Of a segment and a triangle. Source  Moeller and Trumbore 1997.
inline bool does_segment_cross(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                               const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  constexpr double rounding = 1e-9;
  const Eigen::Vector3d way = to - from, ab = b - a, ac = c - a, across = way.cross(ac);
  const double determinant = ab.dot(across);
  if (std::abs(determinant) < std::numeric_limits<double>::min())
    return false;
  const Eigen::Vector3d off = from - a, turned = off.cross(ab);
  const double u = off.dot(across) / determinant, v = way.dot(turned) / determinant,
               t = ac.dot(turned) / determinant;
  return u >= -rounding && v >= -rounding && u + v <= 1 + rounding && t >= 0 && t <= 1;
}

} // namespace maille::deform
