// Which bodies are refused because they can still move as a whole.
#include "fem_ref/bodies.hpp"

#include <Eigen/SVD>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace maille {
namespace {

using test::options_of;

Answer answer_of(const Scene& scene) {
  return fem_ref::solve(scene, options_of(1)).answer;
}

void expect_refused(const Scene& scene, const std::string& why) {
  const Answer answer = answer_of(scene);
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_EQ(answer.message, why);
  EXPECT_TRUE(answer.displacement.empty());
}

TEST(RigidMotionContract, NothingPrescribedIsRefused) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    expect_refused(test::box_scene(dimension, {3, 3, 3}),
                   "nothing is held or moved, so the body can move anywhere");
}

TEST(RigidMotionContract, MessageNamesTheMotion) {
  Scene roller = test::box_scene(2, {3, 3, 1});
  test::prescribe_face(roller, 0, false, 0, 0, true);
  expect_refused(roller, "the body can still move along y: hold or move more of it");

  Scene hinge = test::box_scene(2, {3, 3, 1});
  hinge.prescribed = {{5, 0, 0, true}, {5, 1, 0, true}};
  expect_refused(hinge, "the body can still turn about z: hold or move more of it");

  Scene axle = test::box_scene(3, {3, 3, 3});
  for (int c = 0; c < 3; ++c)
    for (int x = 0; x <= 3; ++x)
      axle.prescribed.push_back({axle.specimen.grid.node({x, 0, 0}), c, 0, true});
  expect_refused(axle, "the body can still turn about x: hold or move more of it");

  Scene table = test::box_scene(3, {3, 3, 3});
  test::prescribe_face(table, 2, false, 2, 0, true);
  expect_refused(table, "the body can still move along x, y and turn about z: hold or move more of it");
}

TEST(RigidMotionContract, MessageNamesThePiece) {
  Scene scene = test::box_scene(3, {5, 1, 1});
  scene.specimen.material_id = {0, 0, no_material, 0, 0};
  test::hold_face(scene, 0, false);
  expect_refused(scene,
                 "piece 2 of 2 (2 cells about (0.003, 0, 0) m) can still move along x, y, z and turn about "
                 "x, y, z: hold or move more of it");
}

/// A flat scene of single cells: '#' is matter; the first line is the upper one.
Scene drawing(const std::vector<std::string>& lines) {
  const auto width = static_cast<int>(lines[0].size()), height = static_cast<int>(lines.size());
  Scene scene = test::box_scene(2, {width, height, 1});
  for (auto line = lines.rbegin(); line != lines.rend(); ++line)
    for (const char c : *line)
      scene.specimen.material_id.push_back(c == '#' ? std::uint8_t{0} : no_material);
  return scene;
}

void hold_node(Scene& scene, const Index3& node) {
  for (int c = 0; c < 2; ++c)
    scene.prescribed.push_back({scene.specimen.grid.node(node), c, 0, true});
}

TEST(RigidMotionContract, PiecesMayHoldEachOtherThroughCorners) {
  Scene hinged = drawing({".#", //
                          "#."});
  hold_node(hinged, {0, 0});
  hold_node(hinged, {0, 1});
  expect_refused(hinged,
                 "piece 2 of 2 (1 cells about (0.001, 0.001, 0) m) can still turn about z: hold or move more "
                 "of it");
  hold_node(hinged, {2, 2});
  EXPECT_EQ(answer_of(hinged).status, Status::done);

  // Three pieces joined in a triangle: stiff together, though each can turn about every one of its corners.
  Scene triangle = drawing({".#.", //
                            "#.#", //
                            ".##"});
  hold_node(triangle, {0, 1});
  hold_node(triangle, {0, 2});
  EXPECT_EQ(answer_of(triangle).status, Status::done);
  Scene opened = drawing({".#.", //
                          "#.#", //
                          "..#"});
  hold_node(opened, {0, 1});
  hold_node(opened, {0, 2});
  EXPECT_EQ(answer_of(opened).status, Status::refused);
}

/// Motions of a plane body of Q1 cells that cost no energy and keep the prescribed components: by singular
/// values of the strains at 2 x 2 points of every cell, and of the conditions. The obvious version.
int motions_without_strain(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  const auto n = static_cast<Eigen::Index>(grid.n_nodes());
  std::vector<Eigen::RowVectorXd> rows;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    for (int point = 0; scene.specimen.is_matter(cell) && point < 4; ++point) {
      const double x = point & 1 ? 0.8 : 0.2, y = point & 2 ? 0.8 : 0.2;
      Eigen::RowVectorXd xx = Eigen::RowVectorXd::Zero(2 * n), yy = xx, xy = xx;
      for (int corner = 0; corner < 4; ++corner) {
        const Eigen::Index node = grid.corner(grid.cell_at(cell), corner);
        const double dx = (corner & 1 ? 1 : -1) * (corner & 2 ? y : 1 - y);
        const double dy = (corner & 2 ? 1 : -1) * (corner & 1 ? x : 1 - x);
        xx[2 * node] = dx;
        yy[2 * node + 1] = dy;
        xy[2 * node] = dy;
        xy[2 * node + 1] = dx;
      }
      rows.insert(rows.end(), {xx, yy, xy});
    }
  const auto fix = [&](Eigen::Index unknown) {
    rows.push_back(Eigen::RowVectorXd::Zero(2 * n));
    rows.back()[unknown] = 1;
  };
  for (const Prescribed& p : scene.prescribed)
    fix(2 * p.node + p.component);
  for (Eigen::Index node = 0; node < n; ++node)
    if (!scene.specimen.is_node(grid.node_at(node)))
      for (int c = 0; c < 2; ++c)
        fix(2 * node + c);
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows.size()), 2 * n);
  for (std::size_t k = 0; k < rows.size(); ++k)
    matrix.row(static_cast<Eigen::Index>(k)) = rows[k];
  const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(matrix).singularValues();
  return static_cast<int>((values.array() < 1e-9 * values[0]).count());
}

TEST(RigidMotionOracle, RefusesExactlyTheBodiesThatCanMove) {
  std::mt19937 random(20240611);
  int refused = 0, solved = 0;
  for (int k = 0; k < 300; ++k) {
    Scene scene = test::box_scene(2, {4, 4, 1});
    test::carve(scene, static_cast<unsigned>(k), 0.45);
    for (int condition = 0; condition < 6; ++condition) {
      const auto node = static_cast<std::int64_t>(random() % 25);
      if (scene.specimen.is_node(scene.specimen.grid.node_at(node)))
        scene.prescribed.push_back({node, static_cast<int>(random() % 2), 0, true});
    }
    if (scene.prescribed.empty() || scene.specimen.n_matter_cells() == 0)
      continue;
    const Answer answer = answer_of(scene);
    const int motions = motions_without_strain(scene);
    EXPECT_EQ(answer.status, motions > 0 ? Status::refused : Status::done)
        << fmt::format("body {}: {} motions, {}", k, motions, answer.message);
    ++(motions > 0 ? refused : solved);
  }
  EXPECT_GT(refused, 20); // both kinds occurred
  EXPECT_GT(solved, 20);
}

} // namespace
} // namespace maille
