#pragma once
/// Scenes that tests of several commands ask.

#include <string>

namespace maille::test {

/// A bar of 4 x 2 x 2 cells that may contract sideways: strain 5 %, stress 500 Pa, force 2 mN.
inline const std::string pulled_bar = R"(
[specimen]
shape = "box"
cells = [4, 2, 2]
spacing = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3, name = "soft" }
[[hold]]
where = "x-"
axes = "x"
[[hold]]
where = "y-"
axes = "y"
[[hold]]
where = "z-"
axes = "z"
[[move]]
where = "x+"
by = ["0.2 mm", 0, 0]
axes = "x"
)";

/// A fixed floor, a soft pad on it, and a rigid finger of 2 x 2 x 2 voxels.
/// @param position of the finger, as a scene has it
inline std::string floor_pad_and_finger(const std::string& position) {
  return R"(title = "a floor, a pad and a finger"
[world]
cells = [20, 20, 20]
spacing = "1 mm"
[[object]]
name = "floor"
kind = "fixed"
shape = "box"
cells = [20, 20, 4]
[[object]]
name = "pad"
kind = "deformable"
shape = "box"
cells = [6, 6, 6]
spacing = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
hold = [{ where = "z-" }]
limits = { from = "given", stretch = 2, compress = 0.1, shear = 1 }
position = ["10 mm", "7 mm", "5 mm"]
[[object]]
name = "finger"
kind = "rigid"
shape = "box"
cells = [2, 2, 2]
position = )" +
         position + "\n";
}

} // namespace maille::test
