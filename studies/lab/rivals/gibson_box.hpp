#pragma once
/// What drags of a homogeneous box are measured against: Gibson's chain mail of 1997, as it was published and
/// in the best form that we know. Both take the same candidates in the same order as deform's `literal` (see
/// there) and form the same float32 sums; the state is kept from drag to drag, and lists keep their memory.

#include "maille/scene/link_limits.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace maille::lab {

/// As published: an element knows its place and its six neighbours, a candidate its sponsor.
class GibsonElements {
public:
  GibsonElements(const Scene& scene, const LinkLimits& limits);
  std::int64_t move_to(std::int64_t node, const Vec3& displacement);
  double displacement(int component, std::int64_t node) const {
    return double{elements_[static_cast<std::size_t>(node)].u[static_cast<std::size_t>(component)]};
  }

private:
  struct Element {
    std::array<float, 3> u{};
    std::array<std::int32_t, 6> neighbour{}; ///< -x +x -y +y -z +z; -1 without a neighbour
  };
  struct Candidate {
    std::int32_t node, sponsor;
  };
  void offer(std::int32_t node, std::size_t direction);
  bool follow(const Candidate& candidate, std::size_t direction);

  std::array<std::array<float, 3>, 6> least_,
      greatest_; ///< of a candidate above its sponsor, [direction][component]
  std::vector<Element> elements_;
  std::array<std::vector<Candidate>, 6> list_;
};

/// In the best form: no links, as a box needs none; a candidate is one 32-bit word (its place; its list says
/// where its sponsor is).
class GibsonBox {
public:
  /// @param scene a box of one material of at most 1024 nodes a side, at rest
  GibsonBox(const Scene& scene, const LinkLimits& limits);

  /// Puts a node at a displacement and lets the others follow.
  /// @return candidates looked at
  std::int64_t move_to(std::int64_t node, const Vec3& displacement);
  double displacement(int component, std::int64_t node) const {
    return double{state_[static_cast<std::size_t>(node)][static_cast<std::size_t>(component)]};
  }

private:
  using Node = std::array<float, 3>;
  using Place = std::uint32_t; ///< x, y, z in ten bits each
  static constexpr int bits = 10;

  void offer(Place place, int direction);
  bool follow(const Node& sponsor, Node& node, int direction) const;
  std::size_t number(Place place) const;

  Index3 n_;
  std::array<Node, 3> low_, high_; ///< of a link, [axis][component]
  std::vector<Node> state_;
  std::array<std::vector<Place>, 6> list_; ///< candidates moved along -x +x -y +y -z +z
};

} // namespace maille::lab
