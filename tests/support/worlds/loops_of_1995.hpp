#pragma once
/// The loops of Gibson 1995 ("Beyond volume rendering", "Object deformation"), as oracles of engines.
///
/// halving  places a driven object at its target; while a voxel would enter an occupied cell, the step is
///          halved. Cells in between are not checked, so objects pass through thin walls
/// sweep    moves each node to the mean of its neighbours within its limits, one after the other; a few
///          sweeps per frame show the way to rest
/// hand_on  a cell holds one voxel. A voxel moves as far as it can within its own cell and passes the rest of
///          its movement to the voxel in its way, of any object, until the movement is used up, or a fixed
///          voxel or the border stops it
///
/// They implement deform::Engine, so that tests/deform/world/engines_test.cpp applies the same tests to them
/// as to the engines of the product. `maille-lab --loop` plays a world by one of them
/// (docs/figures/loops_of_1995.py).

#include "lattice/link_table.hpp"
#include "lattice/tolerances.hpp"
#include "oracle/sweep.hpp"
#include "world/cells/cell_engine.hpp"
#include "world/occupancy/cell_walk.hpp"
#include "world/occupancy/first_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace maille::test {

/// @return completed fraction of the motion: 1, 1/2, 1/4, ...; 0 below the threshold
inline double move_by_halving(deform::RigidWorld& world, int object, const deform::RigidMotion& motion) {
  constexpr double threshold = 1.0 / 1024;
  const deform::Pose from = world.pose(object);
  world.take_out(object);
  double step = 1;
  while (step >= threshold &&
         deform::is_blocked(world.map(), world.cell_size(), world.shape(object), motion.moved(from, step)))
    step /= 2;
  step = step < threshold ? 0 : step;
  world.put_back(object, motion.moved(from, step));
  return step;
}

} // namespace maille::test

namespace maille::test::loops {

using namespace deform;
using Eigen::Vector3d;

class HalvedPushing : public Pushing {
public:
  using Pushing::Pushing;
  /// Pushes no other object: the obstacle is unknown.
  double push_rigid(int object, RigidMotion motion, bool) override {
    return move_by_halving(world_.rigid, world_.member(object).index, motion);
  }
};

class HalvingEngine : public CellEngine {
public:
  using CellEngine::CellEngine;
  std::unique_ptr<Engine> copy() const override { return nullptr; }
  FrameResult advance(std::span<const deform::Drive> drives, const FrameBudget& budget) override {
    FrameRun frame(*this, drives, budget);
    HalvedPushing pushing(frame, effects_);
    move(frame, pushing);
    return std::move(frame.result);
  }
};

class SweepEngine : public CellEngine {
public:
  std::unique_ptr<Engine> copy() const override { return nullptr; }
  explicit SweepEngine(std::unique_ptr<WorldObjects> of) : CellEngine(std::move(of)) {
    for (DeformableObject& body : world().bodies)
      body.set_by_limits(relax_sweep);
  }
  FrameResult advance(std::span<const deform::Drive> drives, const FrameBudget& budget) override {
    for (int object = 0; object < world().n_objects(); ++object) // sweeps continue from frame to frame
      world().member(object).is_unsettled = world().is_body(object);
    FrameResult result = CellEngine::advance(drives, budget);
    if (result.status == Status::clamped && result.message.find("stays as it is") != std::string::npos)
      result.status = Status::budget_reached;
    return result;
  }
};

Index3 cell_of(const Vector3d& place) {
  return cell_at({place[0], place[1], place[2]});
}

class HandOnEngine : public Engine {
public:
  explicit HandOnEngine(std::unique_ptr<WorldObjects> of)
      : Engine(std::move(of)), cell_size_(Vector3d::Map(world().scene.spacing.data())),
        map_(world().scene.cells) {
    for (int object = 0; object < world().n_objects(); ++object) {
      first_.push_back(static_cast<VoxelId>(voxels_.size()));
      if (world().is_body(object)) {
        for (const InCells& at : world().body(object).lattice().places(displacement(object)))
          voxels_.push_back({{at[0], at[1], at[2]}, object});
        continue;
      }
      const RigidShape& shape = world().rigid.shape(world().member(object).index);
      for (std::int32_t i = 0; i < shape.n_voxels(); ++i) {
        Vector3d place = (pose(object).position + shape.centre_of(i)).cwiseQuotient(cell_size_);
        place.tail(3 - world().scene.dimension).setConstant(0.5);
        voxels_.push_back({place, object});
      }
    }
    first_.push_back(static_cast<VoxelId>(voxels_.size()));
    for (VoxelId id = 0; id < first_.back(); ++id) {
      start_.push_back(voxel(id).place);
      if (!map_.has_cell(cell_of(start_.back())) || !map_.put(cell_of(start_.back()), id))
        throw std::invalid_argument("World: hand_on: object `" + world().name(voxel(id).object) +
                                    "` has two voxels in a cell, or one in a cell of another");
    }
    for (int i = 0; i < world().rigid.n_objects(); ++i)
      start_poses_.push_back(world().rigid.pose(i));
  }

  FrameResult advance(std::span<const deform::Drive> drives, const FrameBudget& budget) override {
    FrameRun frame(*this, drives, budget);
    for (const deform::Drive& drive : drives) {
      if (drive.lead || (!world().is_body(drive.object) && drive.motion.angle != 0))
        throw std::invalid_argument("Drive: hand_on shifts rigid objects, without turns or a spring");
      for (const std::int64_t node : drive.nodes)
        world().body(drive.object).handles()[node];
    }
    fix_voxels();
    const int n = std::min(frame.n_steps(), 1'000'000);
    if (!frame.clock.rounds_left)
      frame.clock.rounds_left = std::int64_t{n} * iteration_cap;
    bool has_settled = true;
    for (int step = 0; step < n && frame.clock.has_budget(); ++step) {
      for (std::size_t i = 0; i < drives.size(); ++i) {
        const RigidMotion& motion = drives[i].motion;
        if (!world().is_body(drives[i].object)) {
          const Vector3d by = (motion.by / n).cwiseQuotient(cell_size_);
          frame.done[i] += move_rigid(drives[i].object, by) / n;
          continue;
        }
        std::vector<Vector3d> by;
        for (const Vector3d& from : frame.nodes_before[i])
          by.push_back((moved_point(part_of(motion, 0, (step + 1.0) / n), from) -
                        moved_point(part_of(motion, 0, static_cast<double>(step) / n), from))
                           .cwiseQuotient(cell_size_));
        move_nodes(drives[i], by);
      }
      has_settled = sweep_to_rest(frame);
    }
    hand_back();
    frame.report_drives();
    frame.report_end(has_settled, "bodies are on their way to rest", "bodies are on their way to rest");
    for (int object = 0; object < world().n_objects(); ++object)
      world().member(object).is_unsettled = world().is_body(object) && !is_converged(frame.result.status);
    return std::move(frame.result);
  }

  double largest_violation() const override { return 0; } ///< sweeps satisfy limits only in the end

private:
  struct Voxel {
    Vector3d place; ///< [cells]; unused components are 1/2
    int object;
    bool is_fixed = false;
  };
  struct Met {
    double time;
    VoxelId voxel; ///< the empty id: the border
  };

  Voxel& voxel(VoxelId id) { return voxels_[static_cast<std::size_t>(id)]; }
  VoxelId first(int object) const { return first_[static_cast<std::size_t>(object)]; }

  /// Fixes voxels: fixed objects, held nodes, nodes in a hand, rigid objects of several voxels or in a hand.
  void fix_voxels() {
    for (int object = 0; object < world().n_objects(); ++object) {
      const WorldObjects::Member& member = world().member(object);
      const bool is_fixed =
          member.kind == ObjectKind::fixed || member.is_driven || first(object + 1) - first(object) > 1;
      for (VoxelId id = first(object); id < first(object + 1); ++id)
        voxel(id).is_fixed = !world().is_body(object) && is_fixed;
      if (!world().is_body(object))
        continue;
      const DeformableObject& body = world().body(object);
      for (const Prescribed& p : body.scene().prescribed)
        voxel(first(object) + body.lattice().voxel(p.node)).is_fixed = true;
      for (const auto& [node, handle] : body.handles())
        voxel(first(object) + body.lattice().voxel(node)).is_fixed = true;
    }
  }

  /// First obstacle on a straight path, a voxel or the border; voxels of the same rigid object do not count.
  std::optional<Met> met(VoxelId id, const Vector3d& by) const {
    const Voxel& moving = voxels_[static_cast<std::size_t>(id)];
    const auto in_cell = [&](const Index3& cell) -> std::optional<VoxelId> {
      if (!map_.is_blocked(cell))
        return std::nullopt;
      const VoxelId other = map_.has_cell(cell) ? map_.occupant(cell) : no_voxel;
      const bool is_own = other == id || (other != no_voxel && !world().is_body(moving.object) &&
                                          voxels_[static_cast<std::size_t>(other)].object == moving.object);
      return is_own ? std::nullopt : std::optional(other);
    };
    CellWalk walk(moving.place, by, cell_of(moving.place));
    while (const auto step = walk.next(1))
      if (const auto there = in_cell(walk.cell()))
        return Met{step->time, *there};
    if (const auto there = in_cell(cell_of(moving.place + by))) // on a face, or rounded across one
      return Met{1, *there};
    return std::nullopt;
  }

  void put(VoxelId id, const Vector3d& place) {
    map_.take(cell_of(voxel(id).place));
    voxel(id).place = place;
    if (!map_.put(cell_of(place), id))
      throw std::logic_error("hand_on: two voxels in a cell");
  }

  /// @return motion of the voxel itself
  Vector3d hand_on(VoxelId id, Vector3d rest) {
    const VoxelId asked = id;
    Vector3d own = Vector3d::Zero();
    while (id != no_voxel && !rest.isZero(0) && !voxel(id).is_fixed) {
      const auto obstacle = met(id, rest);
      const Vector3d moved =
          (obstacle ? std::max(0.0, obstacle->time - tolerance / rest.cwiseAbs().maxCoeff()) : 1.0) * rest;
      put(id, voxel(id).place + moved);
      own += id == asked ? moved : Vector3d::Zero();
      rest -= moved;
      id = obstacle ? obstacle->voxel : no_voxel;
    }
    return own;
  }

  /// Passes the rest of the movement once to the obstacles of the object's voxels, then moves as far as
  /// possible.
  double move_rigid(int object, const Vector3d& by) {
    if (by.isZero(0))
      return 1;
    const VoxelId begin = first(object), end = first(object + 1);
    for (VoxelId id = begin; id < end; ++id)
      if (const auto obstacle = met(id, by); obstacle && obstacle->voxel != no_voxel)
        hand_on(obstacle->voxel, (1 - obstacle->time) * by);
    double part = 1;
    for (VoxelId id = begin; id < end; ++id)
      if (const auto obstacle = met(id, by))
        part = std::min(part, std::max(0.0, obstacle->time - tolerance / by.cwiseAbs().maxCoeff()));
    for (VoxelId id = begin; id < end; ++id)
      map_.take(cell_of(voxel(id).place));
    for (VoxelId id = begin; id < end; ++id) {
      voxel(id).place += part * by;
      map_.put(cell_of(voxel(id).place), id);
    }
    return part;
  }

  /// Moves the nodes in a hand, the foremost first.
  void move_nodes(const deform::Drive& drive, const std::vector<Vector3d>& by) {
    const DeformableObject& body = world().body(drive.object);
    const auto id_of = [&](std::size_t i) {
      return first(drive.object) + body.lattice().voxel(drive.nodes[i]);
    };
    std::vector<std::size_t> order(by.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, std::greater(),
                             [&](std::size_t i) { return voxel(id_of(i)).place.dot(by[i]); });
    for (const std::size_t i : order)
      voxel(id_of(i)).is_fixed = std::ranges::any_of(
          body.scene().prescribed, [&](const Prescribed& p) { return p.node == drive.nodes[i]; });
    for (const std::size_t i : order)
      hand_on(id_of(i), by[i]);
    for (const std::size_t i : order)
      voxel(id_of(i)).is_fixed = true;
  }

  /// Moves every free node to the mean of its linked neighbours within its limits; incompatible limits use
  /// their middle. @return largest motion of a node [cells]
  double sweep(int object) {
    const DeformableObject& body = world().body(object);
    const LinkTable table(body.scene(), body.limits());
    const bool is_elastic = body.scene().relaxation.mode == RelaxationMode::elastic;
    const auto u = [&](std::int32_t node, int b) {
      const auto id = first(object) + node;
      return (voxel(id).place[b] - start_[static_cast<std::size_t>(id)][b]) * cell_size_[b];
    };
    double furthest = 0;
    for (std::int32_t node = 0; node < table.n_nodes(); ++node) {
      const auto begin = static_cast<std::size_t>(table.first()[static_cast<std::size_t>(node)]),
                 end = static_cast<std::size_t>(table.first()[static_cast<std::size_t>(node) + 1]);
      if (voxel(first(object) + node).is_fixed || begin == end)
        continue;
      Vector3d by = Vector3d::Zero();
      for (int b = 0; b < world().scene.dimension; ++b) {
        double sum = 0, low = -std::numeric_limits<double>::infinity(), high = -low;
        for (std::size_t e = begin; e < end; ++e) {
          const double other = u(table.neighbour()[e], b);
          sum += other;
          low = std::max(low, other + table.below(b)[e]);
          high = std::min(high, other + table.above(b)[e]);
        }
        const double now = u(node, b), wanted = is_elastic ? sum / static_cast<double>(end - begin) : now;
        by[b] = ((low > high ? 0.5 * low + 0.5 * high : std::clamp(wanted, low, high)) - now) / cell_size_[b];
      }
      if (by.cwiseAbs().maxCoeff() > rounding)
        furthest = std::max(furthest, hand_on(first(object) + node, by).cwiseAbs().maxCoeff());
    }
    return furthest;
  }

  /// Runs the sweeps of each body in a frame, or until nothing moves. @return true if nothing moves
  bool sweep_to_rest(FrameRun& frame) {
    for (std::int64_t n = 0; frame.clock.has_budget(); ++n) {
      double furthest = 0;
      bool is_over = true;
      for (int object = 0; object < world().n_objects(); ++object)
        if (world().is_body(object) && n < world().body(object).scene().relaxation.sweeps) {
          is_over = false;
          furthest = std::max(furthest, sweep(object));
        }
      if (is_over)
        break;
      frame.clock.count_round();
      if (furthest < negligible)
        return true;
    }
    return world().bodies.empty();
  }

  void hand_back() {
    std::vector<Pose> poses = start_poses_;
    for (int object = 0; object < world().n_objects(); ++object)
      if (!world().is_body(object))
        poses[static_cast<std::size_t>(world().member(object).index)].position +=
            (voxel(first(object)).place - start_[static_cast<std::size_t>(first(object))])
                .cwiseProduct(cell_size_);
    world().rigid.place(poses);
    for (int object = 0; object < world().n_objects(); ++object) {
      if (!world().is_body(object))
        continue;
      DeformableObject& body = world().body(object);
      Displacement state = body.displacement();
      for (std::int32_t i = 0; i < body.lattice().n_voxels(); ++i) {
        const Vec3 u =
            body.lattice().displacement_at(i, voxel(first(object) + i).place.cwiseProduct(cell_size_));
        for (int b = 0; b < world().scene.dimension; ++b)
          state(b, body.lattice().node(i)) = u[static_cast<std::size_t>(b)];
      }
      body.put_at(world().map(), state);
      body.settle_handles();
    }
  }

  Vector3d cell_size_;
  OccupancyMap map_;
  std::vector<Voxel> voxels_;
  std::vector<VoxelId> first_;  ///< by object, and an end entry
  std::vector<Vector3d> start_; ///< rest position by voxel
  std::vector<Pose> start_poses_;
};

} // namespace maille::test::loops

namespace maille::test {

/// @param loop  halving, sweep or hand_on
inline deform::World world_of_1995(const std::string& loop, WorldScene scene) {
  if (loop != "halving")
    scene.method = "limits"; // obeyed by sweeps
  auto objects = std::make_unique<deform::WorldObjects>(std::move(scene));
  if (loop == "halving")
    return deform::World(std::make_unique<loops::HalvingEngine>(std::move(objects)));
  if (loop == "sweep")
    return deform::World(std::make_unique<loops::SweepEngine>(std::move(objects)));
  if (loop == "hand_on")
    return deform::World(std::make_unique<loops::HandOnEngine>(std::move(objects)));
  throw std::invalid_argument("World: halving, sweep and hand_on are the loops of 1995, `" + loop +
                              "` is not");
}

} // namespace maille::test
