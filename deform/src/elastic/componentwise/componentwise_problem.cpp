#include "elastic/componentwise/componentwise_solver.hpp"

#include "lattice/tolerances.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace maille::deform {

Index3 level_nodes(const Grid& grid) {
  const Index3& n = grid.nodes();
  return grid.dimension() == 2 ? Index3{n[0], 1, n[1]} : n;
}

int level_axis(const Grid& grid, int axis) {
  return grid.dimension() == 2 && axis == 1 ? 2 : axis;
}

Vec3 weight_per_modulus(const Grid& grid) {
  const auto d = static_cast<std::size_t>(grid.dimension());
  double volume = 1;
  for (std::size_t a = 0; a < d; ++a)
    volume *= grid.spacing()[a];
  Vec3 factor{};
  for (std::size_t a = 0; a < d; ++a)
    factor[a] = volume / (grid.spacing()[a] * grid.spacing()[a]);
  return factor;
}

double link_weight(const Specimen& body, const CellModuli& moduli, const Index3& tail, int axis,
                   int component) {
  const auto a = static_cast<std::size_t>(axis);
  double sum = 0;
  body.for_each_cell_at_link(tail, axis, [&](std::int64_t cell) { sum += moduli[cell][a][component]; });
  return sum * (2 * weight_per_modulus(body.grid)[a] / body.grid.corners_per_cell());
}

double largest_weight(const Scene& scene, const CellModuli& moduli, int component) {
  const Specimen& body = scene.specimen;
  const Vec3 factor = weight_per_modulus(body.grid);
  double largest = 0;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    for (int a = 0; a < scene.dimension(); ++a)
      largest = std::max(largest, factor[a] * moduli[cell][a][component]);
    if (moduli.is_homogeneous_box())
      break;
  }
  return largest;
}

namespace {

LinkWeights weights_of_box(const Grid& grid, const CellModuli& moduli, int component, double unit) {
  LinkWeights weights;
  const Index3 n = level_nodes(grid);
  for (std::size_t a = 0; a < 3; ++a) {
    const auto size = static_cast<std::size_t>(n[a]);
    weights.axis_link[a].assign(size - 1, 0);
    weights.axis_mass[a].assign(size, 1);
    if (size > 1)
      weights.axis_mass[a].front() = weights.axis_mass[a].back() = 0.5;
  }
  const Vec3 factor = weight_per_modulus(grid);
  for (int a = 0; a < grid.dimension(); ++a)
    std::ranges::fill(weights.axis_link[level_axis(grid, static_cast<int>(a))],
                      factor[a] * moduli.first()[a][component] / unit);
  return weights;
}

/// Weights per link from the factors of a box.
LinkWeights expanded(const LinkWeights& box, const Index3& n) {
  LinkWeights weights;
  const std::int64_t row_stride = padded_row(n[0]);
  for (std::size_t a = 0; a < 3; ++a) {
    weights.link[a] = PaddedArray(static_cast<std::size_t>(row_stride * n[1] * n[2]));
    const auto factor = [&](std::size_t b, int i) {
      const auto& values = a == b ? box.axis_link[b] : box.axis_mass[b];
      return static_cast<std::size_t>(i) < values.size() ? values[i] : 0;
    };
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y) {
        float* const row = weights.link[a].data() + row_stride * (y + std::int64_t{1} * n[1] * z);
        const double of_row = factor(1, y) * factor(2, z);
        for (int x = 0; x < n[0]; ++x)
          row[x] = static_cast<float>(of_row * factor(0, x));
      }
  }
  return weights;
}

} // namespace

LinkWeights link_weights(const Scene& scene, const CellModuli& moduli, int component, double unit) {
  if (moduli.is_homogeneous_box())
    return weights_of_box(scene.specimen.grid, moduli, component, unit);
  return weights_per_link(scene, moduli, component, unit);
}

LinkWeights weights_per_link(const Scene& scene, const CellModuli& moduli, int component, double unit) {
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  LinkWeights weights;
  const Index3 n = level_nodes(grid);
  const std::int64_t row_stride = padded_row(n[0]);
  if (moduli.is_homogeneous_box())
    return expanded(weights_of_box(grid, moduli, component, unit), n);
  for (PaddedArray& link : weights.link)
    link = PaddedArray(static_cast<std::size_t>(row_stride * n[1] * n[2]));
  // In 2D rows are planes, one row each, so rows of the grid follow each other in either case.
  const auto place = [&](const Index3& at) {
    return at[0] + row_stride * (at[1] + std::int64_t{1} * grid.nodes()[1] * at[2]);
  };
  const int dimension = grid.dimension(), corners = grid.corners_per_cell();
  const Vec3 factor = weight_per_modulus(grid);
  const double share = 2.0 / corners / unit;
  const auto b = static_cast<std::size_t>(component);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    for (int axis = 0; axis < dimension; ++axis) {
      float* const link = weights.link[level_axis(grid, axis)].data();
      const auto a = static_cast<std::size_t>(axis);
      const auto part = static_cast<float>(share * factor[a] * moduli[cell][a][b]);
      for (int corner = 0; corner < corners; ++corner)
        if (!(corner >> axis & 1))
          link[place({at[0] + (corner & 1), at[1] + (corner >> 1 & 1), at[2] + (corner >> 2 & 1)})] += part;
    }
  }
  return weights;
}

Anchors springs_along(const List<NodalSpring>& springs, int component, double unit) {
  Anchors anchors;
  for (const NodalSpring& spring : springs)
    if (const double stiffness = spring.stiffness(component, component); stiffness > 0)
      anchors.emplace_hint(anchors.end(), spring.node, stiffness / unit);
  return anchors;
}

bool springs_are_along_axes(const Scene& scene) {
  return std::ranges::all_of(nodal_springs(scene), [&](const NodalSpring& spring) {
    const Eigen::Matrix3d& k = spring.stiffness;
    return std::max({std::abs(k(0, 1)), std::abs(k(0, 2)), std::abs(k(1, 2))}) <= tolerance * k.trace();
  });
}

std::vector<bool> loose_nodes(const Scene& scene, const List<FixedNode>& fixed, const Anchors& springs) {
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  if ((!fixed.empty() || !springs.empty()) && body.n_matter_cells() == grid.n_cells())
    return {};
  // Links of a cell join all of its corners, so cells that share a node share their fate.
  std::vector<bool> reached(grid.n_nodes(), false);
  List<std::int64_t> waiting;
  const auto reach = [&](std::int64_t node) {
    if (!reached[node]) {
      reached[node] = true;
      waiting.push_back(node);
    }
  };
  for (const FixedNode& f : fixed)
    reach(f.node);
  for (const auto& spring : springs)
    reach(spring.first);
  std::vector<bool> is_done(grid.n_cells(), false);
  while (!waiting.empty()) {
    const std::int64_t node = waiting.back();
    waiting.pop_back();
    body.for_each_cell_at(grid.node_at(node), [&](std::int64_t cell) {
      if (is_done[cell])
        return;
      is_done[cell] = true;
      for (int corner = 0; corner < grid.corners_per_cell(); ++corner)
        reach(grid.corner(grid.cell_at(cell), corner));
    });
  }
  bool is_any_loose = false;
  for (std::size_t node = 0; node < reached.size(); ++node) {
    reached[node] = !reached[node] && body.is_node(grid.node_at(static_cast<std::int64_t>(node)));
    is_any_loose = is_any_loose || reached[node];
  }
  return is_any_loose ? reached : std::vector<bool>();
}

} // namespace maille::deform
