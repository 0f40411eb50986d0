#pragma once
/// Links of one level that are stiffer than the tissue about them, in the order of its loops.

#include "maille/scene/arena.hpp"

#include <cstdint>

namespace maille::deform {

/// Adds stiffness / 2 (u_far - u_near)^2 of one component to the energy.
struct PenaltyLink {
  int component = 0, axis = 0;
  std::int64_t node =
      0; ///< the near one: on a grid its dense number, on a level of a multigrid as that numbers nodes
  double stiffness = 0; ///< [N/m] or what a level counts in

  bool operator==(const PenaltyLink&) const = default;
};

/// Links that are there more than once become one; sorted.
List<PenaltyLink> merged(List<PenaltyLink> links);

/// The rows of a sparse matrix beside the operator of a level: few, as a rule.
class PenaltyRows {
public:
  struct Row {
    std::int64_t at = 0;             ///< place of the node's component in the fields
    float inverse = 0;               ///< of the diagonal of operator and links
    float diagonal = 0;              ///< of the links
    std::int32_t first = 0, end = 0; ///< of its links
  };
  struct End {
    std::int64_t at = 0, other = 0; ///< places in the fields
    float stiffness = 0;
  };

  PenaltyRows() = default;
  /// @param ends of links at nodes that may move, two for each link between such nodes, in any order;
  /// @param slab_stride, component_stride of the fields, @param planes of the level
  PenaltyRows(const List<End>& ends, std::int64_t slab_stride, std::int64_t component_stride, int planes);

  List<Row>& rows() { return rows_; }
  bool is_empty() const { return rows_.empty(); }
  int planes() const { return is_empty() ? 0 : static_cast<int>(first_row_.size()) - 1; }
  /// next -= weight (links' part of A u) / diagonal: the rest of a Jacobi step, on one plane.
  void relax(int z, float weight, const float* u, float* next) const {
    for_plane(z, [&](const Row& row) { next[row.at] -= weight * row.inverse * force(row, u); });
  }
  /// r -= links' part of A u, on one plane.
  void subtract(int z, const float* u, float* r) const {
    for_plane(z, [&](const Row& row) { r[row.at] -= force(row, u); });
  }
  /// q += links' part of A p, on one plane. @return the plane's part of p . that
  double add(int z, const float* p, float* q) const {
    double sum = 0;
    for_plane(z, [&](const Row& row) {
      const float pull = force(row, p);
      q[row.at] += pull;
      sum += double{p[row.at]} * double{pull};
    });
    return sum;
  }
  const List<End>& ends() const { return ends_; }

private:
  template<class Visit>
  void for_plane(int z, Visit&& visit) const {
    if (rows_.empty())
      return;
    const auto plane = static_cast<std::size_t>(z);
    for (auto i = static_cast<std::size_t>(first_row_[plane]);
         i < static_cast<std::size_t>(first_row_[plane + 1]); ++i)
      visit(rows_[i]);
  }
  float force(const Row& row, const float* u) const {
    const float here = u[row.at];
    float sum = 0;
    for (auto i = static_cast<std::size_t>(row.first); i < static_cast<std::size_t>(row.end); ++i)
      sum += ends_[i].stiffness * (here - u[ends_[i].other]);
    return sum;
  }

  List<End> ends_;
  List<Row> rows_;
  List<std::int32_t> first_row_; ///< per plane, and the end
};

} // namespace maille::deform
