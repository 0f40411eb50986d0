#pragma once
/// Tests in a line: a scene's `[test]`, which sets its holds and moves. See test_result() of mechanics.hpp.

#include "maille/base/grid.hpp"

#include <string_view>

namespace maille {

enum class TestKind { axial, shear, bend, indent, confined };
/// `axial`, `shear`, ... as a scene file has it.
std::string_view to_string(TestKind kind);

/// The whole lower face across `axis` is held, the upper one (indent: a round patch of it) is moved. Lengths
/// and areas are those of the bounding box, as apparent constants are of the body with its holes.
struct StandardTest {
  TestKind kind = TestKind::axial;
  int axis = 0;  ///< from the held face to the moved one
  int along = 1; ///< that the upper face is sheared along, or that the body is bent towards
  /// Bending: strain at the surface; otherwise displacement over length [1]. An indenter goes in where > 0.
  double strain = 0;
  double length = 0; ///< along `axis` [m]
  double area = 0;   ///< of the cross-section [m^2]; 1 in 1D; per metre of thickness in 2D [m]
  double second_moment =
      0;             ///< of the cross-section about its middle, in the plane of bending [m^4], in 2D [m^3]
  double radius = 0; ///< of the indenter [m]
  /// Pistoia 2002: bone fails where 2 % of its tissue is beyond an effective strain of 0.7 %.
  bool asks_for_failure = false;

  double displacement() const { return strain * length; } ///< [m]; of `bend` the arc's end says it
  double angle() const;                                   ///< that the upper face is turned by: bend [rad]
};

} // namespace maille
