#pragma once
/// A world of several objects that share a grid of cells.
///
/// Made by the reader of scene files with `[[object]]` tables, or by tests, and not changed afterwards. SI
/// units.

#include "maille/scene/scene.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

enum class ObjectKind {
  fixed,      ///< never moves
  rigid,      ///< moves as a whole and keeps its form
  deformable, ///< its nodes move, within the limits of its links
};

/// How objects of a world are kept apart.
enum class ContactLaw {
  cells,    ///< a cell of the world belongs to one object: contact at faces of cells
  surfaces, ///< no surface passes into another, and all that touches is in balance
};

/// What a world has where time passes between its frames: masses, momentum, energy.
struct WorldDynamics {
  Vec3 gravity{};         ///< [m/s^2]
  double restitution = 0; ///< speed after an impact over that before, along the normal, 0 to 1
  double damping = 0;     ///< of speeds, also of turning: v' = -damping v [1/s], >= 0
};

/// One object of a world.
struct WorldObject {
  std::string name;
  ObjectKind kind = ObjectKind::fixed;
  /// The object in its own frame. A fixed or rigid object uses only the specimen: each cell is a voxel. A
  /// deformable one also uses materials, plane, limits and relaxation, and the holds of `prescribed` (value
  /// 0, held); moves, loads and contracting fibres are not used here.
  Scene scene;
  Vec3 position{0, 0, 0};  ///< of the frame's origin in the world [m]
  Vec3 turn_axis{0, 0, 1}; ///< of length 1
  double turn_angle = 0;   ///< of the frame about its origin, right-handed about the axis [rad]
  /// For fixed and rigid objects that meet with their surfaces: use the smooth surface through the voxels
  /// instead of their faces.
  bool is_smooth = false;
  // Where the world has dynamics.
  double density = 1000; ///< of matter [kg/m^3], > 0
  Vec3 velocity{};       ///< at the beginning, of all of it [m/s]
};

/// The world's corner is the origin; cell i covers [i, i + 1) spacings along each axis, and its border is a
/// wall.
struct WorldScene {
  std::string name; ///< the file's name without its ending
  std::string title;
  int dimension = 3;                  ///< of the world and of all its objects
  Index3 cells{1, 1, 1};              ///< > 0, at most 2^15 an axis; 1 along every axis beyond the dimension
  Vec3 spacing{1, 1, 1};              ///< of a cell [m], > 0
  double friction = 0;                ///< Coulomb's coefficient between objects, >= 0
  std::optional<double> frame_budget; ///< that a frame may take [s]; unset: until it has settled
  /// What moves deformable objects: limits, relaxed or coupled.
  std::string method = "coupled";
  ContactLaw contact = ContactLaw::cells;
  std::optional<WorldDynamics> dynamics; ///< unset: quasi-static
  std::vector<WorldObject> objects;
  /// One deformable object alone, its frame the world's: there are no cells and no border to run into. See
  /// world_of_body.
  bool is_open = false;
};

/// The world of one body alone, as a hand holds it: its holds stay, its moves, loads and contracting fibres
/// are left out. By `limits`, taut ones are those of the scene's own moves.
/// @param method limits, relaxed or coupled
/// @param[out] left_out what the scene asks for and this world does not have, in words
WorldScene world_of_body(const Scene& scene, std::string method, std::vector<std::string>& left_out);

/// Whether a file can be read, is TOML, and has a [world]: then it is for read_world_scene, else for
/// read_scene, which says what is wrong.
bool is_world_scene(const std::filesystem::path& file);

/// Reads a scene of objects; docs/world.md says what stands in it. Paths of images are relative to it.
/// @throws InputError with every fault (file, line, key, expected, found)
WorldScene read_world_scene(const std::filesystem::path& file);

/// The same from text; `file` gives the name for messages and the folder for images.
WorldScene parse_world_scene(std::string_view text, const std::filesystem::path& file = "scene.toml");

} // namespace maille
