#include "export/world/world_files.hpp"

#include "maille/scene/world/world_scene.hpp"
#include "studies/export/export_reading.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>

namespace maille::studies {
namespace {
using test::read_back;
using test::tuple3;

/// A rigid box of one cell, and a soft one that stands turned by a right angle.
WorldScene scene() {
  return parse_world_scene(R"(
[world]
cells = [20, 20]
spacing = "1 mm"
[[object]]
name = "a box"
kind = "rigid"
shape = "box"
cells = [1, 1]
[[object]]
name = "soft"
kind = "deformable"
shape = "box"
cells = [2, 1]
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
position = ["10 mm", "10 mm"]
turn = { angle = "90 deg" }
)",
                           "soft.toml");
}

NodePositions shared(std::vector<Vec3> positions) {
  return std::make_shared<const std::vector<Vec3>>(std::move(positions));
}

/// Nodes of the soft object, x fastest, stretched along its own x axis, which is the world's y.
std::vector<Vec3> soft_nodes(double stretch) {
  std::vector<Vec3> nodes;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 3; ++i)
      nodes.push_back({0.01 - 1e-3 * j, 0.01 + stretch * 1e-3 * i, 0});
  return nodes;
}

// Truth: an even stretch of 10 %, of plane strain; Lame's constants of E = 10 kPa, nu = 0.3.
TEST(WorldFilesAnalytic, FilesShowWhereObjectsAreAndHowTheyAreStrained) {
  const WorldScene world = scene();
  const test::TemporaryFolder folder;
  WorldSeries series(world, folder / "soft", 2, "{\"who\": \"a test\"}");
  const auto box = shared({{0, 0, 0}, {1e-3, 0, 0}, {0, 1e-3, 0}, {1e-3, 1e-3, 0}});
  series.add({0, {box, shared(soft_nodes(1))}, {}});
  series.add({0.5, {box, shared(soft_nodes(1.1))}, {}});
  EXPECT_EQ(series.n_files(), 3u); // the box has not moved
  const std::string list = test::text_of(series.write());
  EXPECT_NE(list.find("timestep=\"0.5\" part=\"0\" file=\"soft_a_box_0000.vtu\""), std::string::npos) << list;
  EXPECT_NE(list.find("timestep=\"0.5\" part=\"1\" file=\"soft_soft_0001.vtu\""), std::string::npos) << list;

  const auto data = read_back(folder / "soft_soft_0001.vtu");
  const std::vector<Vec3> start = soft_nodes(1), now = soft_nodes(1.1);
  ASSERT_EQ(data->GetNumberOfPoints(), 6);
  for (int i = 0; i < 6; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double* point = data->GetPoint(i);
    EXPECT_EQ((Vec3{point[0], point[1], point[2]}), now[at]);
    const Vec3 moved = tuple3(*data->GetPointData()->GetArray("Displacement"), i);
    EXPECT_EQ(moved, (Vec3{now[at][0] - start[at][0], now[at][1] - start[at][1], 0}));
  }
  constexpr double lambda = 1e4 * 0.3 / (1.3 * 0.4), mu = 1e4 / 2.6, strain = 0.1;
  for (int cell = 0; cell < 2; ++cell) {
    EXPECT_EQ(data->GetCellData()->GetArray("ObjectId")->GetTuple1(cell), 1);
    // Along the object's own x, which is the world's y.
    EXPECT_NEAR(data->GetCellData()->GetArray("Strain")->GetComponent(cell, 0), 0, 1e-12);
    EXPECT_NEAR(data->GetCellData()->GetArray("Strain")->GetComponent(cell, 1), strain, 1e-12);
    EXPECT_NEAR(data->GetCellData()->GetArray("PrincipalStrain")->GetComponent(cell, 0), strain, 1e-12);
    EXPECT_NEAR(data->GetCellData()->GetArray("Stress")->GetComponent(cell, 0), lambda * strain, 1e-6);
    EXPECT_NEAR(data->GetCellData()->GetArray("Stress")->GetComponent(cell, 1), (lambda + 2 * mu) * strain,
                1e-6);
  }
  EXPECT_EQ(data->GetFieldData()->GetArray("TimeValue")->GetTuple1(0), 0.5);
  EXPECT_EQ(data->GetFieldData()->GetAbstractArray("ObjectName")->GetVariantValue(0).ToString(), "soft");
  const auto rigid = read_back(folder / "soft_a_box_0000.vtu");
  EXPECT_EQ(rigid->GetNumberOfCells(), 1);
  EXPECT_EQ(rigid->GetCellData()->GetArray("Stress"), nullptr);
}

// Truth: two names in another script; file systems need not know either.
TEST(WorldFilesAnalytic, ObjectsKeepFilesOfTheirOwnWhateverTheyAreCalled) {
  WorldScene world = scene();
  world.objects[0].name = "\u5de6";
  world.objects[1].name = "\u53f3";
  const test::TemporaryFolder folder;
  WorldSeries series(world, folder / "hands", 1, "{}");
  series.add(
      {0, {shared({{0, 0, 0}, {1e-3, 0, 0}, {0, 1e-3, 0}, {1e-3, 1e-3, 0}}), shared(soft_nodes(1))}, {}});
  const std::string list = test::text_of(series.write());
  EXPECT_NE(list.find("part=\"0\" file=\"hands_____0000.vtu\""), std::string::npos) << list;
  EXPECT_NE(list.find("part=\"1\" file=\"hands____-2_0000.vtu\""), std::string::npos) << list;
  ASSERT_EQ(series.files().size(), 2u);
  EXPECT_EQ(read_back(series.files()[0])->GetNumberOfCells(), 1);
  EXPECT_EQ(read_back(series.files()[1])->GetNumberOfCells(), 2);
}

} // namespace
} // namespace maille::studies
