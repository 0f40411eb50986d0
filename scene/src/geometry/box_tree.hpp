#pragma once
/// A tree of bounding boxes: finds the items near a point in O(log(items)) steps. Boxes are split at the
/// median of their centres along their longest axis, down to four items.

#include "maille/base/grid.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace maille {

class BoxTree {
public:
  /// @param corners of each item, which define its box
  template<class Corners>
  explicit BoxTree(const std::vector<Corners>& corners) : items_(corners.size()) {
    std::iota(items_.begin(), items_.end(), 0U);
    for (const Corners& item : corners)
      boxes_.push_back(around(item));
    if (!items_.empty())
      split(0, static_cast<std::uint32_t>(items_.size()));
    boxes_ = {};
  }

  /// Calls visit(item) for items whose boxes are within the square root of `reach`; visit returns the new
  /// reach, so that a search for the nearest item narrows. Nearer boxes come first.
  template<class Visit>
  void near(const Vec3& at, double reach, Visit&& visit) const {
    std::vector<std::uint32_t> open;
    if (!nodes_.empty())
      open.push_back(0);
    while (!open.empty()) {
      const Node& node = nodes_[open.back()];
      const std::uint32_t left = open.back() + 1;
      open.pop_back();
      if (distance_squared(at, node.box) > reach)
        continue;
      if (node.right == 0) {
        for (std::uint32_t i = node.begin; i < node.end; ++i)
          reach = visit(std::size_t{items_[i]});
      } else {
        const bool is_left_nearer =
            distance_squared(at, nodes_[left].box) <= distance_squared(at, nodes_[node.right].box);
        open.push_back(is_left_nearer ? node.right : left);
        open.push_back(is_left_nearer ? left : node.right);
      }
    }
  }

private:
  struct Box {
    Vec3 low, high;
  };
  /// The left child follows its parent.
  struct Node {
    Box box;
    std::uint32_t begin = 0, end = 0, right = 0; ///< items; 0: not split
  };

  template<class Corners>
  static Box around(const Corners& corners) {
    Box box{corners[0], corners[0]};
    for (const Vec3& corner : corners)
      for (std::size_t a = 0; a < 3; ++a) {
        // Enlarged slightly, so that rounding of distances cannot exclude an equally near item.
        const double more = 1e-12 * std::abs(corner[a]);
        box.low[a] = std::min(box.low[a], corner[a] - more);
        box.high[a] = std::max(box.high[a], corner[a] + more);
      }
    return box;
  }
  static double distance_squared(const Vec3& at, const Box& box) {
    double sum = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double away = std::max({box.low[a] - at[a], at[a] - box.high[a], 0.0});
      sum += away * away;
    }
    return sum * (1 - 1e-12);
  }

  void split(std::uint32_t begin, std::uint32_t end) {
    constexpr std::uint32_t most = 4;
    Box box = boxes_[items_[begin]];
    for (std::uint32_t i = begin; i < end; ++i)
      for (std::size_t a = 0; a < 3; ++a) {
        box.low[a] = std::min(box.low[a], boxes_[items_[i]].low[a]);
        box.high[a] = std::max(box.high[a], boxes_[items_[i]].high[a]);
      }
    const std::size_t at = nodes_.size();
    nodes_.push_back({box, begin, end, 0});
    if (end - begin <= most)
      return;
    std::size_t axis = 0;
    for (std::size_t a = 1; a < 3; ++a)
      axis = box.high[a] - box.low[a] > box.high[axis] - box.low[axis] ? a : axis;
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end,
                     [&](std::uint32_t one, std::uint32_t other) {
                       return boxes_[one].low[axis] + boxes_[one].high[axis] <
                              boxes_[other].low[axis] + boxes_[other].high[axis];
                     });
    split(begin, middle);
    nodes_[at].right = static_cast<std::uint32_t>(nodes_.size());
    split(middle, end);
  }

  std::vector<std::uint32_t> items_;
  std::vector<Box> boxes_; ///< of the items, while the tree grows
  std::vector<Node> nodes_;
};

} // namespace maille
