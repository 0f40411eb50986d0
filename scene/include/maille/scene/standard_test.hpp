#pragma once
/// Tests in a line: a scene's `[test]`, which sets its holds and moves, and what an answer to it is worth.

#include "maille/scene/grid.hpp"

#include <optional>
#include <string_view>

namespace maille {

struct Answer;
struct Scene;

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

/// What a method's reactions make of the test.
struct TestResult {
  double reaction =
      0; ///< on what is moved, along the displacement [N], in 2D per metre; of `bend` the moment [N m]
  double stiffness = 0; ///< reaction over displacement [N/m], over the angle [N m/rad]
  /// Young's (axial, bend), shear, or confined modulus of a homogeneous body that answers as this one; of an
  /// indenter F / (2 R d), which on a half-space is E / (1 - nu^2) [Pa]. Unset in 2D for indent
  std::optional<double> apparent_modulus;
  std::optional<double> failure; ///< reaction at which the tissue fails [N]; where asked for and known
};

/// @param answer its reactions, in the order of scene.prescribed
/// @return nothing without a test, where nothing is moved, or for an answer that knows no forces
/// Cost    O(prescribed); of a failure load O(cells log cells)
/// Source  Sneddon 1965 (flat punch); Pistoia et al. 2002, Bone 30:842 (failure)
/// Checked by  tests/deform/standard_test_test.cpp
std::optional<TestResult> test_result(const Scene& scene, const Answer& answer);

} // namespace maille
