#include "ties.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace maille::fem_ref {
namespace {

/// Two nodes of the mesh and the direction along which they move together.
using Row = std::pair<std::pair<unsigned, unsigned>, Vec3>;

/// Directions by pairs of nodes of the grid; none: all.
using Directions = std::map<std::pair<std::int64_t, std::int64_t>, std::vector<Vec3>>;

/// A position in half cells, and the nodes of its copies.
using Copies = std::map<Index3, std::vector<std::pair<int, unsigned>>>;

template<int dim>
Copies copies_of_nodes(const Scene& scene, const Body<dim>& body) {
  const Grid& grid = scene.specimen.grid;
  const int halves = body.element().n_nodes() > (1 << dim) ? 1 : 2; // half cells from node to node
  Copies copies;
  for (int cell = 0; cell < body.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(body.grid_cell(cell));
    const int copy = at[2] / scene.tied.planes;
    for (int i = 0; i < body.element().n_nodes(); ++i) {
      const Index3& place = body.element().place(i);
      Index3 key{};
      for (std::size_t a = 0; a < 3; ++a)
        key[a] = 2 * at[a] + halves * place[a];
      key[2] -= 2 * scene.tied.planes * copy;
      auto& here = copies[key];
      const std::pair entry(copy, body.nodes(cell)[i]);
      if (std::ranges::find(here, entry) == here.end())
        here.push_back(entry);
    }
  }
  return copies;
}

/// Corners around a position in half cells: itself, or the ends of its edge or face.
std::vector<Index3> corners_around(const Index3& key) {
  std::vector<Index3> corners;
  for (int corner = 0; corner < 8; ++corner) {
    Index3 at{};
    bool counts = true;
    for (std::size_t a = 0; a < 3; ++a) {
      counts = counts && (key[a] % 2 != 0 || !(corner >> a & 1));
      at[a] = key[a] / 2 + (key[a] % 2 != 0 ? corner >> a & 1 : 0);
    }
    if (counts)
      corners.push_back(at);
  }
  return corners;
}

/// Directions that tie two copies of a position: common to all corners around it; none if a corner is not
/// tied.
std::vector<Vec3> directions_at(const Scene& scene, const Directions& known, const Index3& key, int one,
                                int other) {
  const std::vector<Index3> corners = corners_around(key);
  std::vector<std::vector<Vec3>> of_corner;
  for (Index3 at : corners) {
    const auto node = [&](int copy) {
      return scene.specimen.grid.node({at[0], at[1], at[2] + copy * scene.tied.planes});
    };
    const auto found = known.find(std::minmax(node(one), node(other)));
    if (found == known.end())
      return {};
    of_corner.push_back(found->second);
  }
  if (of_corner.size() == 1)
    return of_corner.front();
  Vec3 mean{};
  for (const auto& directions : of_corner)
    if (directions.size() == 1)
      for (std::size_t a = 0; a < 3; ++a)
        mean[a] += directions.front()[a];
  if (mean == Vec3{}) // joined on all sides, or at an edge of the border
    return of_corner.front();
  const double length = std::hypot(mean[0], mean[1], mean[2]);
  return {{mean[0] / length, mean[1] / length, mean[2] / length}};
}

} // namespace

template<int dim>
Ties::Ties(const Scene& scene, const Body<dim>& body, const std::vector<bool>& is_prescribed) {
  if (scene.tied.ties.empty())
    return;
  follows_.assign(is_prescribed.size(), false);
  Directions known;
  for (const NodeTie& tie : scene.tied.ties)
    known[std::minmax(tie.one, tie.other)].push_back(tie.normal);
  for (const auto& [key, copies] : copies_of_nodes(scene, body)) {
    std::vector<unsigned> nodes;
    std::vector<Row> rows;
    for (std::size_t i = 0; i < copies.size(); ++i)
      for (std::size_t j = i + 1; j < copies.size(); ++j)
        for (const Vec3& along : directions_at(scene, known, key, copies[i].first, copies[j].first)) {
          const std::pair pair(copies[i].second, copies[j].second);
          if (along != Vec3{}) {
            rows.push_back({pair, along});
            continue;
          }
          for (std::size_t a = 0; a < 3; ++a) {
            rows.push_back({pair, {}});
            rows.back().second[a] = 1;
          }
        }
    for (const auto& copy : copies)
      nodes.push_back(copy.second);
    if (!rows.empty())
      eliminate(nodes, rows, is_prescribed);
  }
}

void Ties::eliminate(const std::vector<unsigned>& nodes, const std::vector<Row>& rows,
                     const std::vector<bool>& is_prescribed) {
  const auto n = static_cast<Eigen::Index>(3 * nodes.size()), m = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(m, n);
  const auto place = [&](unsigned node) { return 3 * (std::ranges::find(nodes, node) - nodes.begin()); };
  const auto unknown = [&](Eigen::Index column) {
    return 3 * nodes[column / 3] + static_cast<unsigned>(column % 3);
  };
  for (Eigen::Index r = 0; r < m; ++r) {
    const auto& [pair, along] = rows[r];
    for (Eigen::Index b = 0; b < 3; ++b) {
      C(r, place(pair.first) + b) += along[b];
      C(r, place(pair.second) + b) -= along[b];
    }
  }
  std::vector<std::pair<Eigen::Index, Eigen::Index>> pivots; // row, column
  std::set<Eigen::Index> used;
  while (true) {
    double largest = 1e-9;
    std::pair<Eigen::Index, Eigen::Index> pivot{-1, -1};
    for (Eigen::Index r = 0; r < m; ++r)
      for (Eigen::Index c = 0; c < n && !used.contains(r); ++c)
        if (!is_prescribed[unknown(c)] && std::abs(C(r, c)) > largest) {
          largest = std::abs(C(r, c));
          pivot = {r, c};
        }
    if (pivot.first < 0)
      break;
    C.row(pivot.first) /= C(pivot.first, pivot.second);
    for (Eigen::Index r = 0; r < m; ++r)
      if (r != pivot.first)
        C.row(r) -= C(r, pivot.second) * C.row(pivot.first);
    used.insert(pivot.first);
    pivots.push_back(pivot);
  }
  for (const auto& [row, column] : pivots) {
    Follower follower{unknown(column), {}};
    for (Eigen::Index c = 0; c < n; ++c)
      if (c != column && std::abs(C(row, c)) > 1e-12)
        follower.of.emplace_back(unknown(c), -C(row, c));
    follows_[follower.unknown] = true;
    followers_.push_back(std::move(follower));
  }
}

void Ties::distribute(dealii::Vector<double>& u) const {
  for (const Follower& follower : followers_) {
    double sum = 0;
    for (const auto& [unknown, factor] : follower.of)
      sum += factor * u[unknown];
    u[follower.unknown] = sum;
  }
}

void Ties::condense(dealii::Vector<double>& forces) const {
  for (const Follower& follower : followers_) {
    for (const auto& [unknown, factor] : follower.of)
      forces[unknown] += factor * forces[follower.unknown];
    forces[follower.unknown] = 0;
  }
}

void Ties::constrain(const std::vector<bool>& is_prescribed,
                     dealii::AffineConstraints<double>& constraints) const {
  for (const Follower& follower : followers_) {
    constraints.add_line(follower.unknown);
    for (const auto& [unknown, factor] : follower.of)
      if (!is_prescribed[unknown])
        constraints.add_entry(follower.unknown, unknown, factor);
  }
}

template Ties::Ties(const Scene&, const Body<1>&, const std::vector<bool>&);
template Ties::Ties(const Scene&, const Body<2>&, const std::vector<bool>&);
template Ties::Ties(const Scene&, const Body<3>&, const std::vector<bool>&);

} // namespace maille::fem_ref
