/// The parts of cells in what elastic methods minimise, and the forces that balance.
#include "maille/deform/solve.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/scene_builder.hpp"
#include "support/oriented_labels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace maille::deform {
namespace {

Scene scene_of(const std::string& specimen, const std::string& rest) {
  return parse_scene("[specimen]\nshape = \"box\"\nspacing = \"1 mm\"\nmaterial = "
                     "\"muscle/vastus_lateralis\"\n" +
                     specimen + "\n[[hold]]\nwhere = \"x-\"\n" + rest);
}

const std::string in_3d = "cells = [8, 4, 4]\nfibre = { angle = \"20 deg\", plane = \"xz\" }\n";
const std::string pull = "[[move]]\nwhere = \"x+\"\nby = [\"0.4 mm\", 0, \"0.3 mm\"]\n";

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// @param tolerance  relative: 1e-10 where sums are the only difference
void expect_parts_add_up(const Scene& scene, const char* method, double tolerance) {
  const Answer answer = solve(scene, method);
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  ASSERT_GT(answer.strain_energy.value(), 0);
  EXPECT_NEAR(sum(cell_energies(scene, answer)) / *answer.strain_energy, 1, tolerance) << answer.algorithm;
}

TEST(CellEnergiesAnalytic, AddUpToWhatCoupledMinimises) {
  expect_parts_add_up(scene_of(in_3d, pull), "coupled", 1e-10);
  expect_parts_add_up(scene_of(in_3d, pull + "[[load]]\ntraction = [0, \"50 Pa\", 0]\nwhere = \"z+\"\n"),
                      "coupled", 1e-10);
  expect_parts_add_up(scene_of("cells = [8, 4]\n", "[[move]]\nwhere = \"x+\"\nby = [0, \"0.3 mm\"]\n"),
                      "coupled", 1e-10);
  expect_parts_add_up(scene_of("cells = [8]\n", "[[move]]\nwhere = \"x+\"\nby = [\"0.3 mm\"]\n"), "coupled",
                      1e-10);
}

TEST(CellEnergiesAnalytic, AddUpWhereFibresContractAndWhereTheBodyIsNoBox) {
  expect_parts_add_up(scene_of(in_3d, "[[load]]\ncontraction = \"3 kPa\"\n"), "coupled", 1e-10);
  expect_parts_add_up(parse_scene(R"([specimen]
shape = "ellipsoid"
cells = [10, 6, 6]
spacing = "1 mm"
material = "muscle/soleus"
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["0.3 mm", 0, "0.2 mm"]
)"),
                      "coupled", 1e-10);
}

// In blocks frames are turned to the accuracy of their iteration.
TEST(CellEnergiesAnalytic, AddUpInBlocks) {
  expect_parts_add_up(scene_of(in_3d,
                               "[[move]]\nwhere = \"x+\"\nby = [0, 0, \"3 mm\"]\n[relaxation]\nframe = "
                               "\"blocks\"\n"),
                      "coupled", 1e-10);
}

// Weights of links are float32.
TEST(CellEnergiesAnalytic, AddUpToWhatRelaxedMinimises) {
  expect_parts_add_up(scene_of(in_3d, pull), "relaxed", 1e-6);
  expect_parts_add_up(scene_of("cells = [8, 4]\n", "[[move]]\nwhere = \"x+\"\nby = [0, \"0.3 mm\"]\n"),
                      "relaxed", 1e-6);
}

TEST(CellEnergiesContract, MethodsWithoutEnergyHaveNone) {
  const Scene scene = scene_of(in_3d, pull);
  EXPECT_TRUE(cell_energies(scene, solve(scene, "limits")).empty());
  EXPECT_TRUE(cell_energies(scene, refusal("coupled", "no reason")).empty());
}

// Truth: a body at rest is in balance: forces on it and their moments about any place add up to nothing.
TEST(ResultantsAnalytic, ForcesAndMomentsOnTheBodyBalance) {
  for (const char* frame : {"object", "blocks"}) {
    const Scene scene =
        scene_of(in_3d, pull +
                            "[[load]]\ntraction = [0, \"200 Pa\", \"90 Pa\"]\nwhere = \"z+\"\n"
                            "[[load]]\ngravity = [0, 0, -9.81]\n"
                            "[relaxation]\ntolerance = 1e-10\nframe = \"" +
                            frame + "\"\n");
    const Answer answer = solve(scene, "coupled");
    ASSERT_EQ(answer.status, Status::done) << answer.message;
    const Mechanics found = mechanics_of(scene, answer, cell_energies(scene, answer));
    ASSERT_EQ(found.holds.size(), 1u);
    ASSERT_EQ(found.moves.size(), 1u);
    ASSERT_EQ(found.loads.size(), 2u);
    EXPECT_EQ(found.loads[0].name, "load[1]");
    EXPECT_EQ(found.loads[0].where, "z+");
    EXPECT_EQ(found.loads[1].name, "gravity");
    Vec3 force{}, moment{};
    double size = 0;
    for (const auto* list : {&found.holds, &found.moves, &found.loads})
      for (const Resultant& r : *list)
        for (std::size_t a = 0; a < 3; ++a) {
          force[a] += r.force[a];
          moment[a] += r.moment[a] + r.centroid[(a + 1) % 3] * r.force[(a + 2) % 3] -
                       r.centroid[(a + 2) % 3] * r.force[(a + 1) % 3];
          size += std::abs(r.force[a]);
        }
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(force[a], 0, 1e-6 * size) << frame;
      EXPECT_NEAR(moment[a], 0, 1e-6 * size * 8e-3) << frame;
    }
  }
}

std::string face(std::size_t axis, bool upper, const test::Orientation& to) {
  for (std::size_t a = 0; a < 3; ++a)
    if (to.axis[a] == axis)
      return {"xyz"[a], upper != to.flipped[a] ? '+' : '-'};
  return {};
}

Vec3 vector(const Vec3& v, const test::Orientation& to) {
  Vec3 turned{};
  for (std::size_t a = 0; a < 3; ++a)
    turned[a] = v[to.axis[a]] * (to.flipped[a] ? -1 : 1);
  return turned;
}

/// A bent body of two labels that is pulled, in an array of some orientation.
Mechanics mechanics_in(const test::Orientation& to) {
  const test::LabelArray array = turned(test::bent_body(), to);
  Material firm;
  firm.name = "firm";
  firm.elasticity = ElasticConstants::isotropic(30e3, 0.4);
  RelaxationSettings relaxation;
  relaxation.tolerance = 1e-11;
  const Scene scene = SceneBuilder()
                          .material(17, "muscle/soleus")
                          .material(5, firm)
                          .labels(std::vector<std::int32_t>(array.values.begin(), array.values.end()),
                                  ArrayLayout::x_fastest(array.size), array.affine)
                          .fibre(vector({0.48, 0.6, 0.64}, to))
                          .hold(face(2, false, to))
                          .move(face(2, true, to), vector({1e-4, -2e-4, 3e-4}, to))
                          .relaxation(relaxation)
                          .build();
  const Answer answer = solve(scene, "coupled");
  EXPECT_EQ(answer.status, Status::done) << answer.message;
  return mechanics_of(scene, answer, cell_energies(scene, answer));
}

void expect_near(const std::optional<Spread>& found, const std::optional<Spread>& expected, double size) {
  ASSERT_TRUE(found && expected);
  for (double Spread::*figure : {&Spread::mean, &Spread::least, &Spread::most, &Spread::percentile_5,
                                 &Spread::median, &Spread::percentile_95})
    EXPECT_NEAR((*found).*figure, (*expected).*figure, 1e-5 * size);
}

// Truth: physics does not depend on the order in which an array stores voxels; affines are of float32.
TEST(MechanicsAnalytic, LabelsAndForcesAreTheSameInAllOrdersOfAxes) {
  const Mechanics expected = mechanics_in({});
  ASSERT_EQ(expected.labels.size(), 2u);
  for (const test::Orientation& to : test::all_orientations()) {
    SCOPED_TRACE(testing::Message() << "axes " << to.axis[0] << to.axis[1] << to.axis[2] << ", flipped "
                                    << to.flipped[0] << to.flipped[1] << to.flipped[2]);
    const Mechanics found = mechanics_in(to);
    ASSERT_EQ(found.labels.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      const PartMechanics &part = found.labels[i], &wanted = expected.labels[i];
      EXPECT_EQ(part.label, wanted.label);
      EXPECT_EQ(part.material, wanted.material);
      EXPECT_EQ(part.cells, wanted.cells);
      EXPECT_NEAR(part.volume / wanted.volume, 1, 1e-6);
      EXPECT_NEAR(*part.strain_energy / *wanted.strain_energy, 1, 1e-5);
      const double strain = wanted.largest_strain->most, stress = wanted.von_mises->most;
      expect_near(part.fibre_strain, wanted.fibre_strain, strain);
      expect_near(part.largest_strain, wanted.largest_strain, strain);
      expect_near(part.smallest_strain, wanted.smallest_strain, strain);
      expect_near(part.fibre_stress, wanted.fibre_stress, stress);
      expect_near(part.von_mises, wanted.von_mises, stress);
      expect_near(part.pressure, wanted.pressure, stress);
    }
    const Resultant &pulled = found.moves.at(0), &wanted = expected.moves.at(0);
    const double size = std::hypot(wanted.force[0], wanted.force[1], wanted.force[2]);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(pulled.centroid[a], wanted.centroid[a], 1e-8);
      EXPECT_NEAR(pulled.force[a], wanted.force[a], 1e-5 * size);
      EXPECT_NEAR(pulled.moment[a], wanted.moment[a], 1e-5 * size * 1e-2);
    }
  }
}

} // namespace
} // namespace maille::deform
