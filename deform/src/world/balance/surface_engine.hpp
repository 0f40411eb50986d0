#pragma once
/// Frames with surface contact.
///
/// A frame moves drives by steps short enough to detect surfaces on a collision course. After each step,
/// rounds of Balance find the equilibrium. A drive that has forced nodes into a rigid object goes back by its
/// step and stops. If objects would overlap without a corner of either inside the other, all objects return
/// to the state before the step, and the frame ends.
///
/// SurfaceFrame implements the steps; SurfaceEngine (no masses), ImpactEngine and InertiaEngine (dynamics/)
/// define their order.

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
  /// Runs a whole frame without masses.
  void move_in_balance();

  /// Makes the driven nodes handles.
  void take_handles();
  /// Number of drive steps of a frame, short enough for collision detection.
  int n_steps() const;
  void drive(int step, int n);
  std::optional<std::pair<int, int>> restore_if_overlapping(const Balance::State& before, int step, int n);
  bool retract_blocked_drives(int step, int n);
  bool settle(bool is_last = true);
  void find_blocked(int n);
  void report(bool has_settled);

private:
  void put_handles(std::size_t i, double part);
  bool is_forced_in(int object) const;

  FrameRun& frame_;
  WorldObjects& world_;
  Balance& balance_;
  std::set<std::size_t> blocked_; ///< drives stopped by rigid objects
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
