#include "relax/separable_level.hpp"

#include <algorithm>
#include <map>

namespace maille::deform {

namespace {

std::int64_t padded(int n) {
  return (n + line_of_floats - 1) / line_of_floats * line_of_floats;
}

/// In float32, with the zeros that the loops expect around it.
PaddedArray padded_copy(const std::vector<double>& values) {
  PaddedArray copy(static_cast<std::size_t>(padded(static_cast<int>(values.size()) + 1)));
  std::ranges::transform(values, copy.data(), [](double value) { return static_cast<float>(value); });
  return copy;
}

double at_or_zero(const std::vector<double>& values, int i) {
  return i >= 0 && i < static_cast<int>(values.size()) ? values[static_cast<std::size_t>(i)] : 0;
}

} // namespace

SeparableLevel::SeparableLevel(const Index3& nodes, std::array<std::vector<double>, 3> place,
                               LinkWeights weights, std::vector<FixedNode> fixed, Anchors anchors)
    : nodes_(nodes), place_(std::move(place)), weights_(std::move(weights)), fixed_(std::move(fixed)),
      anchors_(std::move(anchors)) {
  make_operator();
  lay_out_anchors();
  if (weights_.is_box())
    invert_diagonal_of_box();
  else
    invert_diagonal_of_body();
  operator_.inverse_diagonal = inverse_rows_.data();
  const auto size = static_cast<std::size_t>(operator_.slab_stride * nodes_[2]);
  u = PaddedArray(size);
  f = PaddedArray(size);
  r = PaddedArray(size);
}

void SeparableLevel::make_operator() {
  std::ranges::copy(nodes_, operator_.nodes);
  operator_.row_stride = padded(nodes_[0]);
  operator_.slab_stride = operator_.row_stride * nodes_[1];
  for (std::size_t a = 0; a < 3; ++a)
    if (weights_.is_box()) {
      axis_link_[a] = padded_copy(weights_.axis_link[a]);
      axis_mass_[a] = padded_copy(weights_.axis_mass[a]);
      operator_.axis_link[a] = axis_link_[a].data();
      operator_.axis_mass[a] = axis_mass_[a].data();
    } else {
      operator_.link[a] = weights_.link[a].data();
    }
}

Index3 SeparableLevel::node_at(std::int64_t node) const {
  const std::int64_t row = node / nodes_[0];
  return {static_cast<int>(node % nodes_[0]), static_cast<int>(row % nodes_[1]),
          static_cast<int>(row / nodes_[1])};
}

double SeparableLevel::weight(const Index3& at, int axis) const {
  const auto a = static_cast<std::size_t>(axis);
  if (at[a] < 0 || at[a] + 1 >= nodes_[a])
    return 0;
  if (!weights_.is_box())
    return double{weights_.link[a].data()[offset(at)]};
  double product = weights_.axis_link[a][static_cast<std::size_t>(at[a])];
  for (std::size_t b = 0; b < 3; ++b)
    if (b != a)
      product *= weights_.axis_mass[b][static_cast<std::size_t>(at[b])];
  return product;
}

double SeparableLevel::diagonal(const Index3& at) const {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    Index3 before = at;
    --before[static_cast<std::size_t>(axis)];
    sum += weight(at, axis) + weight(before, axis);
  }
  if (!anchors_.empty())
    if (const auto anchor = anchors_.find(node(at)); anchor != anchors_.end())
      sum += anchor->second;
  return sum;
}

void SeparableLevel::lay_out_anchors() {
  if (anchors_.empty())
    return;
  anchor_rows_.assign(static_cast<std::size_t>(nodes_[1] * nodes_[2]), nullptr);
  float* row = nullptr;
  std::int64_t row_of = -1;
  for (const auto& [node, value] : anchors_) {
    if (node / nodes_[0] != row_of) {
      row_of = node / nodes_[0];
      row_pool_.emplace_back(static_cast<std::size_t>(operator_.row_stride));
      row = row_pool_.back().data();
      anchor_rows_[static_cast<std::size_t>(row_of)] = row;
    }
    row[node % nodes_[0]] = static_cast<float>(value);
  }
  operator_.anchor = anchor_rows_.data();
}

bool SeparableLevel::may_move(const Index3& at) const {
  const float* const row = inverse_rows_[static_cast<std::size_t>(at[1] + nodes_[1] * at[2])];
  return row != nullptr && row[at[0]] > 0;
}

/// Rows of a box differ by two numbers an axis, the sum of the link factors at a node and its mass, of which
/// there are three or four kinds; so a few rows serve all, and those with fixed nodes have their own.
void SeparableLevel::invert_diagonal_of_box() {
  using Kind = std::pair<double, double>;
  const auto kind = [&](std::size_t axis, int i) {
    const auto& link = weights_.axis_link[axis];
    return Kind{at_or_zero(link, i - 1) + at_or_zero(link, i),
                weights_.axis_mass[axis][static_cast<std::size_t>(i)]};
  };
  struct Known {
    const float* free = nullptr;
    std::vector<int> fixed_places; ///< of the last row with fixed nodes
    const float* with_fixed = nullptr;
  };
  std::map<std::pair<Kind, Kind>, Known> known;
  const auto make_row = [&](int y, int z, const std::vector<int>& fixed_places) {
    PaddedArray row(static_cast<std::size_t>(operator_.row_stride));
    bool any = false;
    std::size_t next = 0;
    for (int x = 0; x < nodes_[0]; ++x) {
      if (next < fixed_places.size() && fixed_places[next] == x) {
        ++next;
        continue;
      }
      const double sum = diagonal({x, y, z});
      row.data()[x] = sum > 0 ? static_cast<float>(1 / sum) : 0.0F;
      any = any || sum > 0;
    }
    if (!any)
      return static_cast<const float*>(nullptr);
    row_pool_.push_back(std::move(row));
    return static_cast<const float*>(row_pool_.back().data());
  };
  auto next_fixed = fixed_.begin();
  std::vector<int> places;
  for (int z = 0; z < nodes_[2]; ++z)
    for (int y = 0; y < nodes_[1]; ++y) {
      const std::int64_t end = node({0, y, z}) + nodes_[0];
      places.clear();
      const bool is_anchored = !anchor_rows_.empty() && anchor_rows_[inverse_rows_.size()] != nullptr;
      for (; next_fixed != fixed_.end() && next_fixed->node < end; ++next_fixed)
        places.push_back(static_cast<int>(next_fixed->node - (end - nodes_[0])));
      if (is_anchored) {
        inverse_rows_.push_back(make_row(y, z, places));
        continue;
      }
      Known& rows = known[{kind(1, y), kind(2, z)}];
      if (places.empty() && rows.free == nullptr)
        rows.free = make_row(y, z, places);
      if (!places.empty() && rows.fixed_places != places) {
        rows.fixed_places = places;
        rows.with_fixed = make_row(y, z, places);
      }
      inverse_rows_.push_back(places.empty() ? rows.free : rows.with_fixed);
    }
}

void SeparableLevel::invert_diagonal_of_body() {
  inverse_ = PaddedArray(static_cast<std::size_t>(operator_.slab_stride * nodes_[2]));
  float* const inverse = inverse_.data();
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t step = a == 0 ? 1 : a == 1 ? operator_.row_stride : operator_.slab_stride;
    const float* const link = weights_.link[a].data();
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(inverse_.size()); ++i)
      inverse[i] += link[i] + (i >= step ? link[i - step] : 0.0F);
  }
  for (const auto& [node, value] : anchors_)
    inverse[offset(node_at(node))] += static_cast<float>(value);
  for (const FixedNode& fixed : fixed_)
    inverse[offset(node_at(fixed.node))] = 0;
  for (int z = 0; z < nodes_[2]; ++z)
    for (int y = 0; y < nodes_[1]; ++y) {
      float* const row = inverse + offset({0, y, z});
      bool any = false;
      for (int x = 0; x < nodes_[0]; ++x) {
        row[x] = row[x] > 0 ? 1 / row[x] : 0.0F;
        any = any || row[x] > 0;
      }
      inverse_rows_.push_back(any ? row : nullptr);
    }
}

/// Mean weight of the links along an axis.
double SeparableLevel::strength(int axis) const {
  const auto a = static_cast<std::size_t>(axis);
  if (nodes_[a] < 2)
    return 0;
  double sum = 0;
  if (weights_.is_box()) {
    sum = 1;
    for (std::size_t b = 0; b < 3; ++b) {
      const std::vector<double>& factor = b == a ? weights_.axis_link[b] : weights_.axis_mass[b];
      double total = 0;
      for (const double value : factor)
        total += value;
      sum *= total;
    }
    return sum / static_cast<double>(nodes_[a] - 1) * nodes_[a] / static_cast<double>(n_nodes());
  }
  std::int64_t links = 0;
  const PaddedArray& link = weights_.link[a];
  for (std::size_t i = 0; i < link.size(); ++i) {
    sum += double{link.data()[i]};
    links += link.data()[i] > 0 ? 1 : 0;
  }
  return links > 0 ? sum / static_cast<double>(links) : 0;
}

std::vector<bool> SeparableLevel::axes_to_coarsen() const {
  constexpr double share_of_strongest = 0.35; // theory.md, section 2
  double strongest = 0;
  std::array<double, 3> strengths{};
  for (int axis = 0; axis < 3; ++axis) {
    strengths[static_cast<std::size_t>(axis)] = strength(axis);
    strongest = std::max(strongest, strengths[static_cast<std::size_t>(axis)]);
  }
  std::vector<bool> chosen;
  for (std::size_t a = 0; a < 3; ++a)
    chosen.push_back(nodes_[a] > 1 && strengths[a] > 0 && strengths[a] >= share_of_strongest * strongest);
  return chosen;
}

std::unique_ptr<SeparableLevel> SeparableLevel::coarser() {
  const std::vector<bool> chosen = axes_to_coarsen();
  if (std::ranges::find(chosen, true) == chosen.end())
    return nullptr;
  transfer_ = std::make_unique<std::array<AxisCoarsening, 3>>(std::array<AxisCoarsening, 3>{
      AxisCoarsening(place_[0], chosen[0]), AxisCoarsening(place_[1], chosen[1]),
      AxisCoarsening(place_[2], chosen[2])});
  Index3 coarse_nodes{};
  std::array<std::vector<double>, 3> coarse_place;
  for (std::size_t a = 0; a < 3; ++a) {
    coarse_nodes[a] = (*transfer_)[a].n_coarse();
    coarse_place[a] = (*transfer_)[a].coarse_place();
  }
  std::vector<FixedNode> fixed = coarse_fixed(coarse_nodes);
  Anchors anchors = coarse_anchors(coarse_nodes, fixed);
  return std::make_unique<SeparableLevel>(coarse_nodes, std::move(coarse_place), coarse_weights(coarse_nodes),
                                          std::move(fixed), std::move(anchors));
}

/// Energies of linear displacements are kept, axis by axis: the weights of parallel links add up, shared out by
/// the hat functions, and those of links in a row as the square of the part of the way. That is the arithmetic
/// mean of the matter around a coarse link; where there is none it counts as nothing.
LinkWeights SeparableLevel::coarse_weights(const Index3& coarse_nodes) const {
  LinkWeights coarse;
  if (weights_.is_box()) {
    for (std::size_t a = 0; a < 3; ++a) {
      coarse.axis_link[a] = (*transfer_)[a].coarse_link(weights_.axis_link[a]);
      coarse.axis_mass[a] = (*transfer_)[a].coarse_mass(weights_.axis_mass[a]);
    }
    return coarse;
  }
  const std::int64_t row_stride = padded(coarse_nodes[0]), slab_stride = row_stride * coarse_nodes[1];
  for (std::size_t a = 0; a < 3; ++a) {
    PaddedArray& target = coarse.link[a];
    target = PaddedArray(static_cast<std::size_t>(slab_stride * coarse_nodes[2]));
    const float* const source = weights_.link[a].data();
    // Per fine node and axis: the coarse places that it adds to, and how much of it.
    const auto parts = [&](std::size_t axis, int i, int* where, float* weight) {
      const AxisCoarsening& t = (*transfer_)[axis];
      const auto right = static_cast<float>(t.right_weight(i));
      if (axis != a || !t.coarsens()) {
        where[0] = t.left(i);
        where[1] = t.left(i) + 1;
        weight[0] = 1 - right;
        weight[1] = right;
        return right == 0 ? 1 : 2;
      }
      if (i + 1 >= t.n_fine() || t.n_coarse() < 2)
        return 0;
      where[0] = std::min(t.left(i), t.n_coarse() - 2);
      const float end = t.left(i + 1) > where[0] ? 1.0F : static_cast<float>(t.right_weight(i + 1));
      weight[0] = (end - right) * (end - right);
      return 1;
    };
    int place[3][2];
    float weight[3][2];
    for (int z = 0; z < nodes_[2]; ++z) {
      const int nz = parts(2, z, place[2], weight[2]);
      for (int y = 0; y < nodes_[1]; ++y) {
        const int ny = parts(1, y, place[1], weight[1]);
        const float* const row = source + offset({0, y, z});
        for (int x = 0; x < nodes_[0]; ++x) {
          if (row[x] == 0)
            continue;
          const int nx = parts(0, x, place[0], weight[0]);
          for (int k = 0; k < nz; ++k)
            for (int j = 0; j < ny; ++j)
              for (int i = 0; i < nx; ++i)
                target.data()[place[0][i] + place[1][j] * row_stride + place[2][k] * slab_stride] +=
                    weight[2][k] * weight[1][j] * weight[0][i] * row[x];
        }
      }
    }
  }
  return coarse;
}

/// How much interpolation weight the nodes of matter have at a coarse node.
double SeparableLevel::matter_at(const Index3& coarse) const {
  const auto& t = *transfer_;
  double sum = 0;
  for (int k = 0; k < t[2].count(coarse[2]); ++k)
    for (int j = 0; j < t[1].count(coarse[1]); ++j)
      for (int i = 0; i < t[0].count(coarse[0]); ++i)
        if (weights_.is_box() ||
            diagonal({t[0].first(coarse[0]) + i, t[1].first(coarse[1]) + j, t[2].first(coarse[2]) + k}) > 0)
          sum += t[0].hat(coarse[0], i) * t[1].hat(coarse[1], j) * t[2].hat(coarse[2], k);
  return sum;
}

/// A coarse node is fixed if the fine one in its place is, or if fixed ones have as much weight around it as the
/// others: without the second half the vertices that hang in void beside a hold stay free (theory.md, 7b).
std::vector<FixedNode> SeparableLevel::coarse_fixed(const Index3& coarse_nodes) const {
  const auto& t = *transfer_;
  struct Around {
    float weight = 0, value = 0, own_value = 0;
    bool has_own = false;
  };
  const std::int64_t n = std::int64_t{1} * coarse_nodes[0] * coarse_nodes[1] * coarse_nodes[2];
  std::vector<Around> around(fixed_.empty() ? 0 : static_cast<std::size_t>(n));
  for (const FixedNode& fixed : fixed_) {
    const Index3 at = node_at(fixed.node);
    if (!weights_.is_box() && !(diagonal(at) > 0))
      continue; // not of the body
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      Index3 coarse{};
      for (std::size_t a = 0; a < 3; ++a) {
        const bool upper = (corner >> a & 1) != 0;
        const double right = t[a].right_weight(at[a]);
        weight *= upper ? right : 1 - right;
        coarse[a] = t[a].left(at[a]) + (upper ? 1 : 0);
      }
      if (weight == 0)
        continue;
      Around& target = around[static_cast<std::size_t>(
          coarse[0] + coarse_nodes[0] * (coarse[1] + std::int64_t{1} * coarse_nodes[1] * coarse[2]))];
      target.weight += static_cast<float>(weight);
      target.value += static_cast<float>(weight * fixed.value);
      if (weight == 1) {
        target.has_own = true;
        target.own_value = static_cast<float>(fixed.value);
      }
    }
  }
  std::vector<FixedNode> coarse;
  for (std::int64_t node = 0; node < static_cast<std::int64_t>(around.size()); ++node) {
    const Around& here = around[static_cast<std::size_t>(node)];
    if (here.weight == 0)
      continue;
    const std::int64_t row = node / coarse_nodes[0];
    const Index3 at{static_cast<int>(node % coarse_nodes[0]), static_cast<int>(row % coarse_nodes[1]),
                    static_cast<int>(row / coarse_nodes[1])};
    if (here.has_own)
      coarse.push_back({node, double{here.own_value}});
    else if (2 * double{here.weight} >= matter_at(at))
      coarse.push_back({node, double{here.value / here.weight}});
  }
  return coarse;
}

/// Cut off at fixed nodes, a link from a free node i to a fixed one costs w (P u)_i^2 <= w s_i sum_I P_iI u_I^2
/// with s_i the sum of P_iI over free coarse I (Cauchy-Schwarz); the coarse links count it, and the links between
/// fixed nodes, as if nothing were cut. An anchor is the difference, where it is positive.
Anchors SeparableLevel::coarse_anchors(const Index3& coarse_nodes,
                                       const std::vector<FixedNode>& coarse_fixed) const {
  const auto& t = *transfer_;
  std::vector<bool> is_fixed(static_cast<std::size_t>(n_nodes()), false);
  for (const FixedNode& fixed : fixed_)
    is_fixed[static_cast<std::size_t>(fixed.node)] = true;
  const auto n_coarse =
      static_cast<std::size_t>(std::int64_t{1} * coarse_nodes[0] * coarse_nodes[1] * coarse_nodes[2]);
  std::vector<bool> is_coarse_fixed(n_coarse, false);
  for (const FixedNode& fixed : coarse_fixed)
    is_coarse_fixed[static_cast<std::size_t>(fixed.node)] = true;
  std::vector<double> sum(n_coarse, 0);
  const auto coarse_node = [&](const Index3& at) {
    return static_cast<std::size_t>(at[0] +
                                    coarse_nodes[0] * (at[1] + std::int64_t{1} * coarse_nodes[1] * at[2]));
  };

  struct Parents {
    std::array<std::size_t, 8> node{};
    std::array<double, 8> weight{};
    int n = 0;
    double free = 0; ///< sum of the weights of free parents
  };
  const auto parents_of = [&](const Index3& at) {
    Parents p;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      Index3 coarse{};
      for (std::size_t a = 0; a < 3; ++a) {
        const bool upper = (corner >> a & 1) != 0;
        const double right = t[a].right_weight(at[a]);
        weight *= upper ? right : 1 - right;
        coarse[a] = t[a].left(at[a]) + (upper ? 1 : 0);
      }
      if (weight == 0)
        continue;
      const std::size_t node = coarse_node(coarse);
      if (is_coarse_fixed[node])
        continue;
      p.node[static_cast<std::size_t>(p.n)] = node;
      p.weight[static_cast<std::size_t>(p.n++)] = weight;
      p.free += weight;
    }
    return p;
  };
  const auto tie = [&](const Index3& at, double weight) {
    const Parents p = parents_of(at);
    for (std::size_t i = 0; i < static_cast<std::size_t>(p.n); ++i)
      sum[p.node[i]] += weight * p.weight[i] * p.free;
  };
  // What the coarse links count of a fine one. Between two free ends it is nothing to rely on: they may move alike.
  const auto count_off = [&](const Index3& near, std::size_t a, double weight) {
    if (t[a].n_coarse() < 2)
      return;
    const int far = near[a] + 1;
    const int interval = std::min(t[a].left(near[a]), t[a].n_coarse() - 2);
    const double end = t[a].left(far) > interval ? 1 : t[a].right_weight(far);
    const double part = end - t[a].right_weight(near[a]);
    for (int corner = 0; corner < 8; ++corner) {
      if ((corner >> a & 1) != 0)
        continue;
      double share = weight * part * part;
      Index3 coarse{};
      for (std::size_t b = 0; b < 3; ++b) {
        const bool upper = (corner >> b & 1) != 0;
        const double right = t[b].right_weight(near[b]);
        share *= b == a ? 1 : upper ? right : 1 - right;
        coarse[b] = b == a ? interval : t[b].left(near[b]) + (upper ? 1 : 0);
      }
      if (share == 0)
        continue;
      const std::size_t first = coarse_node(coarse);
      ++coarse[a];
      const std::size_t second = coarse_node(coarse);
      if (is_coarse_fixed[first] != is_coarse_fixed[second])
        sum[is_coarse_fixed[first] ? second : first] -= share;
    }
  };
  for (const FixedNode& fixed : fixed_) {
    const Index3 at = node_at(fixed.node);
    for (std::size_t a = 0; a < 3; ++a)
      for (const int side : {-1, 1}) {
        Index3 near = at, other = at;
        other[a] += side;
        if (side < 0)
          near = other;
        const double w = weight(near, static_cast<int>(a));
        if (w == 0)
          continue;
        const bool other_is_fixed = is_fixed[static_cast<std::size_t>(node(other))];
        if (!other_is_fixed)
          tie(other, w);
        if (!other_is_fixed || side > 0) // links between fixed nodes once
          count_off(near, a, w);
      }
  }
  for (double& value : sum)
    value = std::max(value, 0.0);
  for (const auto& [node, value] : anchors_)
    if (!is_fixed[static_cast<std::size_t>(node)])
      tie(node_at(node), value);
  Anchors anchors;
  for (std::size_t i = 0; i < n_coarse; ++i)
    if (sum[i] > 0)
      anchors.emplace_hint(anchors.end(), static_cast<std::int64_t>(i), sum[i]);
  return anchors;
}

void SeparableLevel::place_fixed(float* field) const {
  for (const FixedNode& fixed : fixed_)
    field[offset(node_at(fixed.node))] = static_cast<float>(fixed.value);
}

void SeparableLevel::clear(PaddedArray& field) const {
  std::fill_n(field.data(), field.size(), 0.0F);
}

std::int64_t SeparableLevel::bytes() const {
  std::size_t sum = u.bytes() + f.bytes() + r.bytes() + inverse_.bytes() +
                    inverse_rows_.size() * sizeof(const float*) + fixed_.size() * sizeof(FixedNode);
  for (std::size_t a = 0; a < 3; ++a)
    sum += weights_.link[a].bytes() + axis_link_[a].bytes() + axis_mass_[a].bytes();
  for (const PaddedArray& row : row_pool_)
    sum += row.bytes();
  return static_cast<std::int64_t>(sum);
}

} // namespace maille::deform
