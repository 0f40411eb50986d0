#pragma once
/// The links of one body in flat arrays, for methods that visit every node many times.

#include "maille/scene/answer.hpp"

#include <cstdint>
#include <span>

namespace maille::deform {

/// Nodes of matter numbered 0, 1, ... in grid order, and for each the links to its neighbours in the order
/// -x +x -y +y -z +z (those that exist). In 3D 42 bytes a node, and 96 more a component.
class LinkTable {
public:
  LinkTable(const Scene& scene, const LinkLimits& limits);

  std::int32_t n_nodes() const { return static_cast<std::int32_t>(grid_node_.size()); }
  std::int64_t n_links() const { return static_cast<std::int64_t>(neighbour_.size()) / 2; }
  int dimension() const { return static_cast<int>(below_.size()); }
  std::int64_t grid_node(std::int32_t node) const { return grid_node_[node]; }
  /// @pre `grid_node` is a node of the body
  std::int32_t body_node(std::int64_t grid_node) const;

  /// Entries of the links of `node` are first()[node] ... first()[node + 1] - 1.
  std::span<const std::int32_t> first() const { return first_; }
  /// Per entry: the node at the other end.
  std::span<const std::int32_t> neighbour() const { return neighbour_; }
  /// Per entry: 2 axis, plus 1 if the neighbour is on the upper side.
  std::span<const std::uint8_t> direction() const { return direction_; }
  /// Per entry: the node's own displacement lies in [u_neighbour + below, u_neighbour + above] [m].
  std::span<const double> below(int component) const { return below_[component]; }
  std::span<const double> above(int component) const { return above_[component]; }

  /// One component of a grid's displacement, for the body's nodes only; and back.
  List<double> gather(const Displacement& displacement, int component) const;
  void scatter(const List<double>& values, int component, Displacement& displacement) const;

  /// The same for a table that is not made. Cost: O(nodes)
  static std::int64_t bytes_for(const Specimen& body);

private:
  void number_nodes(const Specimen& body);
  void add_links(const Specimen& body, const LinkLimits& limits, const Index3& at);

  List<std::int64_t> grid_node_; ///< ascending
  List<std::int32_t> first_;
  List<std::int32_t> neighbour_;
  List<std::uint8_t> direction_;
  List<List<double>> below_, above_; ///< [component][entry]
};

/// How many links are outside their limits by more than `tolerance` [m], and the worst excess [m].
struct Violations {
  std::int64_t links = 0;
  double worst = 0;
};
Violations count_violations(const LinkTable& table, const Displacement& displacement, double tolerance);

} // namespace maille::deform
