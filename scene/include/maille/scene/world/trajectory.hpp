#pragma once
/// Recorded input: requested motions of the objects of a world, frame by frame, instead of a mouse or haptic
/// device.

#include "maille/scene/world/world_scene.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace maille {

/// Node numbers in a given order, stored as runs of consecutive numbers; copies share them.
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

/// A requested motion of one object, or of some nodes of a deformable one, in equal steps over some frames.
struct DriveSpan {
  std::size_t object = 0;       ///< of WorldScene::objects
  NodeRuns nodes;               ///< of a deformable object's grid; empty for rigid ones
  std::int64_t first_frame = 1; ///< from 1: frame 0 is the initial state of the scene
  std::int64_t n_frames = 1;
  Vec3 by{}; ///< all frames together [m]
  std::optional<Vec3>
      to;             ///< in place of `by`: requested origin of a rigid object's frame in the last frame [m]
  Vec3 axis{0, 0, 1}; ///< rotation axis in the world's axes, unit vector
  double angle = 0;   ///< all frames together, right-handed [rad]
  /// A point of the rotation axis, in the object's frame [m]; absent: the centre of the object's box
  std::optional<Vec3> about;
  bool slide = false; ///< for rigid objects: slide along the surface after a contact
  /// For rigid objects: stiffness of the spring from the hand to the object [N/m]; absent: rigid grip
  std::optional<double> follow;
  bool release = false; ///< the hand releases the object

  std::int64_t end_frame() const { return first_frame + n_frames; } ///< the first frame after the span
};

/// A constant of the world that the user has changed, for the whole trajectory.
struct WorldSetting {
  std::optional<std::size_t> object; ///< index into WorldScene::objects; unset: the world
  std::string name; ///< `method`; of a deformable object `stiffness` or `limits`; `tool`, see apply_settings
  std::string value;
  friend bool operator==(const WorldSetting&, const WorldSetting&) = default;
};

struct Trajectory {
  std::string name;                   ///< the file's, without its ending
  double frame_seconds = 1.0 / 30;    ///< from one frame to the next
  std::int64_t n_frames = 0;          ///< not counting frame 0
  std::vector<DriveSpan> spans;       ///< sorted by first frame, then in file order
  std::vector<WorldSetting> settings; ///< in file order: the last one for a constant applies
};

/// Reads a trajectory for a world: a .csv file as a table with one row per drive and frame, any other file as
/// TOML. docs/world.md defines the contents.
/// @throws InputError with every fault (file, line, key, expected, found)
Trajectory read_trajectory(const std::filesystem::path& file, const WorldScene& world);

/// Applies the settings of a trajectory to its world:
///
///   method     limits, relaxed or coupled
///   stiffness  of an object: a factor > 0 on all of its moduli
///   limits     of an object: `material`, `none`, or three ratios of a link's length: stretch >= 1, compress
///              from 0 to 1, shear >= 0
///   tool       a ball that the user moves: its radius and the start of its centre, four lengths [m]. It
///              becomes the world's last object, rigid, of voxels of the world's spacing; radius 0: one voxel
/// @throws InputError for settings that the world does not support
void apply_settings(const std::vector<WorldSetting>& settings, WorldScene& world);

/// Name of the object that a setting `tool` adds.
inline constexpr std::string_view tool_name = "tool";

/// Rows of a table that read_trajectory reads back to the same spans, bit for bit. The header names columns.
std::string trajectory_header();
/// @param span covers one frame
std::string trajectory_row(const DriveSpan& span, const WorldScene& world);
std::string trajectory_row(const WorldSetting& setting, const WorldScene& world);
/// Row of a frame without a drive.
std::string trajectory_row(std::int64_t frame);

/// The same from text; `file` gives the name for messages and, by its ending, the format.
Trajectory parse_trajectory(std::string_view text, const std::filesystem::path& file,
                            const WorldScene& world);

} // namespace maille
