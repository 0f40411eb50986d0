#pragma once
/// Contact by surfaces, in frames.
///
/// A frame moves hands by steps so short that surfaces on a collision course see one another, and lets rounds
/// of Balance find the state in which all forces balance, after each step. A hand that has forced something
/// into a rigid object goes back by its step and stops; where objects would overlap without a corner of
/// either inside the other, all go back to the state before the step, and the frame ends.
///
/// SurfaceFrame has the steps; SurfaceEngine (no masses), ImpactEngine and InertiaEngine (dynamics/) say in
/// which order they are taken.

#include "world/balance/balance.hpp"
#include "world/frame_run.hpp"

#include <optional>
#include <set>
#include <utility>

namespace maille::deform {

class SurfaceFrame {
public:
  SurfaceFrame(FrameRun& frame, Balance& balance) : frame_(frame), world_(frame.world), balance_(balance) {}

  FrameRun& frame() { return frame_; }
  /// All of a frame without masses.
  void move_in_balance();

  /// Nodes that a hand now has.
  void take_handles();
  /// Steps of a frame that rounds can follow.
  int n_steps() const;
  void drive(int step, int n);
  std::optional<std::pair<int, int>> goes_back(const Balance::State& before, int step, int n);
  bool take_back(int step, int n);
  bool settle(bool is_last = true);
  void find_blocked(int n);
  void report(bool has_settled);

private:
  void put_handles(std::size_t i, double part);
  bool is_forced_in(int object) const;

  FrameRun& frame_;
  WorldObjects& world_;
  Balance& balance_;
  std::set<std::size_t> blocked_; ///< drives that something rigid has stopped
};

class SurfaceEngine : public Engine {
public:
  /// @throws std::invalid_argument naming an object that cannot be carried
  explicit SurfaceEngine(std::unique_ptr<WorldObjects> world);

  FrameResult advance(std::span<const Drive> drives, const FrameBudget& budget) override;

protected:
  virtual void move(SurfaceFrame& surfaces) { surfaces.move_in_balance(); }

  Balance balance_;
};

} // namespace maille::deform
