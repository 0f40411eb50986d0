#include "elastic/resample/interpolation.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

std::size_t of(std::int64_t i) {
  return static_cast<std::size_t>(i);
}

bool fills_its_grid(const Specimen& body) {
  return std::ranges::find(body.material_id, no_material) == body.material_id.end();
}

/// Row y, z of a body that fills its grid.
void interpolate_row(const Grid& coarse, const double* from, const Grid& fine, int y, int z, double* to) {
  thread_local std::vector<double> mean;
  const int n = coarse.nodes()[0];
  mean.resize(of(n));
  const double *const below = from + coarse.node({0, y / 2, z / 2}),
                      *const before = from + coarse.node({0, (y + 1) / 2, z / 2}),
                      *const above = from + coarse.node({0, y / 2, (z + 1) / 2}),
                      *const behind = from + coarse.node({0, (y + 1) / 2, (z + 1) / 2});
  for (int x = 0; x < n; ++x)
    mean[of(x)] = 0.25 * ((below[x] + before[x]) + (above[x] + behind[x]));
  double* const row = to + fine.node({0, y, z});
  for (int x = 0; x + 1 < n; ++x) {
    row[2 * x] = mean[of(x)];
    row[2 * x + 1] = 0.5 * (mean[of(x)] + mean[of(x + 1)]);
  }
  row[2 * n - 2] = mean[of(n - 1)];
}

/// The nodes among those around a fine one that are nodes of the body. Those of odd places are counted once,
/// of even ones twice: so all weights are even.
class NodesAround {
public:
  explicit NodesAround(const Specimen& coarse) : grid_(coarse.grid), is_node_(of(coarse.grid.n_nodes())) {
    for (std::size_t node = 0; node < is_node_.size(); ++node)
      is_node_[node] = coarse.is_node(grid_.node_at(static_cast<std::int64_t>(node)));
  }
  /// Of `from`; `otherwise` if there is none.
  double mean(const std::vector<double>& from, const Index3& fine, double otherwise) const {
    double sum = 0;
    int n = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const std::size_t node = of(grid_.node({(fine[0] + (corner & 1)) / 2, (fine[1] + (corner >> 1 & 1)) / 2,
                                              (fine[2] + (corner >> 2 & 1)) / 2}));
      if (is_node_[node])
        sum += from[node], ++n;
    }
    return n > 0 ? sum / n : otherwise;
  }

private:
  const Grid& grid_;
  std::vector<bool> is_node_;
};

/// @param of_coarse, of_fine one or more fields of one number a node
void interpolate_all(const Specimen& coarse, std::span<const std::vector<double>> of_coarse,
                     const Specimen& fine, std::span<std::vector<double>> of_fine, ThreadTeam& team) {
  const Index3& n = fine.grid.nodes();
  if (fills_its_grid(fine)) {
    team.run(n[2] * n[1], [&](int row, int) {
      for (std::size_t b = 0; b < of_fine.size(); ++b)
        interpolate_row(coarse.grid, of_coarse[b].data(), fine.grid, row % n[1], row / n[1],
                        of_fine[b].data());
    });
    return;
  }
  const NodesAround around(coarse);
  for (std::int64_t node = 0; node < fine.grid.n_nodes(); ++node)
    if (const Index3 at = fine.grid.node_at(node); fine.is_node(at))
      for (std::size_t b = 0; b < of_fine.size(); ++b)
        of_fine[b][of(node)] = around.mean(of_coarse[b], at, of_fine[b][of(node)]);
}

} // namespace

void interpolate(const Specimen& coarse, const std::vector<double>& from, const Specimen& fine,
                 std::vector<double>& to, ThreadTeam& team) {
  interpolate_all(coarse, {&from, 1}, fine, {&to, 1}, team);
}

void interpolate(const Specimen& coarse, const Displacement& from, const Specimen& fine, Displacement& to,
                 ThreadTeam& team) {
  interpolate_all(coarse, from.component, fine, to.component, team);
}

} // namespace maille::deform
