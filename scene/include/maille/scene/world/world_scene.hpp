#pragma once
/// A world of several objects that share a grid of cells.
///
/// Made by the reader of scene files with `[[object]]` tables, or by tests; constant afterwards. SI units.

#include "maille/scene/scene.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

enum class ObjectKind {
  fixed,      ///< never moves
  rigid,      ///< moves as a whole, keeps its shape
  deformable, ///< its nodes move, within the limits of its links
};

/// How objects of a world are kept from overlapping.
enum class ContactLaw {
  cells,    ///< a cell of the world belongs to at most one object: contact at faces of cells
  surfaces, ///< surfaces do not penetrate; touching objects are in balance
};

/// Dynamics of a world: masses, momentum, energy. Without it, frames are quasi-static.
struct WorldDynamics {
  Vec3 gravity{};         ///< [m/s^2]
  double restitution = 0; ///< normal speed after an impact over that before, 0 to 1
  double damping = 0;     ///< of linear and angular velocity: v' = -damping v [1/s], >= 0
};

/// One object of a world.
struct WorldObject {
  std::string name;
  ObjectKind kind = ObjectKind::fixed;
  /// The object in its own frame. A fixed or rigid object uses only the specimen: each cell is a voxel. A
  /// deformable one also uses materials, plane, limits, relaxation, and the holds of `prescribed` (value 0,
  /// held); moves, loads and contracting fibres are ignored.
  Scene scene;
  Vec3 position{0, 0, 0};  ///< of the frame's origin in the world [m]
  Vec3 turn_axis{0, 0, 1}; ///< of length 1
  double turn_angle = 0;   ///< of the frame about its origin, right-handed about the axis [rad]
  /// For fixed and rigid objects with surface contact: use the smooth surface through the voxels, not their
  /// faces.
  bool is_smooth = false;
  // The next are used if the world has dynamics.
  double density = 1000; ///< of matter [kg/m^3], > 0
  Vec3 velocity{};       ///< initial velocity of the whole object [m/s]
};

/// The corner of the world is the origin; cell i covers [i, i + 1) spacings per axis; the border is a wall.
struct WorldScene {
  std::string name; ///< the file's name without its ending
  std::string title;
  int dimension = 3;                  ///< of the world and of all its objects
  Index3 cells{1, 1, 1};              ///< > 0, at most 2^15 per axis; 1 along axes beyond the dimension
  Vec3 spacing{1, 1, 1};              ///< of a cell [m], > 0
  double friction = 0;                ///< Coulomb's coefficient between objects, >= 0
  std::optional<double> frame_budget; ///< time limit per frame [s]; unset: until converged
  /// Method for deformable objects: limits, relaxed or coupled.
  std::string method = "coupled";
  ContactLaw contact = ContactLaw::cells;
  std::optional<WorldDynamics> dynamics; ///< unset: quasi-static
  std::vector<WorldObject> objects;
  /// True: a single deformable object in the world's frame, without cells of the world and without border.
  /// See world_of_body.
  bool is_open = false;
};

/// A world with one body, for interactive use: holds are kept; moves, loads and contracting fibres are
/// dropped. With `limits`, taut limits are those of the scene's own moves.
/// @param method limits, relaxed or coupled
/// @param[out] left_out features of the scene that this world lacks, in words
WorldScene world_of_body(const Scene& scene, std::string method, std::vector<std::string>& left_out);

/// True if a file can be read, is TOML, and has a [world]: then use read_world_scene, else read_scene, which
/// reports errors.
bool is_world_scene(const std::filesystem::path& file);

/// Reads a scene of objects; docs/world.md defines the format. Paths of images are relative to the file.
/// @throws InputError with every fault (file, line, key, expected, found)
WorldScene read_world_scene(const std::filesystem::path& file);

/// The same from text; `file` gives the name for messages and the folder for images.
WorldScene parse_world_scene(std::string_view text, const std::filesystem::path& file = "scene.toml");

} // namespace maille
