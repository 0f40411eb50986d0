#include "export/vtk_files.hpp"

#include "studies/export/export_reading.hpp"
#include "studies/export/export_scenes.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

namespace maille::studies {
namespace {
using test::block;
using test::block_with_holes;
using test::read_back;
using test::TemporaryFolder;
using test::tuple3;

// Truth: VTK file formats, figure of the linear cell types: a hexahedron's points run round the bottom, then
// round the top; a quad's run round.
TEST(ExportAnalytic, CornersRunRoundTheCell) {
  const std::array<Index3, 8> round{
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
  for (const int dimension : {1, 2, 3}) {
    const Scene scene = block_with_holes(dimension, {4, 3, 2});
    const Displacement displacement(scene.specimen.grid);
    TemporaryFolder folder;
    const auto data = read_back(write_vtk(scene, {&displacement}, folder / "answer"));
    const std::array<int, 4> types{0, VTK_LINE, VTK_QUAD, VTK_HEXAHEDRON};
    ASSERT_EQ(data->GetCellType(0), types[static_cast<std::size_t>(dimension)]);
    for (int corner = 0; corner < (1 << dimension); ++corner) {
      const Vec3 expected = scene.specimen.position(round[static_cast<std::size_t>(corner)]);
      const double* found = data->GetCell(0)->GetPoints()->GetPoint(corner);
      EXPECT_EQ((Vec3{found[0], found[1], found[2]}), expected) << dimension << " " << corner;
    }
  }
}

/// Turned by 90 degrees about z: the object's x runs along the world's y, its y along the world's -x.
Placement quarter_turn() {
  return {{0.1, 0.2, 0.3}, {{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}};
}

// Truth: the quarter turn maps (a, b, c) to (-b, a, c), exactly in floating point.
TEST(ExportAnalytic, TurnsVectorsIntoTheWorldFrame) {
  for (Scene scene :
       {block(3, {2, 2, 2}), block_with_holes(3, {2, 2, 2}), block(2, {2, 2, 1}), block(1, {2, 1, 1})}) {
    scene.specimen.placement = quarter_turn();
    Displacement displacement(scene.specimen.grid), reference(scene.specimen.grid);
    for (int axis = 0; axis < scene.dimension(); ++axis) {
      std::ranges::fill(displacement.component(axis), axis + 1.0);
      std::ranges::fill(reference.component(axis), 10.0 * (axis + 1));
    }
    TemporaryFolder folder;
    const auto data = read_back(write_vtk(scene, {&displacement, &reference}, folder / "answer"));
    const double a = 1, b = scene.dimension() > 1 ? 2 : 0, c = scene.dimension() > 2 ? 3 : 0;
    vtkPointData& points = *data->GetPointData();
    EXPECT_EQ(tuple3(*points.GetArray("Displacement"), 0), (Vec3{-b, a, c}));
    EXPECT_EQ(tuple3(*points.GetArray("DisplacementReference"), 0), (Vec3{-10 * b, 10 * a, 10 * c}));
    EXPECT_EQ(tuple3(*points.GetArray("DisplacementError"), 0), (Vec3{9 * b, -9 * a, -9 * c}));
    EXPECT_EQ(tuple3(*data->GetCellData()->GetArray("FiberDirection"), 0), (Vec3{-0.8, 0.6, 0}));
    const Vec3 rest = scene.specimen.position({1, 0, 0}); // the second node of every one of these bodies
    const double* found = data->GetPoint(1);
    EXPECT_NEAR(found[0], 0.1 - rest[1], 1e-16); // a rounding of 0.1
    EXPECT_NEAR(found[1], 0.2 + rest[0], 1e-16);
    EXPECT_NEAR(found[2], 0.3 + rest[2], 1e-16);
  }
}

// Truth: a rotation by 36.87 and 22.62 degrees from the triangles 3-4-5 and 5-12-13.
TEST(ExportAnalytic, KeepsTheDirectionMatrix) {
  Scene scene = block(3, {3, 2, 2});
  scene.specimen.placement = {
      {-0.01, 0.02, 0.05},
      {{{0.8, -0.6 * 12 / 13, 0.6 * 5 / 13}, {0.6, 0.8 * 12 / 13, -0.8 * 5 / 13}, {0, 5.0 / 13, 12.0 / 13}}}};
  const Displacement displacement(scene.specimen.grid);
  TemporaryFolder folder;
  const auto data = read_back(write_vtk(scene, {&displacement}, folder / "answer"));
  auto& image = dynamic_cast<vtkImageData&>(*data);
  const Placement& placement = scene.specimen.placement;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      EXPECT_EQ(image.GetDirectionMatrix()->GetElement(row, column),
                placement.direction[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)]);
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(node));
    for (std::size_t row = 0; row < 3; ++row) {
      const Vec3& direction = placement.direction[row];
      const double expected =
          placement.origin[row] + direction[0] * x[0] + direction[1] * x[1] + direction[2] * x[2];
      EXPECT_NEAR(image.GetPoint(node)[row], expected, 1e-16); // some roundings of 0.05
    }
  }
}

} // namespace
} // namespace maille::studies
