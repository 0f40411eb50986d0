#pragma once
/// Quantities that a scene asks for by name ([[measure]]): what they are, where they are taken, and what an
/// answer makes of them.
///
/// Methods do not see measures: each is computed from the Answer, by the same code for every method. Where
/// an answer cannot give a measure (no stress, no reactions), the value is empty and the reason is kept.
/// docs/mechanics.md defines each.

#include "maille/scene/answer.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille {

enum class MeasureKind { force, displacement, strain, stress, length, angle, volume, energy };
std::string_view to_string(MeasureKind kind);

/// Which figure of it.
enum class MeasureFigure {
  value,     ///< of length, angle, volume: deformed; of energy
  change,    ///< of length, angle, volume: deformed minus at rest
  relative,  ///< of length, volume: that over what it is at rest
  vector,    ///< of force and displacement, in the world's frame
  magnitude, ///< its length
  along,     ///< its part along Measure::direction
  /// Of strain = "finite", along the fibre of the cell, or the largest principal value without fibres:
  stretch,        ///< length over length at rest
  green_lagrange, ///< Green and Lagrange's strain (U^2 - I) / 2
  logarithmic,    ///< ln U
  fibre,          ///< of strain and stress: along the fibre of the cell
  largest,        ///< the largest principal value
  smallest,       ///< the smallest
  xx,             ///< and so on: of the tensor, along the world's axes as the body stood at rest
  yy,
  zz,
  xy,
  yz,
  xz,
  von_mises, ///< of stress; so is the next
  pressure,  ///< minus a third of the trace
  nominal,   ///< of strain = "finite", per area at rest: along the fibre, or the largest principal value
};

/// A point of the matter at rest and the cells that hold it: several on the border between them; none
/// outside.
struct MaterialPoint {
  Vec3 place{}; ///< object's frame [m]
  std::vector<std::int64_t> cells;
};
MaterialPoint located(const Specimen& specimen, const Vec3& place);

/// A plane through the body at rest.
struct SectionPlane {
  Vec3 point{};  ///< object's frame [m]
  Vec3 normal{}; ///< unit vector, object's frame
};

struct Measure {
  std::string name; ///< an identifier
  MeasureKind kind = MeasureKind::force;
  MeasureFigure figure = MeasureFigure::vector;
  Vec3 direction{};  ///< unit vector, world's frame; of MeasureFigure::along
  std::string where; ///< in words
  /// Where: one of these. Nodes and cells ascend.
  std::optional<std::int32_t> condition;  ///< of a force: into Scene::conditions
  std::optional<SectionPlane> section;    ///< of a force
  std::vector<std::int64_t> nodes, cells; ///< to sum or to average over
  std::vector<MaterialPoint> points;      ///< of a line, a polyline, an angle; or one
  bool is_line = false;                   ///< a value at each of the points

  bool is_vector() const { return figure == MeasureFigure::vector; }
  /// Names of its columns: NAME, or NAME_x, NAME_y, NAME_z too for a vector; empty for a line.
  std::vector<std::string> columns() const;
};

/// SI: `N`, `m`, `rad`, ...; `N/m`, `J/m`, `m^2` of forces, energies, volumes in 2D; empty: a ratio.
std::string_view unit_of(const Measure& measure, int dimension);
/// `force on move[1], along x`
std::string in_words(const Measure& measure);
/// Whether results have a column or a file of that name, so that no measure can.
bool is_reserved_name(std::string_view name);

struct LinePoint {
  double along = 0; ///< distance from the line's begin, at rest [m]
  Vec3 place{};     ///< at rest, specimen coordinates [m]
  std::optional<double> value;
  std::optional<Vec3> vector; ///< both unset outside of the matter
};

/// What an answer makes of a measure.
struct MeasuredValue {
  std::string name, unit;
  bool is_vector = false, is_line = false;
  std::optional<double> value; ///< of a vector its length; unset: of a line, or `why_not` says why
  std::optional<Vec3> vector;  ///< world's frame
  std::vector<LinePoint> line;
  std::string why_not;
  double scale = 0; ///< size of what it was summed from: less than 1e-6 of it is rounding

  /// A value a column of Measure::columns().
  std::vector<std::pair<std::string, std::optional<double>>> columns() const;
};

/// @param cell_energy  of every cell of the grid [J]; empty: Answer::cell_energy
/// @pre the answer has a displacement on the scene's grid, of which the measures are
/// Cost  O(nodes that are prescribed, cells that are looked at), of strain and stress O(cells) once
std::vector<MeasuredValue> measured(const Scene& scene, const std::vector<Measure>& measures,
                                    const Answer& answer, const std::vector<double>& cell_energy = {});

/// |v - r| / |r|, of a line L2 over its points; unset where one of the two has no value, or where the
/// reference's is nothing but rounding.
std::optional<double> relative_error(const MeasuredValue& value, const MeasuredValue& reference);

/// The same measures on refined(scene): cells go over to the parts that they are cut into, nodes to those
/// that lie between them.
std::vector<Measure> refined(const std::vector<Measure>& measures, const Scene& scene, const Scene& fine);

struct SceneAndMeasures {
  Scene scene;
  std::vector<Measure> measures; ///< in the file's order
};
/// As read_scene and parse_scene, which find the same faults and leave the measures out.
SceneAndMeasures read_scene_and_measures(const std::filesystem::path& file);
SceneAndMeasures parse_scene_and_measures(std::string_view text,
                                          const std::filesystem::path& file = "scene.toml");

} // namespace maille
