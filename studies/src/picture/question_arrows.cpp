#include "picture/question_arrows.hpp"

#include <algorithm>
#include <cstdint>
#include <unordered_set>
#include <utility>

namespace maille::studies {

namespace {

struct Mean {
  Vec3 sum{};
  double n = 0;
  void add(const Vec3& what, double weight = 1) {
    sum = plus(sum, weight, what);
    n += weight;
  }
  Vec3 value() const { return {sum[0] / n, sum[1] / n, sum[2] / n}; }
};

/// An arrow from or to `at`, outside the body. @param centre of the body
Arrow arrow_at(const Vec3& at, const Vec3& direction, const Vec3& centre, double length, const Vec3& colour) {
  const double scale = length / length_of(direction);
  const bool leaves = dot(plus(at, -1, centre), direction) >= 0;
  return leaves ? Arrow{at, plus(at, scale, direction), colour}
                : Arrow{plus(at, -scale, direction), at, colour};
}

Vec3 centre_of(const Scene& scene) {
  Mean mean;
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (scene.specimen.is_matter(cell))
      mean.add(scene.specimen.position(grid.cell_at(cell)));
  Vec3 centre = mean.value();
  for (int a = 0; a < grid.dimension(); ++a)
    centre[a] += 0.5 * grid.spacing()[a];
  return centre;
}

/// Displacements of the nodes of a move.
struct Moved {
  std::vector<std::int64_t> nodes;
  std::vector<Vec3> by;
};

/// Displacements of the nodes of a drive at their furthest from rest: its course may end at rest.
Moved furthest(const Scene& scene, const Drive& drive) {
  Moved most;
  double largest = -1;
  constexpr int n_times = 40;
  for (int i = 1; i <= n_times; ++i) {
    Moved now{drive.nodes, {}};
    double size = 0;
    for (const std::int64_t node : drive.nodes) {
      now.by.push_back(drive.displacement(scene.specimen.position(scene.specimen.grid.node_at(node)),
                                          static_cast<double>(i) / n_times));
      size = std::max(size, length_of(now.by.back()));
    }
    if (size > largest) {
      largest = size;
      most = std::move(now);
    }
  }
  return most;
}

std::vector<Moved> moves_of(const Scene& scene) {
  std::unordered_set<std::int64_t> driven;
  for (const Drive& drive : scene.drives)
    driven.insert(drive.nodes.begin(), drive.nodes.end());
  std::vector<std::vector<std::pair<std::int64_t, Vec3>>> by_condition(scene.conditions.size() + 1);
  for (const Prescribed& one : scene.prescribed)
    if (!one.held && !driven.contains(one.node)) {
      auto& list = by_condition[one.condition + 1];
      list.push_back({one.node, {}});
      list.back().second[one.component] = one.value;
    }
  std::vector<Moved> moves;
  for (const Drive& drive : scene.drives)
    moves.push_back(furthest(scene, drive));
  for (auto& list : by_condition) {
    std::ranges::stable_sort(list, {}, [](const auto& entry) { return entry.first; });
    Moved move;
    for (const auto& [node, by] : list)
      if (!move.nodes.empty() && move.nodes.back() == node)
        move.by.back() = plus(move.by.back(), 1, by);
      else {
        move.nodes.push_back(node);
        move.by.push_back(by);
      }
    if (!move.nodes.empty())
      moves.push_back(std::move(move));
  }
  return moves;
}

void add_arrows(const Scene& scene, const Moved& move, const Vec3& centre, double length,
                std::vector<Arrow>& arrows) {
  const auto position = [&](std::size_t i) {
    return scene.specimen.position(scene.specimen.grid.node_at(move.nodes[i]));
  };
  Mean at, by;
  double largest = 0;
  for (std::size_t i = 0; i < move.nodes.size(); ++i) {
    at.add(position(i));
    by.add(move.by[i]);
    largest = std::max(largest, length_of(move.by[i]));
  }
  if (!(largest > 0))
    return;
  if (length_of(by.value()) > 0.5 * largest) {
    arrows.push_back(arrow_at(at.value(), by.value(), centre, length, moved_colour));
    return;
  }
  // A rotation: separate arrows for some of its nodes.
  constexpr std::size_t n_arrows = 6;
  const std::size_t every = std::max<std::size_t>(1, move.nodes.size() / n_arrows);
  for (std::size_t i = every / 2; i < move.nodes.size(); i += every)
    if (const double size = length_of(move.by[i]); size > 0.2 * largest)
      arrows.push_back({position(i), plus(position(i), 0.8 * length / largest, move.by[i]), moved_colour});
}

} // namespace

std::vector<Arrow> arrows_of(const Scene& scene, double length) {
  const Vec3 centre = centre_of(scene);
  std::vector<Arrow> arrows;
  for (const Moved& move : moves_of(scene))
    add_arrows(scene, move, centre, length, arrows);
  std::vector<Mean> at(scene.conditions.size() + 1), pull(scene.conditions.size() + 1);
  for (const FaceLoad& load : scene.tractions) {
    const std::size_t place = load.condition + 1;
    at[place].add(middle_of_face(scene.specimen, load));
    pull[place].add(load.traction);
  }
  for (std::size_t i = 0; i < at.size(); ++i)
    if (at[i].n > 0 && length_of(pull[i].value()) > 0)
      arrows.push_back(arrow_at(at[i].value(), pull[i].value(), centre, length, loaded_colour));
  if (length_of(scene.gravity) > 0)
    arrows.push_back({centre, plus(centre, length / length_of(scene.gravity), scene.gravity), loaded_colour});
  return arrows;
}

} // namespace maille::studies
