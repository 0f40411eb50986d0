#pragma once
/// Copies between dense displacements in float64 and the padded fields in float32 of a multigrid level.
///
/// A dense displacement has a number for every node of the grid; a field has rows of slots: rows of a box,
/// rows of the nodes that touch a body, or rows of one component. A level names its rows once, by
/// for_each_row(); load_field() and store_field() are the only copies. Units differ by a factor per
/// component. Both round once, and give the same bits for any number of threads.

#include "maille/base/grid.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace maille::deform {

/// Nodes of one component that follow one another, both in a dense displacement and in the level's fields.
struct FieldRow {
  std::size_t component = 0;
  std::int64_t place = 0; ///< of the first node, in a field
  std::int64_t node = 0;  ///< the first one
  int n = 0;
  /// Inverse of the diagonal from the first node on, 0 at fixed nodes; null: all nodes are fixed.
  const float* inverse = nullptr;
};

/// field = factor times dense where components are free, 0 where they are fixed.
/// @param dense component -> its numbers by node, or null for none
template<class Level, class Dense>
void load_field(const Level& level, ThreadTeam& team, const Dense& dense, const Vec3& factor, float* field) {
  level.for_each_row(team, [&](const FieldRow& row) {
    const double* const from = dense(row.component);
    float* const to = field + row.place;
    if (from == nullptr || row.inverse == nullptr) {
      std::fill_n(to, row.n, 0.0F);
      return;
    }
    const double of_component = factor[row.component];
    for (int i = 0; i < row.n; ++i)
      to[i] = row.inverse[i] > 0 ? static_cast<float>(of_component * from[row.node + i]) : 0;
  });
}

/// dense = factor times field, at the nodes of the level. @param dense component -> its numbers by node
template<class Level, class Dense>
void store_field(const Level& level, ThreadTeam& team, const float* field, const Vec3& factor,
                 const Dense& dense) {
  level.for_each_row(team, [&](const FieldRow& row) {
    double* const to = dense(row.component) + row.node;
    const double of_component = factor[row.component];
    for (int i = 0; i < row.n; ++i)
      to[i] = of_component * double{field[row.place + i]};
  });
}

} // namespace maille::deform
