#pragma once
/// Worlds that `studies/lab/run stability` asks, put together from boxes.

#include "checks/world_promises.hpp"
#include "stability/extremes.hpp"

#include <functional>
#include <string>
#include <vector>

namespace maille::lab {

/// Edge of a cell of all these worlds [m].
inline constexpr double world_cell = 1e-3;

/// Empty; cells of world_cell. @param cells as many as it has dimensions
WorldScene empty_world(const std::vector<int>& cells, const std::string& method,
                       ContactLaw contact = ContactLaw::cells);

/// A box of 10 kPa, without holds. By `limits` links may be from 0.3 to 1.5 of their length.
/// @param spacing of its cells, and where its corner is before it is turned about its middle [cells of the
/// world]
WorldObject box_in(const WorldScene& world, ObjectKind kind, const std::vector<int>& cells, double spacing,
                   const Vec3& corner, double angle = 0);

/// All components of the nodes on a face of the object's grid.
void hold_face(WorldObject& object, int axis, bool upper);
std::vector<std::int64_t> face_nodes(const WorldObject& object, int axis, bool upper);

/// Shift of the object, or of its nodes.
/// @param by of the whole, or of nodes [cells of the world]
deform::Drive shift_of(const WorldScene& world, std::size_t object, const Vec3& by,
                       std::vector<std::int64_t> nodes = {});
/// As many frames, each with the same drive.
void repeat(WorldPlay& play, const deform::Drive& drive, int frames);

/// A play that some methods are asked, and what it promises beside what every world does.
struct WorldQuestion {
  std::string extreme, setting;
  std::vector<std::string> methods;
  std::function<WorldPlay(const std::string& method)> play;
  std::function<LookAtFrame(const WorldPlay& play)> look = {};
  bool is_normal = false;
};
void add(const WorldQuestion& question, std::vector<Extreme>& list);

} // namespace maille::lab
