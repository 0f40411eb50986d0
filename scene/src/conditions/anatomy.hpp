#pragma once
/// Anatomical directions and frames, and parts of a body that labels define.

#include "conditions/region.hpp"

#include <string_view>
#include <variant>

namespace maille::reader {

/// Reason why a region does not exist, in the form of a fault.
struct RegionFault {
  std::string expected, found;
};
template<class T>
using OrFault = std::variant<T, RegionFault>;

/// Coordinate frame of places in a file: the object's own, the world of its image, or a patient's.
enum class CoordinateFrame { grid, world, ras, lps };
inline constexpr std::array<std::string_view, 4> coordinate_frames{"grid", "world", "ras", "lps"};

/// Transformation from the object's frame to `frame`.
/// A fault if a patient's frame is requested and the image does not define it.
OrFault<Placement> placement_in(const Specimen& body, CoordinateFrame frame);

/// True for `superior`, `inferior`, `left`, `right`, `anterior`, `posterior`; `proximal` and `distal`, which
/// stand for superior and inferior; and `x-`, `x+` ... of the grid.
bool is_direction(std::string_view name);
/// The unit vector of a direction in the object's frame. Faults of anatomical directions as in placement_in.
OrFault<Vec3> direction_named(std::string_view name, const Specimen& body);
/// The face of the body's bounding box whose outward normal is nearest to an anatomical direction, by its
/// grid name: `x-`.
OrFault<std::string> face_towards(std::string_view direction, const Specimen& body);

/// Cells of a label. A fault if the body has none.
OrFault<std::vector<std::int64_t>> cells_of_label(std::int64_t label, const Specimen& body);

/// The nodes of a label within `depth` [m] of one end, along its long axis: the first principal axis of its
/// largest piece (cells joined through faces). The end is the one that is furthest in `direction`. A fault if
/// the label is about as thick as long, or lies across the direction.
OrFault<Region> end_of_label(const std::vector<std::int64_t>& cells, std::string_view direction, double depth,
                             const Specimen& body);

} // namespace maille::reader
