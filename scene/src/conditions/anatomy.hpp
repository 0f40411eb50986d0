#pragma once
/// Directions and frames of a patient, and parts of a body that its labels name.

#include "conditions/region.hpp"

#include <string_view>
#include <variant>

namespace maille::reader {

/// Why a region cannot be found: as a fault has it.
struct RegionFault {
  std::string expected, found;
};
template<class T>
using OrFault = std::variant<T, RegionFault>;

/// Coordinates that a file's places are in: the object's own, those of the world that its image states, or a
/// patient's.
enum class CoordinateFrame { grid, world, ras, lps };
inline constexpr std::array<std::string_view, 4> coordinate_frames{"grid", "world", "ras", "lps"};

/// What carries points of the object's frame into `frame`.
/// A fault where a patient's frame is asked for and the image does not say where the patient is.
OrFault<Placement> placement_in(const Specimen& body, CoordinateFrame frame);

/// `superior`, `inferior`, `left`, `right`, `anterior`, `posterior`; `proximal` and `distal`, which are taken
/// for superior and inferior; or `x-`, `x+` ... of the grid.
bool is_direction(std::string_view name);
/// The unit vector in the object's frame. A fault of a patient's direction as of placement_in.
OrFault<Vec3> direction_named(std::string_view name, const Specimen& body);
/// The face of the body's bounding box whose outward normal is nearest to a patient's direction, as the grid
/// calls it: `x-`.
OrFault<std::string> face_towards(std::string_view direction, const Specimen& body);

/// Cells of a label. A fault where the body has none of it.
OrFault<std::vector<std::int64_t>> cells_of_label(std::int64_t label, const Specimen& body);

/// The nodes of a label within `depth` [m] of one end, along its own long axis: the first principal axis of
/// its largest piece (cells joined through faces), where the piece ends furthest in `direction`.
/// A fault where the label is about as thick as long, or lies across the direction.
OrFault<Region> end_of_label(const std::vector<std::int64_t>& cells, std::string_view direction, double depth,
                             const Specimen& body);

} // namespace maille::reader
