#pragma once
/// A world and everything that a hand has done with it: frames that can be gone back to, and a file of them.

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

/// Frames from the world's begin to now. What is asked of a frame is what its rows in the file say, read back
/// from their text, so that the file played again gives the same bits, unless a budget of seconds ends
/// frames.
///
/// Steps back go to the nearest copy of the world that was kept, and play from there. A changed constant is
/// that of all frames: the hand's movements so far are played again with it.
class Timeline {
public:
  /// @param record file that always holds the frames up to now; nothing: none
  /// @throws std::invalid_argument as World; std::runtime_error where the file cannot be written
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
  /// What follows belongs together: undo() takes it back as a whole.
  void begin_gesture();
  /// Plays a new frame after the present one; frames that were undone are gone.
  /// @param spans of one frame; their frame numbers are of no account
  deform::FrameResult add_frame(std::vector<DriveSpan> spans, const deform::FrameBudget& budget = {});
  /// Lets bodies that have not settled go on, in a frame without rows.
  deform::FrameResult settle(const deform::FrameBudget& budget);

  std::int64_t frame() const { return played_; }
  std::int64_t n_frames() const { return static_cast<std::int64_t>(frames_.size()); }
  bool can_redo() const { return played_ < n_frames(); }
  /// @param budget of each frame that is played again; where it is asked to stop, the world stays at the
  ///        frame that it has come to
  void undo(const deform::FrameBudget& budget = {});
  void redo(const deform::FrameBudget& budget = {});
  /// @param frame 0 to n_frames()
  void go_to(std::int64_t frame, const deform::FrameBudget& budget = {},
             const std::function<void()>& at_each = {});
  /// Changes a constant, and plays what there is so far again.
  /// @throws InputError, std::invalid_argument: then nothing has changed
  void change(const WorldSetting& setting, const deform::FrameBudget& budget = {},
              const std::function<void()>& at_each = {});

  /// The file as it is now, as text.
  std::string text() const;
  /// Why the file could not be written any more; empty where it could.
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
  std::map<std::int64_t, deform::World> copies_; ///< by the frames that they are after
};

} // namespace maille::live
