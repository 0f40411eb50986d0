#include "elastic/corotated/repair_in_blocks.hpp"

#include "maille/scene/block_frames.hpp"
#include "maille/scene/nearest_rotation.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

/// Of a link's range, at either end.
constexpr double narrowed = 0.01;
constexpr int sweeps_per_frames = 8, most_frames = 60;

struct BlockLink {
  std::int64_t tail = 0, head = 0;
  std::size_t axis = 0;
  Index3 at{};
  Vec3 low{}, high{};
  Eigen::Matrix3d frame;
};

class BlockRepair {
public:
  BlockRepair(const Scene& scene, const LinkLimits& limits, const std::vector<Prescribed>& prescribed);
  RepairInBlocks run(const LinkLimits& limits, Displacement& u);

private:
  void find_frames(const Displacement& u);
  void bring_within(const BlockLink& link, Displacement& u) const;
  std::size_t d() const { return static_cast<std::size_t>(scene_.dimension()); }

  const Scene& scene_;
  std::vector<BlockLink> links_;
  std::vector<std::uint8_t> fixed_; ///< per node, bit b for component b
};

BlockRepair::BlockRepair(const Scene& scene, const LinkLimits& limits,
                         const std::vector<Prescribed>& prescribed)
    : scene_(scene), fixed_(static_cast<std::size_t>(scene.specimen.grid.n_nodes()), 0) {
  for (const Prescribed& p : prescribed) {
    std::uint8_t& bits = fixed_[static_cast<std::size_t>(p.node)];
    bits = static_cast<std::uint8_t>(bits | 1 << p.component);
  }
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    for (std::size_t axis = 0; axis < d(); ++axis) {
      const Index3 at = grid.node_at(node);
      if (at[axis] + 1 >= grid.nodes()[axis])
        continue;
      const LinkBounds bounds = limits.bounds(at, static_cast<int>(axis));
      if (bounds.exists)
        links_.push_back({node, node + grid.stride(static_cast<int>(axis)), axis, at, bounds.low, bounds.high,
                          Eigen::Matrix3d::Identity()});
    }
}

void BlockRepair::find_frames(const Displacement& u) {
  const std::vector<Eigen::Quaterniond> rotation = block_rotations(scene_, u);
  for (BlockLink& link : links_) {
    MeanRotation mean;
    scene_.specimen.for_each_cell_at_link(link.at, static_cast<int>(link.axis), [&](std::int64_t cell) {
      mean.add(rotation[static_cast<std::size_t>(cell)]);
    });
    link.frame = mean.value().toRotationMatrix();
  }
}

void BlockRepair::bring_within(const BlockLink& link, Displacement& u) const {
  const Eigen::Vector3d at_rest =
      scene_.specimen.grid.spacing()[link.axis] * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(link.axis));
  const auto tail = static_cast<std::size_t>(link.tail), head = static_cast<std::size_t>(link.head);
  Eigen::Vector3d now = at_rest;
  for (std::size_t b = 0; b < d(); ++b)
    now[static_cast<Eigen::Index>(b)] += u.component[b][head] - u.component[b][tail];
  const Eigen::Vector3d change = link.frame.transpose() * now - at_rest;
  Eigen::Vector3d missing = Eigen::Vector3d::Zero();
  for (std::size_t b = 0; b < d(); ++b) {
    const auto i = static_cast<Eigen::Index>(b);
    const double margin = narrowed * (link.high[b] - link.low[b]);
    missing[i] = std::clamp(change[i], link.low[b] + margin, link.high[b] - margin) - change[i];
  }
  if (missing.isZero(0))
    return;
  const Eigen::Vector3d move = link.frame * missing;
  for (std::size_t b = 0; b < d(); ++b) {
    const bool is_tail_free = (fixed_[tail] >> b & 1) == 0, is_head_free = (fixed_[head] >> b & 1) == 0;
    const double step = move[static_cast<Eigen::Index>(b)] * (is_tail_free && is_head_free ? 0.5 : 1);
    u.component[b][tail] -= is_tail_free ? step : 0;
    u.component[b][head] += is_head_free ? step : 0;
  }
}

RepairInBlocks BlockRepair::run(const LinkLimits& limits, Displacement& u) {
  RepairInBlocks done;
  done.bytes = static_cast<std::int64_t>(links_.capacity() * sizeof(BlockLink) + fixed_.size());
  for (int frames = 0; frames < most_frames; ++frames) {
    done.is_legal = largest_violation_in_blocks(scene_, limits, u) <= rounding_in_blocks;
    if (done.is_legal)
      break;
    find_frames(u);
    for (int sweep = 0; sweep < sweeps_per_frames; sweep += 2) {
      for (const BlockLink& link : links_)
        bring_within(link, u);
      for (auto link = links_.rbegin(); link != links_.rend(); ++link)
        bring_within(*link, u);
    }
    done.sweeps += sweeps_per_frames;
  }
  return done;
}

} // namespace

RepairInBlocks repair_in_blocks(const Scene& scene, const LinkLimits& limits,
                                const std::vector<Prescribed>& prescribed, Displacement& u) {
  return BlockRepair(scene, limits, prescribed).run(limits, u);
}

} // namespace maille::deform
