#pragma once
/// Converts holds, moves and loads to prescribed components: common to files and programs.

#include "conditions/region.hpp"
#include "maille/materials/toml_reader.hpp"

#include <functional>
#include <string>
#include <string_view>

namespace maille::reader {

struct Asked {
  std::string key;  ///< dotted path, e.g. `move[1].where`
  int line = 0;     ///< 0: from a program, without lines
  std::string text; ///< the actual value

  Asked at(std::string_view member) const { return {key + "." + std::string(member), line, text}; }
};

/// A traction [Pa] on the outer cell faces with all corners in the region; a fault of `where` without any.
void add_traction(const Region& region, const Vec3& traction, const Asked& where, Scene& scene,
                  FaultList& faults);
/// A force [N], in 2D per metre of thickness, spread evenly over the area of the same faces.
void add_force(const Region& region, const Vec3& force, const Asked& where, Scene& scene, FaultList& faults);

/// A pressure [Pa], > 0: compression, on the same faces, each along its own normal. The faces of a voxel
/// staircase have together the vector area of the smooth surface, so force and moment equal those of the
/// smooth surface.
void add_pressure(const Region& region, double pressure, const Asked& where, Scene& scene, FaultList& faults);

/// Springs to the ground, as requested.
struct Foundation {
  double stiffness = 0; ///< pressure over displacement [Pa/m]
  bool is_normal = false;
  std::array<bool, 3> axes{true, true, true}; ///< if they are not along the normal
};
/// Springs on the same faces, weighted by the area of the smooth surface that the voxel staircase represents;
/// its normal at a face is the mean over faces within three cells.
void add_foundation(const Region& region, const Foundation& foundation, const Asked& where, Scene& scene,
                    FaultList& faults);

/// The cells of matter in a region, or in the body, for which `counts` is true.
template<class Counts>
std::vector<std::int64_t> cells_in(const std::optional<Region>& region, const Specimen& body,
                                   Counts&& counts) {
  std::vector<std::int64_t> cells;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell) && counts(cell) && (!region || region->contains_cell(body, cell)))
      cells.push_back(cell);
  return cells;
}

inline constexpr const char* wanted_cells = "at least one whole cell of matter";

/// Adds an active stress [Pa] to the fibres of cells.
void add_contraction(const std::vector<std::int64_t>& cells, double stress, Scene& scene);

/// A hold or a move, and the nodes of the body that it selects.
struct Condition {
  std::vector<std::int64_t> nodes;
  std::array<bool, 3> axes{};
  Vec3 by{};
  std::optional<Turn> turn; ///< its shift is `by`
  std::optional<Drive> drive;
  /// Displacement at a place in the object's frame; nothing if undefined there.
  std::function<std::optional<Vec3>(const Vec3& x)> field;
  std::vector<Vec3> values; ///< of the field, one per node
  bool held = false;
  Asked asked;

  /// Displacement of one of the nodes along a component [m].
  double value(const Specimen& body, std::int64_t node, std::size_t component) const;
};

/// Number of axes that may be named: those of the scene, or all if its dimension is unknown.
std::size_t n_axes(int dimension);
/// The axes in a text such as `xz`; a fault for other texts, or an empty one.
std::array<bool, 3> axes_named(std::string_view text, int dimension, const Asked& asked, FaultList& faults);
std::array<bool, 3> all_axes(int dimension);
/// `0 along z: the scene has 2 dimensions`
std::string wanted_zero(std::size_t axis, int dimension);

/// Appends the condition with the nodes of its region, and positions its rotation; a fault of `where` if
/// there are no nodes.
void add_condition(Condition condition, const Region& region, const Asked& where, bool turns_about_its_middle,
                   const Specimen& body, std::vector<Condition>& conditions, FaultList& faults);
/// Evaluates the condition's field, if any, at its nodes. @return false and a fault if undefined at some
bool find_values(Condition& condition, const Specimen& body, FaultList& faults);
/// Adds a fault when no condition holds or moves the body.
void report_loose_body(FaultList& faults);

/// Leaves out pieces without holds, then prescribes the components of the others, sorted by (component,
/// node), unique. If two conditions prescribe different values: one fault per pair of conditions and
/// component.
/// @pre there are conditions, the holds before the moves
/// @param springs nodes with springs, which also keep a piece in the scene
void prescribe(const std::vector<Condition>& conditions, std::vector<std::int64_t> springs, Scene& scene,
               FaultList& faults);
/// The same without leaving out pieces.
void prescribe_components(const std::vector<Condition>& conditions, Scene& scene, FaultList& faults);

} // namespace maille::reader
