#pragma once
/// A deformable object that nothing else shares its world with: no map, no walls, each frame one question.

#include "elastic/kept_answers.hpp"
#include "maille/deform/drag.hpp"
#include "world/frame_run.hpp"

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
class OpenBody : public Engine {
public:
  /// @param state  null: at rest @throws std::invalid_argument where the method cannot carry it
  explicit OpenBody(std::unique_ptr<WorldObjects> world, std::shared_ptr<const Displacement> state = nullptr);

  FrameResult advance(std::span<const Drive> drives, const FrameBudget& budget) override;
  void release(int object) override;
  /// An answer to what holds alone: no iteration, but all that it takes to begin.
  void prepare(const FrameBudget& budget) override;
  bool is_settled() const override { return !is_unsettled_; }
  /// Null by `limits`: a Drag has no copies.
  std::unique_ptr<Engine> copy() const override;
  const Pose& pose(int) const override { return pose_; }
  const Displacement& displacement(int) const override { return *state_; }
  std::shared_ptr<const Displacement> shared_displacement(int) const override { return state_; }
  Eigen::Vector3d position(int, std::int64_t node) const override { return position(node); }
  Scene question(int) const override { return question(); }
  double largest_violation() const override;
  std::int64_t bytes() const override;

private:
  void drag(FrameRun& frame);
  void relax(FrameRun& frame);
  Answer answer(const Scene& question, const Control& control);
  Scene question() const;
  Eigen::Vector3d position(std::int64_t node) const;
  /// Where a drive wants a node: its displacement [m].
  Vec3 wanted(const Drive& drive, std::int64_t node) const;

  std::unique_ptr<Scene> scene_; ///< with holds alone
  std::string method_;
  std::unique_ptr<LinkLimits> limits_; ///< of scene_; null where none bind
  std::optional<Drag> drag_;           ///< by `limits`
  std::shared_ptr<SpareStates> spare_ = std::make_shared<SpareStates>();
  std::shared_ptr<const Displacement> state_;
  std::unique_ptr<KeptAnswers> kept_;    ///< of `coupled`
  std::map<std::int64_t, Vec3> handles_; ///< driven nodes and where they are [m]
  bool is_unsettled_ = false;
  Pose pose_; ///< the world's axes
};

} // namespace maille::deform
