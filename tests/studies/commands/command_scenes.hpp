#pragma once
/// Scenes that tests of several commands ask.

#include "support/kit.hpp"

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
  return "title = \"a floor, a pad and a finger\"\n" + world_text("[20, 20, 20]") +
         object_text("floor", "fixed", "[20, 20, 4]") +
         object_text("pad", "deformable", "[6, 6, 6]", "material = " + soft + R"(
spacing = "1 mm"
hold = [{ where = "z-" }]
limits = { from = "given", stretch = 2, compress = 0.1, shear = 1 }
position = ["10 mm", "7 mm", "5 mm"]
)") + object_text("finger", "rigid", "[2, 2, 2]", "position = " + position + "\n");
}

} // namespace maille::test
