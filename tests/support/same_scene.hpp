#pragma once
/// Comparison of two scenes, number by number.

#include "maille/scene/scene.hpp"
#include "support/kit.hpp"

namespace maille::test {

inline void expect_same_body(const Specimen& a, const Specimen& b) {
  EXPECT_EQ(a.shape, b.shape);
  EXPECT_EQ(a.grid.dimension(), b.grid.dimension());
  EXPECT_EQ(a.grid.cells(), b.grid.cells());
  EXPECT_EQ(a.grid.spacing(), b.grid.spacing());
  EXPECT_EQ(a.origin, b.origin);
  // A file may define a patient's axes; an array in memory does not.
  EXPECT_EQ(a.placement.origin, b.placement.origin);
  EXPECT_EQ(a.placement.direction, b.placement.direction);
  EXPECT_EQ(a.material_id, b.material_id);
  EXPECT_EQ(a.fibre, b.fibre);
  EXPECT_EQ(a.fibres, b.fibres);
  EXPECT_EQ(a.label, b.label);
}

inline void expect_same_material(const Material& a, const Material& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.elasticity.youngs_modulus, b.elasticity.youngs_modulus);
  const auto rest = [](const ElasticConstants& c) {
    return std::array{c.nu12, c.nu13, c.nu23, c.G12, c.G13, c.G23};
  };
  EXPECT_EQ(rest(a.elasticity), rest(b.elasticity));
  EXPECT_EQ(a.density, b.density);
  EXPECT_TRUE(a.limits == b.limits);
  EXPECT_EQ(a.damage.has_value(), b.damage.has_value());
  EXPECT_EQ(a.relaxed_weights, b.relaxed_weights);
}

inline void expect_same_conditions(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.prescribed.size(), b.prescribed.size());
  for (std::size_t i = 0; i < a.prescribed.size(); ++i) {
    const Prescribed &p = a.prescribed[i], &q = b.prescribed[i];
    EXPECT_TRUE(p.node == q.node && p.component == q.component && p.value == q.value && p.held == q.held)
        << i;
  }
  ASSERT_EQ(a.tractions.size(), b.tractions.size());
  for (std::size_t i = 0; i < a.tractions.size(); ++i) {
    const FaceLoad &p = a.tractions[i], &q = b.tractions[i];
    EXPECT_TRUE(p.cell == q.cell && p.axis == q.axis && p.upper == q.upper && p.traction == q.traction) << i;
  }
  EXPECT_EQ(a.gravity, b.gravity);
  EXPECT_EQ(a.active_stress, b.active_stress);
  EXPECT_EQ(a.turns.size(), b.turns.size());
}

inline void expect_same_settings(const Scene& a, const Scene& b) {
  EXPECT_EQ(a.limits.from, b.limits.from);
  EXPECT_TRUE(a.limits.given == b.limits.given);
  EXPECT_EQ(a.limits.taut_scale, b.limits.taut_scale);
  EXPECT_EQ(a.limits.cut_is_allowed, b.limits.cut_is_allowed);
  EXPECT_EQ(a.relaxation.mode, b.relaxation.mode);
  EXPECT_EQ(a.strain, b.strain);
  EXPECT_EQ(a.relaxation.increments, b.relaxation.increments);
  EXPECT_EQ(a.relaxation.tolerance, b.relaxation.tolerance);
  EXPECT_EQ(a.relaxation.sweeps, b.relaxation.sweeps);
  EXPECT_EQ(a.relaxation.extrapolation, b.relaxation.extrapolation);
}

/// Compares everything except the source of the fibres.
inline void expect_same_scene(const Scene& a, const Scene& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.title, b.title);
  EXPECT_EQ(a.plane, b.plane);
  expect_same_body(a.specimen, b.specimen);
  ASSERT_EQ(a.materials.size(), b.materials.size());
  for (std::size_t i = 0; i < a.materials.size(); ++i)
    expect_same_material(a.materials[i], b.materials[i]);
  expect_same_conditions(a, b);
  expect_same_settings(a, b);
  ASSERT_EQ(a.left_out.size(), b.left_out.size());
  for (std::size_t i = 0; i < a.left_out.size(); ++i)
    EXPECT_EQ(a.left_out[i].name, b.left_out[i].name);
}

} // namespace maille::test
