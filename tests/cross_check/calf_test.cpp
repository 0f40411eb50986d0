/// Muscles from MRI: all methods side by side, written, and opened again by VTK.

#include "compare/comparison.hpp"
#include "compare/methods.hpp"
#include "export/vtk_files.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/kit.hpp"

#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

namespace maille {
namespace {

bool data_is_there() {
  return std::getenv("MAILLE_DATA") != nullptr;
}

Scene shared_scene(const char* name) {
  return read_scene(std::filesystem::path(MAILLE_SCENES) / name);
}

/// What the wavefront states (wavefront.hpp): 3 quanta, a quantum being at most 2^-29 of the largest
/// difference of displacements; in units of the shortest link.
double wavefront_bound(const Scene& scene) {
  const Vec3& h = scene.specimen.grid.spacing();
  return 3 * std::ldexp(scene.largest_prescribed(), -29) / std::min({h[0], h[1], h[2]});
}

TEST(CalfData, OneMuscleByThreeMethodsIsWrittenAndOpenedAgain) {
  if (!data_is_there())
    GTEST_SKIP() << "MAILLE_DATA is not set: no calf";
  const Scene scene = shared_scene("calf_soleus.toml");
  // The data's README counts 6,417 voxels of label 17.
  std::int64_t cells = scene.specimen.n_matter_cells();
  for (const LeftOutPiece& piece : scene.left_out)
    cells += piece.cells;
  EXPECT_EQ(cells, 6417);

  const auto comparison = studies::compare_methods(scene, {"limits", "sweep", "fem_q1"}, "fem_q1", {});
  EXPECT_EQ(comparison.rows[0].answer.algorithm, "tiled wavefront");
  const Answer dijkstra = studies::answer_by(scene, "dijkstra", {});
  for (std::size_t i = 0; i < dijkstra.displacement.values().size(); ++i) // (links of a path + 2) quanta
    ASSERT_NEAR(comparison.rows[0].answer.displacement.values()[i], dijkstra.displacement.values()[i],
                200 * std::ldexp(scene.largest_prescribed(), -29));
  const auto* reference = comparison.reference_row();
  ASSERT_NE(reference, nullptr);
  const test::TemporaryFolder folder;
  for (const auto& row : comparison.rows) {
    ASSERT_EQ(row.answer.status, Status::done) << row.answer.method << ": " << row.answer.message;
    if (row.answer.method != "fem_q1") {
      EXPECT_LT(*row.limit_violation, wavefront_bound(scene)) << row.answer.method;
      EXPECT_GT(row.error->relative_l2, 0.0);
      EXPECT_LT(row.error->relative_l2, 1.0) << row.answer.method << ": worse than no answer at all";
    }
    studies::ExportFields fields;
    fields.displacement = &row.answer.displacement;
    fields.reference = &reference->answer.displacement;
    const auto file = studies::write_vtk(scene, fields, folder / row.answer.method);
    vtkNew<vtkXMLUnstructuredGridReader> reader;
    reader->SetFileName(file.c_str());
    reader->Update();
    EXPECT_EQ(reader->GetOutput()->GetNumberOfCells(), scene.specimen.n_matter_cells());
    EXPECT_EQ(reader->GetOutput()->GetNumberOfPoints(), scene.specimen.n_matter_nodes());
    for (const char* name : {"Displacement", "DisplacementReference", "DisplacementError"})
      EXPECT_NE(reader->GetOutput()->GetPointData()->GetArray(name), nullptr) << name;
    for (const char* name : {"MaterialId", "FiberDirection", "Strain", "Stress", "VonMises"})
      EXPECT_NE(reader->GetOutput()->GetCellData()->GetArray(name), nullptr) << name;
  }
}

TEST(CalfData, FourteenMusclesOfBothLegsRunInOneSceneOfTwoMaterials) {
  if (!data_is_there())
    GTEST_SKIP() << "MAILLE_DATA is not set: no calves";
  const Scene scene = shared_scene("calf_both_legs.toml");
  EXPECT_EQ(scene.materials.size(), 2u);
  std::int64_t cells = scene.specimen.n_matter_cells();
  for (const LeftOutPiece& piece : scene.left_out) {
    cells += piece.cells;
    EXPECT_FALSE(piece.name.empty());
  }
  EXPECT_EQ(cells, 35588); // the data's README
  const auto comparison = studies::compare_methods(scene, {"limits"}, "fem_q1", {});
  for (const auto& row : comparison.rows)
    EXPECT_EQ(row.answer.status, Status::done) << row.answer.method << ": " << row.answer.message;
  EXPECT_LT(*comparison.rows[0].limit_violation, wavefront_bound(scene));
}

} // namespace
} // namespace maille
