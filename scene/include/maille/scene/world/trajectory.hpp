#pragma once
/// Recorded input: what the objects of a world are asked to do, frame by frame, in place of a mouse or a
/// device in the hand.

#include "maille/scene/world/world_scene.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace maille {

/// Numbers of nodes in an order of their own, as runs of successive ones; copies share them.
class NodeRuns {
public:
  NodeRuns() = default;
  NodeRuns(const std::vector<std::int64_t>& nodes); // NOLINT: stands for the list
  operator std::vector<std::int64_t>() const;       // NOLINT
  bool empty() const { return !runs_; }
  std::int64_t bytes() const { return runs_ ? std::int64_t{sizeof(Run)} * std::ssize(*runs_) : 0; }
  friend bool operator==(const NodeRuns& one, const NodeRuns& other) {
    return one.runs_ == other.runs_ || (one.runs_ && other.runs_ && *one.runs_ == *other.runs_);
  }

private:
  using Run = std::array<std::int64_t, 2>; ///< first and last
  std::shared_ptr<const std::vector<Run>> runs_;
};

/// A movement asked of one object, or of some nodes of a deformable one, in equal steps over some frames.
struct DriveSpan {
  std::size_t object = 0;       ///< of WorldScene::objects
  NodeRuns nodes;               ///< of a deformable object's grid; empty for rigid ones
  std::int64_t first_frame = 1; ///< counted from 1: frame 0 is the world as the scene has it
  std::int64_t n_frames = 1;
  Vec3 by{}; ///< all frames together [m]
  std::optional<Vec3>
      to; ///< in place of `by`: where the origin of a rigid object's frame is to be in the last frame [m]
  Vec3 axis{0, 0, 1}; ///< of the turn, in the world's axes, of length 1
  double angle = 0;   ///< all frames together, right-handed [rad]
  /// A point of the turn's axis, in the object's frame [m]; absent: the middle of the object's box
  std::optional<Vec3> about;
  bool slide = false; ///< of rigid objects: what is left after a contact goes on along what was met
  /// For rigid objects: stiffness of the spring by which the hand leads the object [N/m]; absent: rigid grip
  std::optional<double> follow;
  bool release = false; ///< the hand releases the object

  std::int64_t end_frame() const { return first_frame + n_frames; } ///< the first that it has no part in
};

/// A constant of the world that the hand has changed, for the whole trajectory.
struct WorldSetting {
  std::optional<std::size_t> object; ///< of WorldScene::objects; nothing: of the world
  std::string name; ///< `method`; of a deformable object `stiffness` or `limits`; `tool`, see apply_settings
  std::string value;
  friend bool operator==(const WorldSetting&, const WorldSetting&) = default;
};

struct Trajectory {
  std::string name;                   ///< the file's, without its ending
  double frame_seconds = 1.0 / 30;    ///< from one frame to the next
  std::int64_t n_frames = 0;          ///< beside frame 0
  std::vector<DriveSpan> spans;       ///< by their first frames, then as the file has them
  std::vector<WorldSetting> settings; ///< in the file's order: of several for one constant the last counts
};

/// Reads a trajectory for a world: a file that ends in .csv as a table with a row a drive and frame, any
/// other as TOML. docs/world.md says what stands in them.
/// @throws InputError with every fault (file, line, key, expected, found)
Trajectory read_trajectory(const std::filesystem::path& file, const WorldScene& world);

/// The world that a trajectory is for, with its settings:
///
///   method     limits, relaxed or coupled
///   stiffness  of an object: a factor > 0 on all of its moduli
///   limits     of an object: `material`, `none`, or three ratios of a link's length: stretch >= 1, compress
///              from 0 to 1, shear >= 0
///   tool       a ball for the hand: its radius and where its middle begins, four lengths [m]. It is the
///              world's last object, rigid, of voxels of the world's spacing; radius 0: one voxel
/// @throws InputError naming what the world cannot have
void apply_settings(const std::vector<WorldSetting>& settings, WorldScene& world);

/// The name of an object that a setting `tool` brings.
inline constexpr std::string_view tool_name = "tool";

/// Rows of a table that read_trajectory reads back to the same spans, bit for bit: the first names the
/// columns.
std::string trajectory_header();
/// @param span of one frame
std::string trajectory_row(const DriveSpan& span, const WorldScene& world);
std::string trajectory_row(const WorldSetting& setting, const WorldScene& world);
/// Row of a frame without a drive.
std::string trajectory_row(std::int64_t frame);

/// The same from text; `file` gives the name for messages, and its ending counts.
Trajectory parse_trajectory(std::string_view text, const std::filesystem::path& file,
                            const WorldScene& world);

} // namespace maille
