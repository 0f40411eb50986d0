#pragma once
/// A deformable object that nothing else shares its world with: no map, no walls, each frame one question.

#include "elastic/kept_answers.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/world/world.hpp"

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace maille::deform {

/// Unused displacements that are overwritten for reuse: a frame of a large body need not wait for fresh
/// memory, which takes a quarter of a second for 128^3 nodes. Thread-safe.
class SpareStates {
public:
  /// As many as a picture and a hand hold at once: newest and last asked for, painted and seen.
  static constexpr std::size_t most = 5;

  /// Has some before they are asked for. @param is_stopped asked before each
  void prepare(const Grid& grid, const std::function<bool()>& is_stopped);
  /// One of a body, given back by itself. What is in it is of an earlier state of that body, or zero.
  static std::shared_ptr<Displacement> take(const std::shared_ptr<SpareStates>& from, const Grid& grid);

private:
  std::mutex lock_;
  std::vector<std::unique_ptr<Displacement>> spare_;
};

/// By `limits` a Drag, at the cost of what moves; else the method's answer to holds and handles, which does
/// not depend on the way there unless frames have a budget of seconds: then each answer begins with those
/// before it, so that frames that were cut short get there in the end.
class LoneBody {
public:
  /// @throws std::invalid_argument where the method cannot carry it
  LoneBody(const WorldObject& object, const WorldScene& world);
  LoneBody(LoneBody&&) = default;

  /// As World::advance.
  FrameResult advance(std::span<const Drive> drives, const FrameBudget& budget);
  /// As World::release.
  void release();
  const Displacement& displacement() const { return *state_; }
  std::shared_ptr<const Displacement> shared_displacement() const { return state_; }
  /// As World::prepare.
  void prepare(const FrameBudget& budget);
  Eigen::Vector3d position(std::int64_t node) const;
  bool is_settled() const { return !is_unsettled_; }
  /// As World::question.
  Scene question() const;
  double largest_violation() const;
  std::int64_t bytes() const;
  /// Nothing by `limits`: a Drag has no copies.
  std::optional<LoneBody> copy() const;

private:
  LoneBody(const LoneBody& other);

  void drag(std::span<const Drive> drives, FrameResult& result);
  void relax(std::span<const Drive> drives, const FrameBudget& budget, FrameResult& result);
  Answer ask(const Scene& question, const Control& control);
  /// Where a drive wants a node: its displacement [m].
  Vec3 wanted(const Drive& drive, std::int64_t node) const;
  void report(std::span<const Drive> drives, const std::vector<std::vector<Eigen::Vector3d>>& before,
              FrameResult& result) const;

  std::unique_ptr<Scene> scene_; ///< with holds alone
  std::string method_;
  std::unique_ptr<LinkLimits> limits_; ///< of scene_; null where none bind
  std::optional<Drag> drag_;           ///< by `limits`
  std::shared_ptr<SpareStates> spare_ = std::make_shared<SpareStates>();
  std::shared_ptr<const Displacement> state_;
  std::unique_ptr<KeptAnswers> kept_;    ///< of `coupled`
  std::map<std::int64_t, Vec3> handles_; ///< driven nodes and where they are [m]
  bool is_unsettled_ = false;
};

} // namespace maille::deform
