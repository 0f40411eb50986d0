#pragma once
/// Plays recorded input against a world of objects, frame by frame.

#include "export/world/world_files.hpp"
#include "maille/deform/world/trajectory_drives.hpp"
#include "maille/deform/world/world.hpp"
#include "maille/scene/world/trajectory.hpp"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

inline Vec3 array(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

/// Result of one drive of a frame.
struct PlayedDrive {
  int object = 0;
  double fraction = 0;   ///< completed fraction of the frame's motion; see deform::MoveResult for sliding
  Eigen::Vector3d force; ///< force needed by the hand [N]; zero for methods without forces
};

/// Voxels of one object in contact with another, or with the world's border (-1).
struct PlayedContact {
  int object = 0, other = -1;
  std::int64_t voxels = 0;
  Eigen::Vector3d force; ///< on the first object [N]; zero for methods without forces
};

struct PlayedFrame {
  std::int64_t number = 0;
  Status status = Status::done;
  std::string message;
  double seconds = 0;
  std::int64_t rounds = 0;
  std::optional<double> motion_left, force_left; ///< of FrameResult
  std::vector<PlayedDrive> drives;
  std::vector<PlayedContact> contacts;
  std::int64_t handed_on = 0; ///< number of movements passed from one voxel to another
  double moved_on = 0;        ///< total motion of the receiving voxels [m]
};

/// A world and its recorded input. Frames follow one another; each ends in a feasible state.
class Player {
public:
  Player(deform::World world, Trajectory trajectory);

  bool is_at_end() const { return n_played_ == trajectory_.n_frames; }
  /// Plays the next frame. @param control threads and stop; a stopped frame has status interrupted
  /// @pre not is_at_end()
  PlayedFrame next(const Control& control = {});
  /// Present state of the world.
  const WorldMoment& moment() const { return moment_; }
  const deform::World& world() const { return world_; }
  const Trajectory& trajectory() const { return trajectory_; }

private:
  std::vector<deform::Drive> drives();
  void look(const std::vector<deform::WorldContact>& contacts);

  Trajectory trajectory_;
  deform::World world_;
  deform::TrajectoryDrives drives_of_;
  std::vector<std::vector<Vec3>> start_nodes_; ///< of fixed and rigid objects, and of deformable ones at rest
  std::vector<std::size_t> active_;            ///< spans in progress
  std::size_t next_span_ = 0;
  std::int64_t n_played_ = 0;
  WorldMoment moment_;
};

/// Number of cells inside another object or outside the world, and of voxels in cells of other objects.
std::int64_t penetrations_of(const deform::World& world);
/// All played frames as JSON.
nlohmann::ordered_json json(const Player& player, const std::vector<PlayedFrame>& frames);
/// Summary of all played frames.
std::string in_words(const Player& player, const std::vector<PlayedFrame>& frames);

/// True if `ffmpeg` is installed.
bool has_ffmpeg();
/// Makes a film of pictures numbered from 0.
/// @param stem of the pictures: `stem_0000.png`, ... @param n_digits digits of their numbers
/// @param n_pictures number of pictures in the film; other files of that pattern may exist
/// @return nothing, or the reason of a failure; the film is written atomically
[[nodiscard]] std::optional<std::string> make_film(const std::filesystem::path& stem, int n_digits,
                                                   std::int64_t n_pictures, double frame_seconds,
                                                   const std::filesystem::path& mp4);

} // namespace maille::studies
