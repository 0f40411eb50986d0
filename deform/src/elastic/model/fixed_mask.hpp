#pragma once
/// Which components of which nodes may not move: a byte per node, bit c for component c.
///
/// Fixed are prescribed components and, where a specimen is given, all components of nodes without matter.
/// Solvers in float64, boxes, limits, ties and blocks read it. It has no values: questions that prescribe
/// other values at the same components have equal masks.

#include "maille/base/arena.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace maille::deform {

class FixedMask {
public:
  static constexpr std::uint8_t all_components = 7;

  FixedMask() = default;
  /// All components are free.
  explicit FixedMask(std::size_t n_nodes) : bits_(n_nodes, 0) {}
  /// The prescribed components.
  FixedMask(const Grid& grid, const std::vector<Prescribed>& prescribed)
      : FixedMask(static_cast<std::size_t>(grid.n_nodes())) {
    for (const Prescribed& p : prescribed)
      fix(p.node, static_cast<std::uint8_t>(1U << p.component));
  }
  /// The prescribed components, and nodes without matter.
  FixedMask(const Specimen& body, const std::vector<Prescribed>& prescribed)
      : FixedMask(body.grid, prescribed) {
    for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
      if (!body.is_node(body.grid.node_at(node)))
        fix(node, all_components);
  }

  bool operator()(std::integral auto component, std::integral auto node) const {
    return (at(node) >> component & 1) != 0;
  }
  /// Bits of a node.
  std::uint8_t at(std::integral auto node) const { return bits_[node]; }
  void fix(std::integral auto node, std::uint8_t bits) {
    bits_[node] = static_cast<std::uint8_t>(at(node) | bits);
  }
  /// The same for fields that have only these components, in this order.
  FixedMask of(const std::vector<int>& components) const {
    FixedMask some(n_nodes());
    for (std::size_t node = 0; node < n_nodes(); ++node)
      for (std::size_t k = 0; k < components.size(); ++k)
        if ((*this)(components[k], node))
          some.fix(node, static_cast<std::uint8_t>(1U << k));
    return some;
  }
  /// The same for these nodes, in this order.
  FixedMask of_nodes(const std::vector<std::int64_t>& nodes) const {
    FixedMask some(nodes.size());
    for (std::size_t place = 0; place < nodes.size(); ++place)
      some.fix(place, at(nodes[place]));
    return some;
  }
  /// Components that are fixed anywhere in a row, for rows of `length` nodes.
  FixedMask of_rows(std::size_t length) const {
    FixedMask rows(n_nodes() / length);
    for (std::size_t row = 0; row < rows.n_nodes(); ++row)
      for (std::size_t i = 0; i < length; ++i)
        rows.bits_[row] |= bits_[row * length + i];
    return rows;
  }
  std::size_t n_nodes() const { return bits_.size(); }
  std::int64_t n_fixed() const {
    std::int64_t n = 0;
    for (const std::uint8_t bits : bits_)
      n += std::popcount(bits);
    return n;
  }
  /// Number of components that are fixed in exactly one mask. @pre as many nodes
  std::int64_t n_differences(const FixedMask& other) const {
    std::int64_t n = 0;
    for (std::size_t node = 0; node < bits_.size(); ++node)
      n += std::popcount(static_cast<std::uint8_t>(bits_[node] ^ other.bits_[node]));
    return n;
  }
  bool operator==(const FixedMask&) const = default;

private:
  List<std::uint8_t> bits_;
};

} // namespace maille::deform
