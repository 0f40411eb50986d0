#include "world/voxels/single_voxels.hpp"

#include "lattice/tolerances.hpp"
#include "world/occupancy/cell_walk.hpp"
#include "world/occupancy/posed_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace maille::deform {

namespace {

Index3 cell_of(const Eigen::Vector3d& place) {
  return cell_at({place[0], place[1], place[2]});
}

std::string why_not(const WorldParts& parts, int object) {
  const WorldObject& what = parts.scene.objects[static_cast<std::size_t>(object)];
  const Grid& grid = what.scene.specimen.grid;
  if (what.turn_angle != 0)
    return "is turned: voxels are handed on along the axes of the world";
  for (std::size_t a = 0; a < static_cast<std::size_t>(parts.scene.dimension); ++a)
    if (const double ratio = grid.spacing()[a] / parts.scene.spacing[a];
        !parts.is_body(object) && std::abs(ratio - 1) > tolerance)
      return "has not the spacing of the world: a voxel is a cell";
  std::vector<int> held(static_cast<std::size_t>(grid.n_nodes()), 0);
  for (const Prescribed& p : what.scene.prescribed)
    ++held[static_cast<std::size_t>(p.node)];
  if (std::ranges::any_of(held, [&](int n) { return n > 0 && n < parts.scene.dimension; }))
    return "is held along some axes alone: a voxel is fixed or free";
  return {};
}

/// Well within its cell, so that no rounding on the way back puts it into another.
Eigen::Vector3d off_faces(const Eigen::Vector3d& place) {
  const Eigen::Vector3d low = place.array().floor() + tolerance;
  return place.cwiseMax(low).cwiseMin(Eigen::Vector3d(low.array() + 1 - 2 * tolerance));
}

} // namespace

void check_single_voxels(const WorldParts& parts) {
  const auto fail = [](const std::string& what) {
    throw std::invalid_argument("World: the method `hand_on`: " + what);
  };
  if (parts.scene.contact != ContactLaw::cells)
    fail("contact = \"cells\"");
  if (parts.scene.friction > 0)
    fail("no friction: it knows no forces");
  for (int object = 0; object < parts.n_objects(); ++object)
    if (const std::string why = why_not(parts, object); !why.empty())
      fail("object `" + parts.scene.objects[static_cast<std::size_t>(object)].name + "` " + why);
  const SingleVoxels voxels(parts); // which finds out whether each has a cell of its own
}

SingleVoxels::SingleVoxels(const WorldParts& parts)
    : parts_(parts), cell_size_(Eigen::Vector3d::Map(parts.scene.spacing.data())), map_(parts.scene.cells),
      start_(static_cast<std::size_t>(parts.n_objects())) {
  bodies_.reserve(parts.bodies.size());
  for (int object = 0; object < parts.n_objects(); ++object) {
    first_.push_back(static_cast<VoxelId>(voxels_.size()));
    parts.is_body(object) ? add_body(parts, object) : add_rigid(parts, object);
    start_[static_cast<std::size_t>(object)] = voxel(first_.back()).place;
  }
  first_.push_back(static_cast<VoxelId>(voxels_.size()));
  for (VoxelId id = 0; id < first_.back(); ++id) {
    const Index3 cell = cell_of(voxel(id).place);
    if (map_.is_blocked(cell))
      throw std::invalid_argument(
          "World: the method `hand_on`: object `" +
          parts.scene.objects[static_cast<std::size_t>(whose(id).object)].name +
          "` has two voxels in a cell, or one in a cell of another: coarser objects, or "
          "a finer world");
    map_.put(cell, id);
  }
}

void SingleVoxels::add_rigid(const WorldParts& parts, int object) {
  const auto& member = parts.member(object);
  const RigidShape& shape = parts.rigid.shape(member.index);
  const bool is_free = member.kind == ObjectKind::rigid && !member.is_driven && shape.n_voxels() == 1;
  for (std::int32_t i = 0; i < shape.n_voxels(); ++i) {
    Eigen::Vector3d place =
        (parts.rigid.pose(member.index).position + shape.centre_of(i)).cwiseQuotient(cell_size_);
    place.tail(3 - parts.scene.dimension).setConstant(0.5);
    voxels_.push_back({place, !is_free});
  }
}

void SingleVoxels::add_body(const WorldParts& parts, int object) {
  const DeformableObject& body = parts.body(object);
  const PosedLattice& lattice = body.lattice();
  Body& added = bodies_.emplace_back(Body{
      LinkTable(body.scene(), body.limits()), {}, body.scene().relaxation.mode == RelaxationMode::elastic});
  const auto first = static_cast<std::size_t>(first_.back());
  for (std::int32_t i = 0; i < lattice.n_voxels(); ++i) {
    const InCells place = lattice.place(i, body.displacement());
    voxels_.push_back({{place[0], place[1], place[2]}, body.handles().contains(lattice.node(i))});
    added.rest.push_back(lattice.rest(i).cwiseQuotient(cell_size_));
  }
  for (const Prescribed& p : body.scene().prescribed)
    voxels_[first + static_cast<std::size_t>(lattice.voxel(p.node))].is_fixed = true;
}

SingleVoxels::Voxel SingleVoxels::whose(VoxelId id) const {
  if (id == no_voxel)
    return {};
  const auto after = std::upper_bound(first_.begin(), first_.end(), id);
  const int object = static_cast<int>(after - first_.begin()) - 1;
  const VoxelId within = id - first(object);
  return {object, parts_.is_body(object) ? parts_.body(object).lattice().node(within) : within};
}

/// @return how far the voxel itself went [cells]
Eigen::Vector3d SingleVoxels::go(VoxelId id, const Eigen::Vector3d& by) {
  const Transfer transfer = hand_on(map_, voxels_, id, by);
  for (std::size_t i = 1; i < transfer.moves.size(); ++i)
    handed_.push_back({whose(transfer.moves[i - 1].voxel), whose(transfer.moves[i].voxel),
                       transfer.moves[i].asked, transfer.moves[i].moved});
  if (!transfer.refused.isZero(0) && !transfer.moves.empty())
    handed_.push_back({whose(transfer.moves.back().voxel), whose(transfer.refused_by), transfer.refused,
                       Eigen::Vector3d::Zero()});
  return transfer.moves.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : transfer.moves.front().moved;
}

void SingleVoxels::move_nodes(int object, const std::vector<std::int64_t>& nodes,
                              const std::vector<Eigen::Vector3d>& by) {
  const DeformableObject& body = parts_.body(object);
  const auto id_of = [&](std::size_t i) { return first(object) + body.lattice().voxel(nodes[i]); };
  const auto ahead = [&](std::size_t i) { return voxel(id_of(i)).place.dot(by[i]); };
  std::vector<std::size_t> order(nodes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t i, std::size_t j) { return ahead(i) > ahead(j); });
  std::vector<bool> is_held(nodes.size());
  for (const std::size_t i : order)
    is_held[i] =
        std::ranges::any_of(body.scene().prescribed, [&](const Prescribed& p) { return p.node == nodes[i]; });
  for (const std::size_t i : order)
    voxel(id_of(i)).is_fixed = is_held[i];
  for (const std::size_t i : order)
    go(id_of(i), by[i]);
  for (const std::size_t i : order) // in a hand
    voxel(id_of(i)).is_fixed = true;
}

/// When a voxel of a rigid object would first enter a cell that is not the object's, and which.
std::optional<SingleVoxels::Obstruction> SingleVoxels::in_the_way(int object, VoxelId id,
                                                                  const Eigen::Vector3d& by) const {
  const Eigen::Vector3d& place = voxels_[static_cast<std::size_t>(id)].place;
  std::array<CoordinatePath, 3> paths;
  for (std::size_t a = 0; a < 3; ++a)
    paths[a] = {place[static_cast<Eigen::Index>(a)], by[static_cast<Eigen::Index>(a)], 0, 0};
  CellWalk walk(paths, 0, cell_of(place));
  while (const auto step = walk.next(1)) {
    const VoxelId other =
        map_.has_cell(walk.cell()) && map_.is_occupied(walk.cell()) ? map_.occupant(walk.cell()) : no_voxel;
    const bool is_own = other >= first(object) && other < first(object + 1);
    if (map_.is_blocked(walk.cell()) && !is_own)
      return Obstruction{step->time, other};
  }
  return std::nullopt;
}

double SingleVoxels::move_rigid(int object, const Eigen::Vector3d& by) {
  if (by.isZero(0))
    return 1;
  const VoxelId begin = first(object), end = first(object + 1);
  for (VoxelId id = begin; id < end; ++id)
    if (const auto met = in_the_way(object, id, by)) {
      const Eigen::Vector3d left = (1 - met->time) * by;
      const bool is_free = met->voxel != no_voxel && !voxel(met->voxel).is_fixed;
      const Eigen::Vector3d moved = is_free ? go(met->voxel, left) : Eigen::Vector3d::Zero();
      handed_.push_back({whose(id), whose(met->voxel), left, moved});
    }
  double part = 1;
  for (VoxelId id = begin; id < end; ++id)
    if (const auto met = in_the_way(object, id, by))
      part = std::min(part, std::max(0.0, met->time - tolerance / by.cwiseAbs().maxCoeff()));
  for (VoxelId id = begin; id < end; ++id)
    map_.take(cell_of(voxel(id).place));
  for (VoxelId id = begin; id < end; ++id) {
    voxel(id).place += part * by;
    map_.put(cell_of(voxel(id).place), id);
  }
  return part;
}

double SingleVoxels::sweep(int object) {
  const Body& body = bodies_[static_cast<std::size_t>(parts_.member(object).index)];
  const LinkTable& table = body.table;
  const int dimension = parts_.scene.dimension;
  const auto u = [&](std::int32_t node, int b) {
    return (voxel(first(object) + node).place[b] - body.rest[static_cast<std::size_t>(node)][b]) *
           cell_size_[b];
  };
  double furthest = 0;
  for (std::int32_t node = 0; node < table.n_nodes(); ++node) {
    const auto begin = static_cast<std::size_t>(table.first()[static_cast<std::size_t>(node)]),
               end = static_cast<std::size_t>(table.first()[static_cast<std::size_t>(node) + 1]);
    if (voxel(first(object) + node).is_fixed || begin == end)
      continue;
    Eigen::Vector3d by = Eigen::Vector3d::Zero();
    for (int b = 0; b < dimension; ++b) {
      double sum = 0, low = -std::numeric_limits<double>::infinity(), high = -low;
      for (std::size_t e = begin; e < end; ++e) {
        const double other = u(table.neighbour()[e], b);
        sum += other;
        low = std::max(low, other + table.below(b)[e]);
        high = std::min(high, other + table.above(b)[e]);
      }
      const double now = u(node, b), wanted = body.is_elastic ? sum / static_cast<double>(end - begin) : now;
      by[b] = ((low > high ? 0.5 * low + 0.5 * high : std::clamp(wanted, low, high)) - now) / cell_size_[b];
    }
    if (by.cwiseAbs().maxCoeff() > rounding)
      furthest = std::max(furthest, go(first(object) + node, by).cwiseAbs().maxCoeff());
  }
  return furthest;
}

/// Motion of an object's first voxel since construction [cells].
Eigen::Vector3d SingleVoxels::gone(int object) const {
  const Eigen::Vector3d& start = start_[static_cast<std::size_t>(object)];
  const Eigen::Vector3d& place = voxels_[static_cast<std::size_t>(first(object))].place;
  return place == start ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                        : Eigen::Vector3d(off_faces(place) - start);
}

std::vector<SingleVoxels::Handed> SingleVoxels::take_handed() {
  return std::exchange(handed_, {});
}

void SingleVoxels::hand_back(WorldParts& parts) const {
  std::vector<Pose> poses;
  for (int i = 0; i < parts.rigid.n_objects(); ++i)
    poses.push_back(parts.rigid.pose(i));
  for (int object = 0; object < parts.n_objects(); ++object)
    if (!parts.is_body(object))
      poses[static_cast<std::size_t>(parts.member(object).index)].position +=
          gone(object).cwiseProduct(cell_size_);
  parts.rigid.place(poses);
  for (int object = 0; object < parts.n_objects(); ++object) {
    if (!parts.is_body(object))
      continue;
    DeformableObject& body = parts.body(object);
    const PosedLattice& lattice = body.lattice();
    Displacement state = body.displacement();
    for (std::int32_t i = 0; i < lattice.n_voxels(); ++i) {
      const Eigen::Vector3d place = off_faces(voxels_[static_cast<std::size_t>(first(object) + i)].place);
      const Vec3 u = lattice.displacement_at(i, place.cwiseProduct(cell_size_));
      for (int b = 0; b < parts.scene.dimension; ++b)
        state(b, lattice.node(i)) = u[static_cast<std::size_t>(b)];
    }
    body.put_at(parts.map(), state);
  }
}

} // namespace maille::deform
