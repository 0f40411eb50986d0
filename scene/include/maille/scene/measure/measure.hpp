#pragma once
/// Named quantities of a scene ([[measure]]): definitions, places, and values for an answer.
///
/// Methods do not read measures: each is computed from the Answer, by the same code for every method. If an
/// answer lacks the data for a measure (no stress, no reactions), the value is empty and the reason is
/// stored. docs/mechanics.md defines each.

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

/// Figure that is derived from a quantity.
enum class MeasureFigure {
  value,     ///< length, angle, volume (deformed); energy
  change,    ///< length, angle, volume: deformed minus at rest
  relative,  ///< length, volume: the change over the value at rest
  vector,    ///< force and displacement, in the world's frame
  magnitude, ///< its length
  along,     ///< its part along Measure::direction
  /// With strain = "finite", along the fibre of the cell, or the largest principal value without fibres:
  stretch,        ///< length over length at rest
  green_lagrange, ///< Green-Lagrange strain (U^2 - I) / 2
  logarithmic,    ///< ln U
  fibre,          ///< strain and stress: along the fibre of the cell
  largest,        ///< the largest principal value
  smallest,       ///< the smallest
  xx, ///< this and the next: components of the tensor along the world's axes, for the body at rest
  yy,
  zz,
  xy,
  yz,
  xz,
  von_mises, ///< stress; so is the next
  pressure,  ///< minus a third of the trace
  nominal,   ///< stress per area at rest, strain = "finite": along the fibre, or largest principal value
};

/// A point of the matter at rest and the cells that contain it: several if it is on their border; none
/// outside the body.
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
  Vec3 direction{};  ///< unit vector, world's frame; for MeasureFigure::along
  std::string where; ///< in words
  /// Place: one of these. Nodes and cells ascend.
  std::optional<std::int32_t> condition;  ///< for a force: index into Scene::conditions
  std::optional<SectionPlane> section;    ///< for a force
  std::vector<std::int64_t> nodes, cells; ///< to sum or to average over
  std::vector<MaterialPoint> points;      ///< for a line, a polyline, an angle; or one point
  bool is_line = false;                   ///< a value at each of the points

  bool is_vector() const { return figure == MeasureFigure::vector; }
  /// Names of its columns: NAME, or NAME_x, NAME_y, NAME_z too for a vector; empty for a line.
  std::vector<std::string> columns() const;
};

/// SI: `N`, `m`, `rad`, ...; `N/m`, `J/m`, `m^2` of forces, energies, volumes in 2D; empty: a ratio.
std::string_view unit_of(const Measure& measure, int dimension);
/// `force on move[1], along x`
std::string in_words(const Measure& measure);
/// True if results have a column or a file of that name, which measures cannot use.
bool is_reserved_name(std::string_view name);

struct LinePoint {
  double along = 0; ///< distance from the start of the line, at rest [m]
  Vec3 place{};     ///< at rest, specimen coordinates [m]
  std::optional<double> value;
  std::optional<Vec3> vector; ///< both unset outside the matter
};

/// Value of a measure for an answer.
struct MeasuredValue {
  std::string name, unit;
  bool is_vector = false, is_line = false;
  std::optional<double> value; ///< for a vector its length; unset for a line, or for the reason in `why_not`
  std::optional<Vec3> vector;  ///< world's frame
  std::vector<LinePoint> line;
  std::string why_not;
  double scale = 0; ///< magnitude of the summands: a value below 1e-6 of it is rounding error

  /// One value per column of Measure::columns().
  std::vector<std::pair<std::string, std::optional<double>>> columns() const;
};

/// @param cell_energy  energy of every cell of the grid [J]; empty: Answer::cell_energy
/// @pre the answer has a displacement on the scene's grid; the measures belong to the scene
/// Cost  O(prescribed nodes, evaluated cells); strain and stress need O(cells) once
std::vector<MeasuredValue> measured(const Scene& scene, const std::vector<Measure>& measures,
                                    const Answer& answer, const std::vector<double>& cell_energy = {});

/// |v - r| / |r|, for a line the L2 norm over its points; unset if either has no value, or if the reference
/// is only rounding error.
std::optional<double> relative_error(const MeasuredValue& value, const MeasuredValue& reference);

/// The same measures on refined(scene): cells are replaced by the cells they are cut into, nodes by those
/// between.
std::vector<Measure> refined(const std::vector<Measure>& measures, const Scene& scene, const Scene& fine);

struct SceneAndMeasures {
  Scene scene;
  std::vector<Measure> measures; ///< in the file's order
};
/// As read_scene and parse_scene, which report the same faults but omit the measures.
SceneAndMeasures read_scene_and_measures(const std::filesystem::path& file);
SceneAndMeasures parse_scene_and_measures(std::string_view text,
                                          const std::filesystem::path& file = "scene.toml");

} // namespace maille
