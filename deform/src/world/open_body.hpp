#pragma once
/// A single deformable object without a map or walls: each frame is one question to its method.

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

/// Pool of displacements: a frame of a large body then does not wait for fresh memory, which takes a quarter
/// of a second for 128^3 nodes. Thread-safe.
class SpareStates {
public:
  /// Largest number in use by a display and a drive: the newest, last requested, drawn and shown ones.
  static constexpr std::size_t most = 5;

  /// Allocates displacements in advance. @param is_stopped polled before each
  void prepare(const Grid& grid, const std::function<bool()>& is_stopped);
  /// A displacement that returns to the pool on destruction. It contains an earlier state of the same body,
  /// or zeros.
  static std::shared_ptr<Displacement> take(const std::shared_ptr<SpareStates>& from, const Grid& grid);

private:
  std::mutex lock_;
  std::vector<std::unique_ptr<Displacement>> spare_;
};

/// With `limits` a Drag, whose cost depends on the moved region. Otherwise the method's answer to holds and
/// handles, which is independent of the path, except in frames with a budget of seconds: then each answer
/// starts from earlier ones, so that interrupted frames finally converge.
class OpenBody : public Engine {
public:
  /// @param state  null: at rest @throws std::invalid_argument if the method does not support the body
  explicit OpenBody(std::unique_ptr<WorldObjects> world, std::shared_ptr<const Displacement> state = nullptr);

  FrameResult advance(std::span<const Drive> drives, const FrameBudget& budget) override;
  void release(int object) override;
  /// Answers the question with holds only: makes the set-up without iterations.
  void prepare(const FrameBudget& budget) override;
  bool is_settled() const override { return !is_unsettled_; }
  /// Null for `limits`: a Drag cannot be copied.
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
  /// Displacement that a drive requests for a node [m].
  Vec3 wanted(const Drive& drive, std::int64_t node) const;

  std::unique_ptr<Scene> scene_; ///< with holds only
  std::string method_;
  std::unique_ptr<LinkLimits> limits_; ///< of scene_; null if none bind
  std::optional<Drag> drag_;           ///< for `limits`
  std::shared_ptr<SpareStates> spare_ = std::make_shared<SpareStates>();
  std::shared_ptr<const Displacement> state_;
  std::unique_ptr<KeptAnswers> kept_;    ///< of `coupled`
  std::map<std::int64_t, Vec3> handles_; ///< driven nodes and their displacements [m]
  bool is_unsettled_ = false;
  Pose pose_; ///< identity: the world's axes
};

} // namespace maille::deform
