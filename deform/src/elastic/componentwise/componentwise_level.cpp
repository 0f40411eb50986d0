#include "elastic/componentwise/componentwise_level.hpp"

#include "elastic/componentwise/componentwise_coarsening.hpp"
#include "elastic/componentwise/componentwise_multigrid.hpp"

namespace maille::deform {

namespace {

/// Converts to float32, with the zeros around it that the loops read.
PaddedArray padded_copy(const std::vector<double>& values) {
  PaddedArray copy(static_cast<std::size_t>(padded_row(static_cast<int>(values.size()) + 1)));
  std::ranges::transform(values, copy.data(), [](double value) { return static_cast<float>(value); });
  return copy;
}

/// Memory for the transfers of the calling thread.
float* scratch_of(const ComponentwiseOperator& fine) {
  return scratch_of_thread<float, ComponentwiseLevel>(
      static_cast<std::size_t>(2 * fine.row_stride + 6 * line_of_floats));
}

double at_or_zero(const std::vector<double>& values, int i) {
  return i >= 0 && i < static_cast<int>(values.size()) ? values[i] : 0;
}

} // namespace

ComponentwiseLevel::ComponentwiseLevel(const Index3& nodes, std::array<std::vector<double>, 3> place,
                                       LinkWeights weights, List<FixedNode> fixed, Anchors anchors)
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

void ComponentwiseLevel::make_operator() {
  std::ranges::copy(nodes_, operator_.nodes);
  operator_.row_stride = padded_row(nodes_[0]);
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

Index3 ComponentwiseLevel::node_at(std::int64_t node) const {
  const std::int64_t row = node / nodes_[0];
  return {static_cast<int>(node % nodes_[0]), static_cast<int>(row % nodes_[1]),
          static_cast<int>(row / nodes_[1])};
}

double ComponentwiseLevel::weight(const Index3& at, int axis) const {
  const auto a = static_cast<std::size_t>(axis);
  if (at[a] < 0 || at[a] + 1 >= nodes_[a])
    return 0;
  if (!weights_.is_box())
    return double{weights_.link[a].data()[offset(at)]};
  double product = weights_.axis_link[a][at[a]];
  for (std::size_t b = 0; b < 3; ++b)
    if (b != a)
      product *= weights_.axis_mass[b][at[b]];
  return product;
}

double ComponentwiseLevel::diagonal(const Index3& at) const {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    Index3 before = at;
    --before[axis];
    sum += weight(at, axis) + weight(before, axis);
  }
  if (!anchors_.empty())
    if (const auto anchor = anchors_.find(node(at)); anchor != anchors_.end())
      sum += anchor->second;
  return sum;
}

void ComponentwiseLevel::lay_out_anchors() {
  if (anchors_.empty())
    return;
  anchor_rows_.assign(nodes_[1] * nodes_[2], nullptr);
  float* row = nullptr;
  std::int64_t row_of = -1;
  for (const auto& [node, value] : anchors_) {
    if (node / nodes_[0] != row_of) {
      row_of = node / nodes_[0];
      row_pool_.emplace_back(static_cast<std::size_t>(operator_.row_stride));
      row = row_pool_.back().data();
      anchor_rows_[row_of] = row;
    }
    row[node % nodes_[0]] = static_cast<float>(value);
  }
  operator_.anchor = anchor_rows_.data();
}

bool ComponentwiseLevel::may_move(const Index3& at) const {
  const float* const row = inverse_rows_[at[1] + nodes_[1] * at[2]];
  return row != nullptr && row[at[0]] > 0;
}

/// Inverse diagonals of a box. Rows differ by the sum of link factors and the mass along y and z, which have
/// three or four values each; so few distinct rows are stored. Rows with fixed nodes have their own.
void ComponentwiseLevel::invert_diagonal_of_box() {
  using Kind = std::pair<double, double>;
  const auto kind = [&](std::size_t axis, int i) {
    const auto& link = weights_.axis_link[axis];
    return Kind{at_or_zero(link, i - 1) + at_or_zero(link, i), weights_.axis_mass[axis][i]};
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

void ComponentwiseLevel::invert_diagonal_of_body() {
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
double ComponentwiseLevel::strength(int axis) const {
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

std::vector<bool> ComponentwiseLevel::axes_to_coarsen() const {
  double strongest = 0;
  std::array<double, 3> strengths{};
  for (int axis = 0; axis < 3; ++axis) {
    strengths[axis] = strength(axis);
    strongest = std::max(strongest, strengths[axis]);
  }
  std::vector<bool> chosen;
  for (std::size_t a = 0; a < 3; ++a)
    chosen.push_back(nodes_[a] > 1 && strengths[a] > 0 && strengths[a] >= share_of_strongest * strongest);
  return chosen;
}

std::unique_ptr<ComponentwiseLevel> ComponentwiseLevel::coarser() {
  const std::vector<bool> chosen = axes_to_coarsen();
  if (std::ranges::find(chosen, true) == chosen.end())
    return nullptr;
  transfer_ = std::make_unique<std::array<AxisCoarsening, 3>>(std::array<AxisCoarsening, 3>{
      AxisCoarsening(place_[0], chosen[0]), AxisCoarsening(place_[1], chosen[1]),
      AxisCoarsening(place_[2], chosen[2])});
  const GridPair grids(*this);
  std::array<std::vector<double>, 3> coarse_place;
  for (std::size_t a = 0; a < 3; ++a)
    coarse_place[a] = (*transfer_)[a].coarse_place();
  List<FixedNode> fixed = coarse_fixed(grids);
  Anchors anchors = coarse_anchors(grids, fixed);
  return std::make_unique<ComponentwiseLevel>(grids.coarse_nodes(), std::move(coarse_place),
                                              coarse_weights(grids), std::move(fixed), std::move(anchors));
}

void ComponentwiseLevel::place_fixed(float* field) const {
  for (const FixedNode& fixed : fixed_)
    field[offset(node_at(fixed.node))] = static_cast<float>(fixed.value);
}

void ComponentwiseLevel::clear(PaddedArray& field) const {
  std::fill_n(field.data(), field.size(), 0.0F);
}

/// Two Jacobi steps that damp the modes which the coarser level cannot represent: Chebyshev's weights for
/// eigenvalues 0.5 to 2 of the operator over its diagonal, which has none above 2 (Gershgorin).
const std::vector<float>& ComponentwiseLevel::relaxation() const {
  static const std::vector<float> weights{0.5617F, 1.3895F};
  return weights;
}

void ComponentwiseLevel::restrict_to(const ComponentwiseLevel& coarser, int z, const float* from,
                                     float* to) const {
  restrict_plane(coarser.operator_, operator_, views(*transfer_).data(), z, from, to, scratch_of(operator_));
}

void ComponentwiseLevel::prolong_from(const ComponentwiseLevel& coarser, int z, const float* from,
                                      bool replaces, float* to) const {
  prolong_plane(coarser.operator_, operator_, views(*transfer_).data(), z, from, replaces, to,
                scratch_of(operator_));
}

CoarsestSolve::Unknowns ComponentwiseLevel::unknowns() const {
  CoarsestSolve::Unknowns unknowns;
  unknowns.begin_layer();
  for (std::int64_t node = 0; node < n_nodes(); ++node)
    if (const Index3 at = node_at(node); may_move(at))
      unknowns.place.push_back(offset(at));
  unknowns.begin_layer();
  return unknowns;
}

void ComponentwiseLevel::for_each_entry(const CoarsestSolve::Unknowns& unknowns,
                                        const CoarsestSolve::Visit& visit) const {
  const List<std::int32_t> number = unknowns.numbers(u.size());
  const auto number_at = [&](const Index3& at) { return number[offset(at)]; };
  for (std::int64_t node = 0; node < n_nodes(); ++node) {
    const Index3 at = node_at(node);
    if (number_at(at) < 0)
      continue;
    const auto row = static_cast<std::size_t>(number_at(at));
    visit(row, row, diagonal(at));
    for (std::size_t a = 0; a < 3; ++a) {
      Index3 next = at;
      if (++next[a] >= nodes_[a] || number_at(next) < 0)
        continue;
      const auto column = static_cast<std::size_t>(number_at(next));
      const double stiffness = weight(at, static_cast<int>(a));
      visit(row, column, -stiffness);
      visit(column, row, -stiffness);
    }
  }
}

void ComponentwiseMultigrid::solve_from_coarsest(bool has_forces) {
  for (std::size_t i = 0; i < n_levels(); ++i) {
    ComponentwiseLevel& here = level(i);
    here.clear(here.u);
    here.place_fixed(here.u.data());
    if (i == 0)
      continue;
    ComponentwiseLevel& finer = level(i - 1);
    if (has_forces)
      team_for(finer).run(here.n_planes(),
                          [&](int z, int) { finer.restrict_to(here, z, finer.f.data(), here.f.data()); });
    else
      here.clear(here.f);
  }
  ComponentwiseLevel& last = level(n_levels() - 1);
  for (int z = 0; z < last.n_planes(); ++z)
    last.find_residual(z);
  coarsest().add_solution(last.r.data(), last.u.data());
  for (std::size_t i = n_levels() - 1; i-- > 0;)
    cycle(i, {.from_coarser = true});
}

} // namespace maille::deform
