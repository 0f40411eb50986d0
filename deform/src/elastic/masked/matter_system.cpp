#include "elastic/masked/matter_system.hpp"

#include "control/method.hpp"

#include <algorithm>

namespace maille::deform {

/// Calls visit(component, first place in the fields, first node, how many).
template<class Visit>
void MatterSystem::for_each_row(const Visit& visit) {
  constexpr std::size_t rows_per_item = 64;
  const MatterLevel& level = multigrid_.finest();
  const auto rows = level.rows().node_rows();
  team_.run(static_cast<int>((rows.size() + rows_per_item - 1) / rows_per_item), [&](int item, int) {
    const std::size_t first = static_cast<std::size_t>(item) * rows_per_item;
    for (const NodeRow& row : rows.subspan(first, std::min(rows_per_item, rows.size() - first)))
      for (std::size_t c = 0; c < 3; ++c)
        visit(c, static_cast<std::int64_t>(c) * level.component_stride() + row.slot,
              static_cast<std::size_t>(grid_.node(row.first)),
              std::min(row.blocks * MatterRows::block, grid_.nodes()[0] - row.first[0]));
  });
}

void MatterSystem::stiffen(const std::vector<StiffenedLink>& links) {
  const MatterLevel& level = multigrid_.finest();
  std::vector<SlotLink> of_slots;
  of_slots.reserve(links.size());
  for (const StiffenedLink& link : links) {
    const double scale = level.scale()[static_cast<std::size_t>(link.component)];
    of_slots.push_back({link.component, level.rows().slot(grid_.node_at(link.node)),
                        level.rows().slot(grid_.node_at(link.node + grid_.stride(link.axis))),
                        link.stiffness / (level.unit() * scale * scale)});
  }
  multigrid_.stiffen(of_slots);
}

void MatterSystem::take_in(const Displacement& residual) {
  const MatterLevel& level = multigrid_.finest();
  scale_ = largest_entry(residual) / level.unit();
  if (!(scale_ > 0))
    scale_ = 1;
  for_each_row([&](std::size_t c, std::int64_t at, std::size_t node, int n) {
    const double unit = level.unit() * level.scale()[c] * scale_;
    const double* const from = residual.component[c].data() + node;
    for (int i = 0; i < n; ++i)
      multigrid_.f.data()[at + i] = level.inverse()[at + i] > 0 ? static_cast<float>(from[i] / unit) : 0;
  });
}

void MatterSystem::take_over(const float* found, Displacement& direction) {
  const MatterLevel& level = multigrid_.finest();
  for_each_row([&](std::size_t c, std::int64_t at, std::size_t node, int n) {
    const double factor = scale_ / level.scale()[c];
    double* const to = direction.component[c].data() + node;
    for (int i = 0; i < n; ++i)
      to[i] = level.inverse()[at + i] > 0 ? factor * double{found[at + i]} : 0;
  });
}

int MatterSystem::find_direction(const Displacement& residual, int most, double reduction,
                                 const std::function<bool()>& must_stop, Displacement& direction) {
  take_in(residual);
  if (most > 1) {
    if (!gradients_)
      gradients_.emplace(multigrid_, team_);
    gradients_->restart();
    ReductionWatch watch(most, reduction, must_stop);
    conjugate_gradients(*gradients_, watch);
    take_over(gradients_->state(), direction);
    return watch.iterations();
  }
  multigrid_.precondition();
  take_over(multigrid_.u.data(), direction);
  return 1;
}

} // namespace maille::deform
