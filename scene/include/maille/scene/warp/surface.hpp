#pragma once
/// The surface of a deformed body, or of one of its parts, and files that other programs read it from.

#include "maille/scene/warp/warp.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille {

/// The outer faces of the cells of one part, which are those to cells of other parts and to no matter.
struct BodySurface {
  std::string name;                     ///< of its label or material
  std::int32_t part = 0;                ///< its label, or the number of its material
  WorldAxes world = WorldAxes::unknown; ///< of the points
  std::vector<Vec3> points;             ///< in the world [m], each once
  std::vector<std::array<std::int32_t, 4>>
      quads; ///< of points, in an order that turns right-handed about outside
};

/// The parts of a body, a surface each, in the order of their numbers: of labels where it has some, else of
/// materials. Touching parts share faces, each with its own points.
/// @param materials of the scene, for names
/// Cost  O(cells)
/// @throws std::invalid_argument  a body that is not of three dimensions
std::vector<BodySurface> surfaces_of(const DeformedBody& body, const std::vector<Material>& materials);

enum class LengthUnit { metre, millimetre };

/// Writes what the ending of the name says; a quad as two triangles.
///
/// .stl  binary; one part, or several after each other
/// .ply  binary; `part` of every face: the label
/// .vtp  appended raw; cell data Part, field data Units and Name
/// A patient's world is written as LPS, which 3D Slicer and ITK expect, and the file says so (`SPACE=LPS`)
/// beside the unit; where the body's image does not state a world, places are as they are.
/// @throws std::runtime_error  the file cannot be written; std::invalid_argument  another ending
void write_surfaces(const std::vector<BodySurface>& surfaces, const std::filesystem::path& file,
                    LengthUnit unit);

} // namespace maille
