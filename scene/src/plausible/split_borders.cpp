#include "maille/scene/sliding.hpp"

#include "cell_values.hpp"
#include "geometry/border_normals.hpp"
#include "maille/scene/cell_fields.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace maille {

namespace {

using Labels = std::pair<std::int32_t, std::int32_t>; ///< the smaller one first
using Sliding = std::map<Labels, double>;             ///< borders that slide, with their friction

Labels pair_of(std::int32_t one, std::int32_t other) {
  return std::minmax(one, other);
}

std::int32_t label_of(const Specimen& body, std::int64_t cell) {
  return body.label[cell];
}

double softest_modulus(const Scene& scene, std::int64_t cell) {
  return scene.specimen.weight_of(cell) * scene.object_stiffness(cell).diagonal().minCoeff();
}

/// Stiffness of springs between the nodes of a tie for which friction converges in the fewest rounds [N/m].
/// @param one,other  a cell on each side
// The stiffness of a border is G h for variation from node to node, and G h / n for variation along a body of
// n cells: the geometric mean needs the fewest rounds.
double rubbing_spring(const Scene& scene, std::int64_t one, std::int64_t other) {
  const Grid& grid = scene.specimen.grid;
  const Vec3& h = grid.spacing();
  const double cells = *std::ranges::max_element(grid.cells());
  const double stiffness = std::min(softest_modulus(scene, one), softest_modulus(scene, other));
  return stiffness * std::cbrt(h[0] * h[1] * h[2]) / std::sqrt(cells);
}

/// Calls visit(cell, beyond, axis) for all pairs of cells of matter that share a face, `beyond` above `cell`.
template<class Visit>
void for_each_shared_face(const Specimen& body, Visit&& visit) {
  const Grid& grid = body.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    for (int axis = 0; axis < grid.dimension(); ++axis) {
      Index3 beyond = at;
      ++beyond[axis];
      if (grid.has_cell(beyond) && body.is_matter(grid.cell(beyond)))
        visit(cell, grid.cell(beyond), axis);
    }
  }
}

/// A copy for every label: the first one without labels that slide on it.
std::map<std::int32_t, int> copies_of_labels(const Specimen& body, const Sliding& sliding) {
  std::set<std::int32_t> labels;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell))
      labels.insert(label_of(body, cell));
  std::map<std::int32_t, int> copies;
  for (const std::int32_t label : labels) {
    int copy = 0;
    const auto is_taken = [&](int number) {
      return std::ranges::any_of(copies, [&](const auto& other) {
        return other.second == number && sliding.contains(pair_of(label, other.first));
      });
    };
    while (is_taken(copy))
      ++copy;
    copies[label] = copy;
  }
  return copies;
}

/// Computes the ties at the nodes of a body.
class Ties {
public:
  Ties(const Scene& scene, const Sliding& sliding, const std::map<std::int32_t, int>& copies)
      : body_(scene.specimen), sliding_(sliding), copies_(copies) {
    std::map<Labels, std::vector<OrientedFace>> faces;
    for_each_shared_face(body_, [&](std::int64_t cell, std::int64_t beyond, int axis) {
      const std::int32_t one = label_of(body_, cell), other = label_of(body_, beyond);
      if (sliding_.contains(pair_of(one, other)))
        faces[pair_of(one, other)].push_back(one < other ? OrientedFace{cell, axis, true}
                                                         : OrientedFace{beyond, axis, false});
      if (const auto pair = sliding_.find(pair_of(one, other)); pair != sliding_.end() && pair->second > 0) {
        double& softest = spring_[pair->first];
        const double spring = rubbing_spring(scene, cell, beyond);
        softest = softest == 0 ? spring : std::min(softest, spring);
      }
    });
    for (const auto& [labels, of_border] : faces)
      normals_.emplace(labels, BorderNormals(body_.grid, of_border));
  }

  /// Calls add(copy of one, copy of other, tie) for every tie of a node.
  template<class Add>
  void at(const Index3& node, Add&& add) const;

private:
  const Specimen& body_;
  const Sliding& sliding_;
  const std::map<std::int32_t, int>& copies_;
  std::map<Labels, double> spring_;         ///< of borders with friction
  std::map<Labels, BorderNormals> normals_; ///< from the smaller label to the larger
};

template<class Add>
void Ties::at(const Index3& node, Add&& add) const {
  const Grid& grid = body_.grid;
  std::array<std::int32_t, 8> label{};
  std::array<bool, 8> is_matter{};
  std::set<int> copies;
  for (int corner = 0; corner < 8; ++corner) {
    const Index3 cell{node[0] - 1 + (corner & 1), node[1] - 1 + (corner >> 1 & 1),
                      node[2] - 1 + (corner >> 2)};
    const auto c = static_cast<std::size_t>(corner);
    is_matter[c] = grid.has_cell(cell) && body_.is_matter(grid.cell(cell));
    if (is_matter[c]) {
      label[c] = label_of(body_, grid.cell(cell));
      copies.insert(copies_.at(label[c]));
    }
  }
  if (copies.size() < 2)
    return;
  std::set<Labels> by_face, by_corner; // pairs of labels in different copies
  for (std::size_t one = 0; one < 8; ++one)
    for (std::size_t other = one + 1; other < 8; ++other) {
      if (!is_matter[one] || !is_matter[other] || copies_.at(label[one]) == copies_.at(label[other]))
        continue;
      const std::size_t apart = one ^ other;
      (apart == 1 || apart == 2 || apart == 4 ? by_face : by_corner)
          .insert(pair_of(label[one], label[other]));
    }
  std::set<std::pair<int, int>> joined; // copies
  for (const auto* pairs : {&by_face, &by_corner})
    for (const Labels& labels : *pairs)
      if (!sliding_.contains(labels))
        joined.insert(std::minmax(copies_.at(labels.first), copies_.at(labels.second)));
  for (const auto& [one, other] : joined)
    add(one, other, NodeTie{});
  for (const Labels& labels : by_face) {
    const int one = copies_.at(labels.first), other = copies_.at(labels.second);
    if (!sliding_.contains(labels) || joined.contains(std::minmax(one, other)))
      continue;
    const Vec3 normal = normals_.at(labels).at(
        {static_cast<double>(node[0]), static_cast<double>(node[1]), static_cast<double>(node[2])});
    if (normal == Vec3{})
      continue;
    NodeTie tie{0, 0, normal, {labels.first, labels.second}, sliding_.at(labels), 0, {}};
    if (tie.friction > 0)
      tie.spring = spring_.at(labels);
    add(one, other, tie);
  }
}

void split_body(const Scene& scene, SplitScene& split) {
  const Specimen& body = scene.specimen;
  Specimen& of = split.scene.specimen;
  const int planes = body.grid.cells()[2] + 1; // from a copy to the next
  Index3 cells = body.grid.cells();
  cells[2] = split.n_copies * planes - 1;
  of.grid = Grid(3, cells, body.grid.spacing());
  const auto source = [&](std::int64_t cell) {
    Index3 at = of.grid.cell_at(cell);
    const int copy = at[2] / planes;
    at[2] %= planes;
    const std::int64_t from = body.grid.has_cell(at) ? body.grid.cell(at) : -1;
    return from >= 0 && split.copy_of[from] == copy ? from : -1;
  };
  if (of.material_id.empty())
    of.material_id.assign(body.grid.n_cells(), 0);
  carry_cells(of, source);
  split.scene.active_stress = carried(scene.active_stress, of.grid.n_cells(), 0.0, source);
}

/// Calls visit(copy) for the copies that have a node.
template<class Visit>
void for_each_copy(const Specimen& body, const SplitScene& split, std::int64_t node, Visit&& visit) {
  std::set<int> copies;
  body.for_each_cell_at(body.grid.node_at(node),
                        [&](std::int64_t cell) { copies.insert(split.copy_of[cell]); });
  for (const int copy : copies)
    visit(copy);
}

void split_conditions(const Scene& scene, SplitScene& split) {
  const Specimen& body = scene.specimen;
  Scene& of = split.scene;
  of.prescribed.clear();
  for (const Prescribed& p : scene.prescribed)
    for_each_copy(body, split, p.node, [&](int copy) {
      of.prescribed.push_back(p);
      of.prescribed.back().node = split.node(body.grid, p.node, copy);
    });
  std::ranges::sort(of.prescribed, {}, [](const Prescribed& p) { return std::pair(p.component, p.node); });
  const auto move_faces = [&](auto& faces) {
    for (auto& face : faces)
      face.cell = split.cell(body.grid, face.cell, split.copy_of[face.cell]);
  };
  move_faces(of.tractions);
  move_faces(of.springs);
  of.turns.clear(); // these three refer to the body's nodes and cells; steps of a series are split anew
  of.drives.clear();
  of.timed.clear();
}

} // namespace

std::int64_t SplitScene::node(const Grid& of_body, std::int64_t node, int copy) const {
  Index3 at = of_body.node_at(node);
  at[2] += copy * (of_body.cells()[2] + 1);
  return scene.specimen.grid.node(at);
}

std::int64_t SplitScene::cell(const Grid& of_body, std::int64_t cell, int copy) const {
  Index3 at = of_body.cell_at(cell);
  at[2] += copy * (of_body.cells()[2] + 1);
  return scene.specimen.grid.cell(at);
}

SplitScene split_borders(const Scene& scene) {
  return split_borders(scene, scene.sliding);
}

SplitScene split_borders(const Scene& scene, const std::vector<SlidingBorder>& pairs) {
  const Specimen& body = scene.specimen;
  Sliding sliding;
  for (const SlidingBorder& border : pairs)
    sliding[pair_of(border.one, border.other)] = border.friction;
  const std::map<std::int32_t, int> copies = copies_of_labels(body, sliding);
  SplitScene split;
  split.copy_of.assign(body.grid.n_cells(), -1);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell)) {
      int& copy = split.copy_of[cell];
      copy = copies.at(label_of(body, cell));
      split.n_copies = std::max(split.n_copies, copy + 1);
    }
  split.scene = with_taut_scale(scene);
  split.scene.sliding.clear();
  split_body(scene, split);
  split_conditions(scene, split);
  NodeTies& tied = split.scene.tied;
  tied.planes = body.grid.cells()[2] + 1;
  const Ties ties(scene, sliding, copies);
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    ties.at(body.grid.node_at(node), [&](int one, int other, NodeTie tie) {
      tie.one = split.node(body.grid, node, one);
      tie.other = split.node(body.grid, node, other);
      tied.ties.push_back(tie);
    });
  return split;
}

Answer joined(const Scene& scene, const SplitScene& split, Answer answer) {
  if (!has_displacement(answer.status))
    return answer;
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  const Scene& of = split.scene;
  if (answer.cell_strain.empty())
    answer.cell_strain = cell_fields(of, answer).strain;
  const auto gather = [&]<class T>(std::vector<T>& values) {
    if (values.empty())
      return;
    std::vector<T> of_body(grid.n_cells());
    for (std::size_t cell = 0; cell < of_body.size(); ++cell)
      if (split.copy_of[cell] >= 0)
        of_body[cell] = values[split.cell(grid, static_cast<std::int64_t>(cell), split.copy_of[cell])];
    values = std::move(of_body);
  };
  gather(answer.cell_strain);
  gather(answer.cell_energy);
  answer.tie_press.clear(); // the body has no ties
  Displacement u(grid);
  std::vector<std::array<double, 6>> strain, stress;
  const bool has_nodal = !answer.nodal_strain.empty();
  if (has_nodal) {
    strain.resize(grid.n_nodes());
    stress.resize(strain.size());
  }
  answer.split.clear();
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    std::vector<int> copies;
    for_each_copy(body, split, node, [&](int copy) { copies.push_back(copy); });
    for (const int copy : copies) {
      const auto twin = split.node(grid, node, copy);
      for (int b = 0; b < 3; ++b)
        u(b, node) += answer.displacement(b, twin) / static_cast<double>(copies.size());
      if (has_nodal && copy == copies.front()) {
        strain[node] = answer.nodal_strain[twin];
        stress[node] = answer.nodal_stress[twin];
      }
    }
    if (copies.size() < 2)
      continue;
    std::set<std::int32_t> labels;
    body.for_each_cell_at(grid.node_at(node),
                          [&](std::int64_t cell) { labels.insert(label_of(body, cell)); });
    for (const std::int32_t label : labels) {
      int copy = 0;
      body.for_each_cell_at(grid.node_at(node), [&](std::int64_t cell) {
        if (label_of(body, cell) == label)
          copy = split.copy_of[cell];
      });
      answer.split.push_back({node, label, answer.displacement.at(split.node(grid, node, copy))});
    }
  }
  answer.displacement = std::move(u);
  answer.nodal_strain = std::move(strain);
  answer.nodal_stress = std::move(stress);
  if (!answer.reaction.empty()) {
    std::map<std::pair<int, std::int64_t>, double> sum; // by component and node of the body
    const std::int64_t planes = grid.cells()[2] + 1;
    for (std::size_t i = 0; i < answer.reaction.size(); ++i) {
      const Prescribed& p = of.prescribed[i];
      Index3 at = of.specimen.grid.node_at(p.node);
      at[2] = static_cast<int>(at[2] % planes);
      sum[{p.component, grid.node(at)}] += answer.reaction[i];
    }
    answer.reaction.clear();
    for (const Prescribed& p : scene.prescribed)
      answer.reaction.push_back(sum.at({p.component, p.node}));
  }
  return answer;
}

Vec3 DisplacementOfCells::operator()(std::int64_t node, std::int64_t cell) const {
  if (answer_.split.empty())
    return answer_.displacement.at(node);
  const std::pair wanted(node, label_of(body_, cell));
  const auto side = std::ranges::lower_bound(
      answer_.split, wanted, {}, [](const SplitNode& one) { return std::pair(one.node, one.label); });
  const bool is_there = side != answer_.split.end() && side->node == node && side->label == wanted.second;
  return is_there ? side->displacement : answer_.displacement.at(node);
}

Vec3 DisplacementOfCells::within(std::int64_t cell, const Vec3& part) const {
  const Grid& grid = body_.grid;
  Vec3 value{};
  for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
    double weight = 1;
    for (int a = 0; a < grid.dimension(); ++a)
      weight *= corner >> a & 1 ? part[a] : 1 - part[a];
    const Vec3 u = (*this)(grid.corner(grid.cell_at(cell), corner), cell);
    for (std::size_t b = 0; b < 3; ++b)
      value[b] += weight * u[b];
  }
  return value;
}

double largest_violation_of_sides(const Scene& scene, const LinkLimits& limits, const Answer& answer) {
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  const DisplacementOfCells displacement(body, answer);
  double largest = 0;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    std::array<Vec3, 8> u;
    for (int corner = 0; corner < 8; ++corner)
      u[corner] = displacement(grid.corner(grid.cell_at(cell), corner), cell);
    const LinkLimits::OfCell& of_cell = limits.kinds()[limits.kind_of(cell)];
    for (std::size_t near = 0; near < 8; ++near)
      for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3 && (near >> a & 1) == 0; ++b) {
          const double difference = u[near | std::size_t{1} << a][b] - u[near][b];
          largest = std::max({largest, (of_cell[a].low[b] - difference) / grid.spacing()[a],
                              (difference - of_cell[a].high[b]) / grid.spacing()[a]});
        }
  }
  return largest;
}

std::vector<int> axes_of_border(const Specimen& body, const SlidingBorder& pair) {
  std::set<int> axes;
  for_each_shared_face(body, [&](std::int64_t cell, std::int64_t beyond, int axis) {
    if (pair_of(label_of(body, cell), label_of(body, beyond)) == pair_of(pair.one, pair.other))
      axes.insert(axis);
  });
  return {axes.begin(), axes.end()};
}

} // namespace maille
