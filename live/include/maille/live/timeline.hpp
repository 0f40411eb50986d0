#pragma once
/// A world and the history of its manipulation: frames with undo and redo, and a file of them.

#include "maille/deform/world/trajectory_drives.hpp"
#include "maille/deform/world/world.hpp"
#include "maille/scene/world/trajectory.hpp"

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace maille::live {

/// Frames from the start of the world to now. The input of a frame is read back from the text of its rows in
/// the file, so replaying the file gives the same bits, unless a time budget ends frames.
///
/// Steps back restore the nearest earlier copy of the world and replay from there. A changed constant applies
/// to all frames: the recorded movements are replayed with it.
class Timeline {
public:
  /// @param record file that always contains the frames up to now; nothing: no file
  /// @throws std::invalid_argument as World; std::runtime_error if the file cannot be written
  Timeline(WorldScene scene, std::vector<WorldSetting> settings,
           const std::optional<std::filesystem::path>& record);
  ~Timeline();
  Timeline(const Timeline&) = delete;
  Timeline& operator=(const Timeline&) = delete;

  const deform::World& world() const { return *world_; }
  const deform::TrajectoryDrives& drives() const { return *drives_; }
  /// The scene with its settings.
  const WorldScene& scene() const { return world_->scene(); }
  const std::vector<WorldSetting>& settings() const { return settings_; }

  /// See World::prepare.
  void prepare(const deform::FrameBudget& budget) { world_->prepare(budget); }
  /// Starts a gesture: undo() reverts all frames of a gesture together.
  void begin_gesture();
  /// Plays a new frame after the present one; discards undone frames.
  /// @param spans of one frame; their frame numbers are ignored
  deform::FrameResult add_frame(std::vector<DriveSpan> spans, const deform::FrameBudget& budget = {});
  /// Continues the motion of unsettled bodies, in a frame without rows.
  deform::FrameResult settle(const deform::FrameBudget& budget);

  std::int64_t frame() const { return played_; }
  std::int64_t n_frames() const { return static_cast<std::int64_t>(frames_.size()); }
  bool can_redo() const { return played_ < n_frames(); }
  /// @param budget of each replayed frame; a stop request leaves the world at the last replayed frame
  void undo(const deform::FrameBudget& budget = {});
  void redo(const deform::FrameBudget& budget = {});
  /// @param frame 0 to n_frames()
  void go_to(std::int64_t frame, const deform::FrameBudget& budget = {},
             const std::function<void()>& at_each = {});
  /// Changes a constant and replays all frames.
  /// @throws InputError, std::invalid_argument; then the state is unchanged
  void change(const WorldSetting& setting, const deform::FrameBudget& budget = {},
              const std::function<void()>& at_each = {});

  /// Present text of the file.
  std::string text() const;
  /// Reason that writing the file failed; empty if it did not.
  const std::string& record_fault() const { return record_fault_; }

private:
  deform::FrameResult play(const std::vector<DriveSpan>& spans, const deform::FrameBudget& budget);
  std::vector<DriveSpan> as_read(std::vector<DriveSpan>& spans, std::string& rows) const;
  void keep_copy();
  void restart(std::int64_t at_most);
  void append(const std::string& rows);
  void rewrite();

  WorldScene base_;
  std::vector<WorldSetting> settings_;
  std::optional<std::filesystem::path> record_;
  std::FILE* file_ = nullptr;
  std::string record_fault_;
  std::unique_ptr<deform::World> world_;
  std::unique_ptr<deform::TrajectoryDrives> drives_;
  struct Frame {
    std::vector<DriveSpan> spans;
    std::string rows;
    bool begins_gesture = false;
  };
  std::vector<Frame> frames_;
  std::int64_t played_ = 0;
  bool gesture_begins_ = true;
  std::map<std::int64_t, deform::World> copies_; ///< by the number of frames played
};

} // namespace maille::live
