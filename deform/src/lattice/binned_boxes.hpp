#pragma once
/// Search for neighbours in space by bins.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace maille::deform {

/// Bins of space, each with the numbers of the boxes that touch it.
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

} // namespace maille::deform
