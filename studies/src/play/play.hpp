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

/// What became of one drive of a frame.
struct PlayedDrive {
  int object = 0;
  double fraction = 0;   ///< of the frame's motion that was done; see deform::MoveResult for sliding
  Eigen::Vector3d force; ///< that the hand needs [N]; zero where the method knows no forces
};

/// Voxels of one object that press against another, or against the world's border (-1).
struct PlayedContact {
  int object = 0, other = -1;
  std::int64_t voxels = 0;
  Eigen::Vector3d force; ///< on the first of the two [N]; zero where the method knows no forces
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
  std::int64_t handed_on = 0; ///< movements that were handed on from one voxel to another
  double moved_on = 0;        ///< what their receivers moved, all together [m]
};

/// A world and the input that it is given. Frames follow one another; each ends in a feasible state.
class Player {
public:
  Player(deform::World world, Trajectory trajectory);

  bool is_at_end() const { return n_played_ == trajectory_.n_frames; }
  /// Plays the next frame. @param control threads and stop; a frame that was stopped has status interrupted
  /// @pre not is_at_end()
  PlayedFrame next(const Control& control = {});
  /// The world as it is.
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
  std::vector<std::size_t> active_;            ///< spans that have begun and not ended
  std::size_t next_span_ = 0;
  std::int64_t n_played_ = 0;
  WorldMoment moment_;
};

/// Cells of matter in the matter of another object or outside, and voxels in cells of others.
std::int64_t penetrations_of(const deform::World& world);
/// Everything that was played, for programs.
nlohmann::ordered_json json(const Player& player, const std::vector<PlayedFrame>& frames);
/// The same in a few lines, for people.
std::string in_words(const Player& player, const std::vector<PlayedFrame>& frames);

/// True if there is an `ffmpeg` to run.
bool has_ffmpeg();
/// Makes a film of pictures that are numbered from 0.
/// @param stem of the pictures: `stem_0000.png`, ... @param n_digits of their numbers
/// @param n_pictures that the film shows: others of that name may lie beside them
/// @return nothing, or why there is no film; its file appears whole or not at all
[[nodiscard]] std::optional<std::string> make_film(const std::filesystem::path& stem, int n_digits,
                                                   std::int64_t n_pictures, double frame_seconds,
                                                   const std::filesystem::path& mp4);

} // namespace maille::studies
