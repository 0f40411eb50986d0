#include "elastic/componentwise/componentwise_coarsening.hpp"

#include "elastic/model/fixed_mask.hpp"

#include <algorithm>

namespace maille::deform {

GridPair::GridPair(const ComponentwiseLevel& fine) : fine_(fine) {
  for (std::size_t a = 0; a < 3; ++a)
    coarse_nodes_[a] = axis(a).n_coarse();
}

Index3 GridPair::coarse_node_at(std::int64_t node) const {
  const std::int64_t row = node / coarse_nodes_[0];
  return {static_cast<int>(node % coarse_nodes_[0]), static_cast<int>(row % coarse_nodes_[1]),
          static_cast<int>(row / coarse_nodes_[1])};
}

GridPair::Parents GridPair::parents(const Index3& fine) const {
  std::array<std::array<double, 2>, 3> weight{};
  Index3 left{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double right = axis(a).right_weight(fine[a]);
    weight[a] = {1 - right, right};
    left[a] = axis(a).left(fine[a]);
  }
  // Asked for every link of every fixed node: corners without weight are not looked at.
  Parents found;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2 && weight[2][k] != 0; ++j)
      for (int i = 0; i < 2 && weight[1][j] != 0; ++i) {
        const double product = weight[0][i] * weight[1][j] * weight[2][k];
        if (product == 0)
          continue;
        found.node[found.n] = coarse_node({left[0] + i, left[1] + j, left[2] + k});
        found.weight[found.n++] = product;
      }
  return found;
}

double GridPair::matter_at(const Index3& coarse) const {
  double sum = 0;
  for (int k = 0; k < axis(2).count(coarse[2]); ++k)
    for (int j = 0; j < axis(1).count(coarse[1]); ++j)
      for (int i = 0; i < axis(0).count(coarse[0]); ++i)
        if (fine_.weights().is_box() ||
            fine_.diagonal({axis(0).first(coarse[0]) + i, axis(1).first(coarse[1]) + j,
                            axis(2).first(coarse[2]) + k}) > 0)
          sum += axis(0).hat(coarse[0], i) * axis(1).hat(coarse[1], j) * axis(2).hat(coarse[2], k);
  return sum;
}

namespace {

/// The share of a fine link along one axis: at most two coarse positions.
struct Parts {
  std::array<int, 2> place{};
  std::array<float, 2> weight{};
  std::size_t n = 0;
};

/// Along the link's own axis the square of its share of the length; across it the hat functions.
Parts parts_of_link(const AxisCoarsening& axis, int i, bool is_own) {
  const auto right = static_cast<float>(axis.right_weight(i));
  if (!is_own || !axis.coarsens())
    return {{axis.left(i), axis.left(i) + 1}, {1 - right, right}, right == 0 ? 1U : 2U};
  if (i + 1 >= axis.n_fine() || axis.n_coarse() < 2)
    return {};
  const auto part = static_cast<float>(axis.part_of_interval(i));
  return {{axis.interval(i), 0}, {part * part, 0}, 1};
}

/// The weights of the coarse links along one axis of a body with weights per link.
PaddedArray coarse_links_along(const GridPair& grids, std::size_t a) {
  const ComponentwiseLevel& fine = grids.fine();
  const Index3& nodes = fine.nodes();
  const Index3& coarse_nodes = grids.coarse_nodes();
  const std::int64_t row_stride = padded_row(coarse_nodes[0]), slab_stride = row_stride * coarse_nodes[1];
  PaddedArray target(static_cast<std::size_t>(slab_stride * coarse_nodes[2]));
  std::vector<float> reduced(coarse_nodes[0]); // along x, of one row
  std::vector<Parts> along_x;
  for (int x = 0; x < nodes[0]; ++x)
    along_x.push_back(parts_of_link(grids.axis(0), x, a == 0));
  for (int z = 0; z < nodes[2]; ++z) {
    const Parts in_z = parts_of_link(grids.axis(2), z, a == 2);
    for (int y = 0; y < nodes[1]; ++y) {
      const Parts in_y = parts_of_link(grids.axis(1), y, a == 1);
      const float* const row = fine.A().link[a] + fine.offset({0, y, z});
      std::ranges::fill(reduced, 0.0F);
      for (int x = 0; x < nodes[0]; ++x)
        for (std::size_t i = 0; i < along_x[x].n; ++i)
          reduced[along_x[x].place[i]] += along_x[x].weight[i] * row[x];
      for (std::size_t k = 0; k < in_z.n; ++k)
        for (std::size_t j = 0; j < in_y.n; ++j) {
          float* const to = target.data() + in_y.place[j] * row_stride + in_z.place[k] * slab_stride;
          const float weight = in_z.weight[k] * in_y.weight[j];
          for (std::size_t i = 0; i < reduced.size(); ++i)
            to[i] += weight * reduced[i];
        }
    }
  }
  return target;
}

/// Collects anchors at free coarse nodes.
class Anchoring {
public:
  Anchoring(const GridPair& grids, const List<FixedNode>& coarse_fixed)
      : grids_(grids), fixed_(mask_of(grids.fine().n_nodes(), grids.fine().fixed())),
        coarse_fixed_(mask_of(grids.n_coarse(), coarse_fixed)),
        sum_(static_cast<std::size_t>(grids.n_coarse())) {}

  Anchors collect() {
    for (const FixedNode& fixed : grids_.fine().fixed())
      visit_links_of(grids_.fine().node_at(fixed.node));
    for (double& value : sum_)
      value = std::max(value, 0.0);
    for (const auto& [node, value] : grids_.fine().anchors())
      if (!fixed_(0, node))
        tie(grids_.fine().node_at(node), value);
    Anchors anchors;
    for (std::size_t i = 0; i < sum_.size(); ++i)
      if (sum_[i] > 0)
        anchors.emplace_hint(anchors.end(), static_cast<std::int64_t>(i), sum_[i]);
    return anchors;
  }

private:
  /// Marks nodes, for one component.
  static FixedMask mask_of(std::int64_t n_nodes, const List<FixedNode>& nodes) {
    FixedMask mask(static_cast<std::size_t>(n_nodes));
    for (const FixedNode& fixed : nodes)
      mask.fix(fixed.node, 1);
    return mask;
  }

  void visit_links_of(const Index3& fixed) {
    const ComponentwiseLevel& fine = grids_.fine();
    for (std::size_t a = 0; a < 3; ++a)
      for (const int side : {-1, 1}) {
        Index3 near = fixed, other = fixed;
        other[a] += side;
        if (side < 0)
          near = other;
        const double weight = fine.weight(near, static_cast<int>(a));
        if (weight == 0)
          continue;
        const bool other_is_fixed = fixed_(0, fine.node(other));
        if (!other_is_fixed)
          tie(other, weight);
        if (!other_is_fixed || side > 0) // links between fixed nodes once
          count_off(near, a, weight);
      }
  }

  void tie(const Index3& free, double weight) {
    const GridPair::Parents parents = grids_.parents(free);
    double of_free_ones = 0;
    for (std::size_t i = 0; i < parents.n; ++i)
      of_free_ones += coarse_fixed_(0, parents.node[i]) ? 0 : parents.weight[i];
    for (std::size_t i = 0; i < parents.n; ++i)
      if (!coarse_fixed_(0, parents.node[i]))
        sum_[parents.node[i]] += weight * parents.weight[i] * of_free_ones;
  }

  /// The part of a fine link's energy that coarse links count. Between two free ends it is not reliable,
  /// because they may move alike.
  void count_off(const Index3& near, std::size_t a, double weight) {
    const AxisCoarsening& along = grids_.axis(a);
    if (along.n_coarse() < 2)
      return;
    const double part = along.part_of_interval(near[a]);
    // The parents of the node in the place of the interval's first end, and their neighbours along the axis.
    Index3 first = near;
    first[a] = along.fine_place(along.interval(near[a]));
    const GridPair::Parents parents = grids_.parents(first);
    for (std::size_t i = 0; i < parents.n; ++i) {
      const auto one = static_cast<std::size_t>(parents.node[i]),
                 two = one + static_cast<std::size_t>(grids_.coarse_step(a));
      if (coarse_fixed_(0, one) != coarse_fixed_(0, two))
        sum_[coarse_fixed_(0, one) ? two : one] -= weight * part * part * parents.weight[i];
    }
  }

  const GridPair& grids_;
  FixedMask fixed_, coarse_fixed_;
  AlignedArray<double> sum_;
};

} // namespace

LinkWeights coarse_weights(const GridPair& grids) {
  const LinkWeights& fine = grids.fine().weights();
  LinkWeights coarse;
  for (std::size_t a = 0; a < 3; ++a)
    if (fine.is_box()) {
      coarse.axis_link[a] = grids.axis(a).coarse_link(fine.axis_link[a]);
      coarse.axis_mass[a] = grids.axis(a).coarse_mass(fine.axis_mass[a]);
    } else {
      coarse.link[a] = coarse_links_along(grids, a);
    }
  return coarse;
}

List<FixedNode> coarse_fixed(const GridPair& grids) {
  struct Around {
    std::int64_t node = 0;
    double weight = 0, value = 0, own_value = 0;
    bool has_own = false;
  };
  const ComponentwiseLevel& fine = grids.fine();
  std::vector<Around> around; // few, as a rule
  AlignedArray<std::int32_t> place(fine.fixed().empty() ? 0 : static_cast<std::size_t>(grids.n_coarse()));
  const auto at_node = [&](std::int64_t node) -> Around& {
    std::int32_t& number = place[node];
    if (number == 0) {
      around.push_back({node});
      number = static_cast<std::int32_t>(around.size());
    }
    return around[number - 1];
  };
  for (const FixedNode& fixed : fine.fixed()) {
    const Index3 at = fine.node_at(fixed.node);
    if (!fine.weights().is_box() && !(fine.diagonal(at) > 0))
      continue; // not of the body
    const GridPair::Parents parents = grids.parents(at);
    for (std::size_t i = 0; i < parents.n; ++i) {
      Around& target = at_node(parents.node[i]);
      target.weight += parents.weight[i];
      target.value += parents.weight[i] * fixed.value;
      if (parents.weight[i] == 1) {
        target.has_own = true;
        target.own_value = fixed.value;
      }
    }
  }
  std::ranges::sort(around, {}, &Around::node);
  List<FixedNode> coarse;
  for (const Around& here : around)
    if (here.has_own)
      coarse.push_back({here.node, here.own_value});
    else if (here.weight > 0 && 2 * here.weight >= grids.matter_at(grids.coarse_node_at(here.node)))
      coarse.push_back({here.node, here.value / here.weight});
  return coarse;
}

Anchors coarse_anchors(const GridPair& grids, const List<FixedNode>& coarse_fixed) {
  return Anchoring(grids, coarse_fixed).collect();
}

} // namespace maille::deform
