/// The coarsest level of a box: which level it is, and its matrix for the direct solve.
#include "elastic/box/box_level.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

constexpr std::int64_t most_nodes_inverted = 36;

int longest_axis(const Index3& nodes) {
  return static_cast<int>(std::ranges::max_element(nodes) - nodes.begin());
}

std::int64_t n_nodes_of(const Index3& nodes) {
  return std::int64_t{1} * nodes[0] * nodes[1] * nodes[2];
}

/// Rows of the factor of a layer.
double unknowns_in_layer(const Index3& nodes) {
  return 3 * static_cast<double>(n_nodes_of(nodes)) / nodes[longest_axis(nodes)];
}

bool is_thin_lattice(const Index3& nodes, const Vec3& spacing, std::int64_t n_finest) {
  const auto thin = static_cast<std::size_t>(std::ranges::min_element(nodes) - nodes.begin()),
             along = static_cast<std::size_t>(longest_axis(nodes));
  const double in_layer = unknowns_in_layer(nodes);
  // Affordable multiplications of the factors: more where cells are flat, because relaxation is poor there.
  const double most =
      std::max(spacing[along] > 2.5 * spacing[thin] ? 2e10 : 1e9, 2e4 * static_cast<double>(n_finest));
  return nodes[thin] == 2 && 3 * nodes[along] * in_layer * in_layer * in_layer <= most;
}

} // namespace

bool BoxLevel::is_small() const {
  return n_nodes() <= most_nodes_inverted;
}

bool BoxLevel::is_thin(std::int64_t n_finest) const {
  return is_thin_lattice(nodes(), {spacing(0), spacing(1), spacing(2)}, n_finest);
}

std::int64_t box_coarsest_bytes(const BoxLevel::Stiffness& C, const Grid& grid) {
  Index3 nodes = grid.nodes();
  Vec3 spacing = grid.spacing();
  while (n_nodes_of(nodes) > most_nodes_inverted) {
    if (is_thin_lattice(nodes, spacing, grid.n_nodes())) {
      const double in_layer = unknowns_in_layer(nodes);
      return 3 * 24 * n_nodes_of(nodes) +
             static_cast<std::int64_t>(2 * sizeof(double) * in_layer *
                                       static_cast<double>(3 * n_nodes_of(nodes)));
    }
    const auto coarsens = axes_to_coarsen(nodes, BoxCoefficients(C, spacing, 1, 0));
    if (std::ranges::find(coarsens, true) == coarsens.end())
      break;
    for (std::size_t a = 0; a < 3; ++a)
      if (coarsens[a]) {
        nodes[a] = (nodes[a] - 1) / 2 + 1;
        spacing[a] *= 2;
      }
  }
  return 0; // an inverse of 108 rows at most
}

/// In layers along the longest axis where the level is not small.
CoarsestSolve::Unknowns BoxLevel::unknowns() const {
  const Index3 n = nodes();
  const auto along = static_cast<std::size_t>(longest_axis(n));
  const int layers = is_small() ? 1 : n[along];
  CoarsestSolve::Unknowns unknowns;
  for (int layer = 0; layer < layers; ++layer) {
    unknowns.begin_layer();
    for (int c = 0; c < 3; ++c)
      for (int z = 0; z < n[2]; ++z)
        for (int y = 0; y < n[1]; ++y)
          for (int x = 0; x < n[0]; ++x)
            if ((layers == 1 || Index3{x, y, z}[along] == layer) && may_move(c, x, y, z))
              unknowns.place.push_back(offset(c, x, y, z));
  }
  unknowns.begin_layer();
  return unknowns;
}

/// Calls visit(row, column, value) for the entries of the operator between unknowns. The operator is applied
/// to every third node along each axis at once; their neighbourhoods do not overlap.
void BoxLevel::for_each_entry(const CoarsestSolve::Unknowns& unknowns,
                              const CoarsestSolve::Visit& visit) const {
  const BoxOperator& A = operator_;
  const List<std::int32_t> number = unknowns.numbers(field_size());
  const std::int64_t n = n_nodes(), in_plane = std::int64_t{A.nodes[0]} * A.nodes[1];
  std::vector<double> unit(3 * n), plane(static_cast<std::size_t>(3 * in_plane));
  AlignedArray<double> scratch(static_cast<std::size_t>(box_scratch_bytes(A)) / sizeof(double) + 1);
  const auto node_of = [&](int x, int y, int z) {
    return x + A.nodes[0] * (y + std::int64_t{A.nodes[1]} * z);
  };
  const auto number_at = [&](int c, int x, int y, int z) { return number[offset(c, x, y, z)]; };
  for (int colour = 0; colour < 81; ++colour) {
    const int component = colour / 27, of[3] = {colour % 3, colour / 3 % 3, colour / 9 % 3};
    std::ranges::fill(unit, 0.0);
    for (int z = of[2]; z < A.nodes[2]; z += 3)
      for (int y = of[1]; y < A.nodes[1]; y += 3)
        for (int x = of[0]; x < A.nodes[0]; x += 3)
          unit[component * n + node_of(x, y, z)] = 1;
    const auto nearest = [&](int axis, int i) { return i - 1 + ((of[axis] - i + 1) % 3 + 3) % 3; };
    for (int z = 0; z < A.nodes[2]; ++z) {
      apply_box(A, z, unit.data(), plane.data(), scratch.data());
      for (int y = 0; y < A.nodes[1]; ++y)
        for (int x = 0; x < A.nodes[0]; ++x) {
          const int at[3] = {nearest(0, x), nearest(1, y), nearest(2, z)};
          if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] >= A.nodes[0] || at[1] >= A.nodes[1] ||
              at[2] >= A.nodes[2])
            continue;
          const std::int32_t column = number_at(component, at[0], at[1], at[2]);
          for (int c = 0; c < 3 && column >= 0; ++c)
            if (const std::int32_t row = number_at(c, x, y, z); row >= 0)
              visit(static_cast<std::size_t>(row), static_cast<std::size_t>(column),
                    plane[c * in_plane + x + y * A.nodes[0]]);
        }
    }
  }
}

} // namespace maille::deform
