#include "maille/scene/plausibility.hpp"

#include "support/bodies/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace maille {
namespace {

Scene question() {
  Scene scene = test::box_scene(3, {2, 2, 2});
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {1e-4, 0, 0});
  return scene;
}

TEST(UsableNumbersContract, WhatNoArithmeticCarriesIsNamed) {
  EXPECT_EQ(unusable_number(question()), "");
  const auto with = [](const auto& change) {
    Scene scene = question();
    change(scene);
    return unusable_number(scene);
  };
  EXPECT_EQ(with([](Scene& s) { s.prescribed.back().value = NAN; }), "a prescribed displacement is nan");
  EXPECT_EQ(with([](Scene& s) {
              s.specimen.grid = Grid(3, {2, 2, 2}, {1e-3, INFINITY, 1e-3});
            }),
            "the spacing along y is inf");
  EXPECT_NE(with([](Scene& s) { s.materials[0].elasticity.G13 = INFINITY; }), "");
  EXPECT_NE(with([](Scene& s) { s.materials[0].elasticity.nu12 = NAN; }), "");
  EXPECT_NE(with([](Scene& s) { s.materials[0].elasticity.youngs_modulus[0] = 1e-310; }), "");
  EXPECT_NE(with([](Scene& s) { s.gravity[2] = 1e61; }), "");
  EXPECT_NE(with([](Scene& s) { s.limits.taut_scale = NAN; }), "");
  EXPECT_NE(with([](Scene& s) {
              for (Prescribed& p : s.prescribed)
                p.value *= 1e-300;
            }),
            "");
}

TEST(UsableNumbersContract, SizesOfAnyUnitInUseAreTaken) {
  // Truth: nuclei and galaxies: 1e-15 m, 1e21 m; gases and neutron stars: 1e-20 Pa, 1e34 Pa. Nothing at all
  // is a size, too.
  for (const double size : {1e-15, 1e21}) {
    Scene scene = question();
    scene.specimen.grid = Grid(3, {2, 2, 2}, {size, size, size});
    EXPECT_EQ(unusable_number(scene), "");
  }
  for (const double modulus : {1e-20, 1e34}) {
    Scene scene = question();
    scene.materials[0].elasticity = ElasticConstants::isotropic(modulus, 0.3);
    EXPECT_EQ(unusable_number(scene), "");
  }
  Scene at_rest = question();
  for (Prescribed& p : at_rest.prescribed)
    p.value = 0;
  EXPECT_EQ(unusable_number(at_rest), "");
}

} // namespace
} // namespace maille
