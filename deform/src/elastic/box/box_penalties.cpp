#include "elastic/box/box_level.hpp"

#include <algorithm>

namespace maille::deform {

void BoxLevel::set_penalties(const List<PenaltyLink>& links) {
  const int nx = operator_.nodes[0], ny = operator_.nodes[1];
  for (const ChangedRow& changed : changed_rows_)
    inverse_rows_[changed.component][changed.row] = changed.original;
  changed_rows_.clear();
  const std::int64_t strides[3] = {1, operator_.row_stride, operator_.slab_stride};
  List<PenaltyRows::End> ends;
  ends.reserve(2 * links.size());
  for (const PenaltyLink& link : links) {
    const auto x = static_cast<int>(link.node % nx), y = static_cast<int>(link.node / nx % ny),
               z = static_cast<int>(link.node / nx / ny);
    const std::int64_t near = offset(link.component, x, y, z), far = near + strides[link.axis];
    const auto stiffness = static_cast<float>(link.stiffness);
    if (may_move(link.component, x, y, z))
      ends.push_back({near, far, stiffness});
    if (may_move(link.component, x + (link.axis == 0 ? 1 : 0), y + (link.axis == 1 ? 1 : 0),
                 z + (link.axis == 2 ? 1 : 0)))
      ends.push_back({far, near, stiffness});
  }
  penalties_ = PenaltyRows(ends, operator_.slab_stride, operator_.component_stride, operator_.nodes[2]);
  for (PenaltyRows::Row& row : penalties_.rows()) {
    const auto component = static_cast<std::size_t>(row.at / operator_.component_stride);
    const std::int64_t in_component = row.at % operator_.component_stride;
    const auto number = static_cast<std::size_t>(in_component / operator_.row_stride);
    if (changed_rows_.empty() || changed_rows_.back().component != component ||
        changed_rows_.back().row != number) {
      // Rows come in the order of planes, components and rows, so those of one follow one another.
      ChangedRow& changed =
          changed_rows_.emplace_back(ChangedRow{component, number, inverse_rows_[component][number],
                                                PaddedArray(static_cast<std::size_t>(operator_.row_stride))});
      std::copy_n(changed.original, operator_.row_stride, changed.inverse.data());
      inverse_rows_[component][number] = changed.inverse.data();
    }
    float& inverse = changed_rows_.back().inverse.data()[in_component % operator_.row_stride];
    inverse = 1 / (1 / inverse + row.diagonal);
    row.inverse = inverse;
  }
}

List<PenaltyLink> BoxLevel::coarse_links(const List<PenaltyLink>& links) const {
  const auto& t = *transfer_;
  const int nx = operator_.nodes[0], ny = operator_.nodes[1];
  const int n[3] = {t[0].n_coarse(), t[1].n_coarse(), t[2].n_coarse()};
  List<PenaltyLink> coarse;
  for (const PenaltyLink& link : links) {
    const int at[3] = {static_cast<int>(link.node % nx), static_cast<int>(link.node / nx % ny),
                       static_cast<int>(link.node / nx / ny)};
    const auto own = static_cast<std::size_t>(link.axis);
    if (n[own] < 2)
      continue;
    int left[3];
    double right[3];
    for (std::size_t a = 0; a < 3; ++a) {
      left[a] = a == own ? t[a].interval(at[a]) : t[a].left(at[a]);
      right[a] = a == own ? 0 : t[a].right_weight(at[a]);
    }
    const double part = t[own].part_of_interval(at[own]), stiffness = part * part * link.stiffness;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = stiffness;
      for (std::size_t a = 0; a < 3; ++a)
        weight *= (corner >> a & 1) != 0 ? right[a] : 1 - right[a];
      if (weight > 0)
        coarse.push_back({link.component, link.axis,
                          left[0] + (corner & 1) +
                              std::int64_t{n[0]} * (left[1] + (corner >> 1 & 1) +
                                                    std::int64_t{n[1]} * (left[2] + (corner >> 2 & 1))),
                          weight});
    }
  }
  return merged(std::move(coarse));
}

} // namespace maille::deform
