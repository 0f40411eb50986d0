#include "export/vtk_files.hpp"
#include "export/world/world_files.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "studies/export/export_reading.hpp"
#include "studies/export/export_scenes.hpp"
#include "support/kit.hpp"

#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>

namespace maille::studies {
namespace {

namespace fs = std::filesystem;
using test::block;
using test::block_with_holes;
using test::read_back;
using test::TemporaryFolder;
using test::text_of;
using test::tuple3;
using test::wave;

/// Numbers of the grid's nodes (cells) that a file must hold, in its order.
std::vector<std::int64_t> nodes_of(const Specimen& specimen) {
  std::vector<std::int64_t> nodes;
  for (std::int64_t node = 0; node < specimen.grid.n_nodes(); ++node)
    if (specimen.is_node(specimen.grid.node_at(node)))
      nodes.push_back(node);
  return nodes;
}
std::vector<std::int64_t> cells_of(const Specimen& specimen) {
  std::vector<std::int64_t> cells;
  for (std::int64_t cell = 0; cell < specimen.grid.n_cells(); ++cell)
    if (specimen.is_matter(cell))
      cells.push_back(cell);
  return cells;
}

struct Body {
  const char* name;
  Scene scene;
  const char* ending;
};

/// GoogleTest prints the name, not the bytes.
void PrintTo(const Body& body, std::ostream* stream) {
  *stream << body.name;
}

std::vector<Body> bodies() {
  return {{"line", block(1, {7, 1, 1}), ".vti"},
          {"sheet", block(2, {5, 4, 1}), ".vti"},
          {"box", block(3, {4, 3, 2}), ".vti"},
          {"one_cell", block(3, {1, 1, 1}), ".vti"},
          {"one_link", block(1, {1, 1, 1}), ".vti"},
          {"holed_line", block_with_holes(1, {7, 1, 1}), ".vtu"},
          {"holed_sheet", block_with_holes(2, {5, 4, 1}), ".vtu"},
          {"holed_box", block_with_holes(3, {4, 3, 2}), ".vtu"}};
}

class ExportedFileContract : public testing::TestWithParam<Body> {
protected:
  const Scene& scene() const { return GetParam().scene; }
  Displacement displacement_ = wave(GetParam().scene, 1e-4);
  Displacement reference_ = wave(GetParam().scene, 1.1e-4, 0.1);
  TemporaryFolder folder_;
  fs::path file_ =
      write_vtk(GetParam().scene, {&displacement_, &reference_, nullptr, R"({"maille":"0"})", 0.25},
                folder_ / "answer.v1");
  vtkSmartPointer<vtkDataSet> data_ = read_back(file_);
};

// Names, component counts and order as in docs/files.md.
TEST_P(ExportedFileContract, HoldsEveryArrayOfTheDesign) {
  EXPECT_EQ(file_.filename(), std::string("answer.v1") + GetParam().ending);
  vtkPointData& points = *data_->GetPointData();
  ASSERT_EQ(points.GetNumberOfArrays(), 3);
  for (const char* name : {"Displacement", "DisplacementReference", "DisplacementError"}) {
    vtkDataArray* array = points.GetArray(name);
    ASSERT_NE(array, nullptr) << name;
    EXPECT_EQ(array->GetNumberOfComponents(), 3);
    EXPECT_EQ(array->GetDataType(), VTK_DOUBLE);
    EXPECT_EQ(array->GetNumberOfTuples(), scene().specimen.n_matter_nodes());
    EXPECT_STREQ(array->GetComponentName(0), "X");
    EXPECT_STREQ(array->GetComponentName(2), "Z");
  }
  ASSERT_NE(points.GetVectors(), nullptr);
  EXPECT_STREQ(points.GetVectors()->GetName(), "Displacement");

  vtkCellData& cells = *data_->GetCellData();
  ASSERT_EQ(cells.GetNumberOfArrays(), 6); // isotropic matter has no strain along fibres
  const std::vector<std::pair<const char*, int>> expected{{"MaterialId", 1}, {"FiberDirection", 3},
                                                          {"Strain", 6},     {"PrincipalStrain", 3},
                                                          {"Stress", 6},     {"VonMises", 1}};
  for (const auto& [name, n_components] : expected) {
    vtkDataArray* array = cells.GetArray(name);
    ASSERT_NE(array, nullptr) << name;
    EXPECT_EQ(array->GetNumberOfComponents(), n_components) << name;
    EXPECT_EQ(array->GetNumberOfTuples(), scene().specimen.n_matter_cells()) << name;
  }
  EXPECT_EQ(cells.GetArray("MaterialId")->GetDataType(), VTK_UNSIGNED_CHAR);
  const std::array<const char*, 6> order{"XX", "YY", "ZZ", "XY", "YZ", "XZ"};
  for (int component = 0; component < 6; ++component)
    for (const char* name : {"Strain", "Stress"})
      EXPECT_STREQ(cells.GetArray(name)->GetComponentName(component), order[std::size_t(component)]);
}

TEST_P(ExportedFileContract, HoldsUnitsProvenanceAndTime) {
  vtkFieldData& fields = *data_->GetFieldData();
  const auto text = [&](const char* name) {
    auto* array = vtkStringArray::SafeDownCast(fields.GetAbstractArray(name));
    return array == nullptr ? std::string("missing") : std::string(array->GetValue(0));
  };
  EXPECT_EQ(text("Provenance"), R"({"maille":"0"})");
  EXPECT_TRUE(test::has(text("Units"), "Stress: Pa"));
  ASSERT_NE(fields.GetArray("TimeValue"), nullptr);
  EXPECT_EQ(fields.GetArray("TimeValue")->GetTuple1(0), 0.25);
}

// Truth: the arrays that went in; a file is a copy, so every bit counts.
TEST_P(ExportedFileContract, KeepsEveryBitOfTheValues) {
  const Specimen& specimen = scene().specimen;
  vtkPointData& points = *data_->GetPointData();
  vtkIdType tuple = 0;
  for (const std::int64_t node : nodes_of(specimen)) {
    Vec3 moved{}, expected{};
    for (int axis = 0; axis < scene().dimension(); ++axis) {
      moved[std::size_t(axis)] = displacement_(axis, node);
      expected[std::size_t(axis)] = reference_(axis, node);
    }
    EXPECT_EQ(tuple3(*points.GetArray("Displacement"), tuple), moved);
    EXPECT_EQ(tuple3(*points.GetArray("DisplacementReference"), tuple), expected);
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_EQ(tuple3(*points.GetArray("DisplacementError"), tuple)[axis], moved[axis] - expected[axis]);
    ++tuple;
  }

  const CellFields fields = cell_fields(scene(), displacement_);
  vtkCellData& cells = *data_->GetCellData();
  tuple = 0;
  for (const std::int64_t cell : cells_of(specimen)) {
    const auto c = std::size_t(cell);
    std::array<double, 6> strain{}, stress{};
    cells.GetArray("Strain")->GetTuple(tuple, strain.data());
    cells.GetArray("Stress")->GetTuple(tuple, stress.data());
    EXPECT_EQ(strain, fields.strain[c]);
    EXPECT_EQ(stress, fields.stress[c]);
    EXPECT_EQ(cells.GetArray("VonMises")->GetTuple1(tuple), fields.von_mises[c]);
    EXPECT_EQ(cells.GetArray("MaterialId")->GetTuple1(tuple), specimen.material(cell));
    EXPECT_EQ(tuple3(*cells.GetArray("FiberDirection"), tuple), specimen.fibre_of(cell));
    ++tuple;
  }
}

// Lengths alone: strain has none, stress stays in pascal.
TEST_P(ExportedFileContract, InMillimetresWhereThatIsAsked) {
  ExportFields fields{&displacement_, &reference_};
  fields.unit = LengthUnit::millimetre;
  const auto data = read_back(write_vtk(scene(), fields, folder_ / "in_mm"));
  for (vtkIdType point = 0; point < data_->GetNumberOfPoints(); ++point)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(data->GetPoint(point)[axis], 1e3 * data_->GetPoint(point)[axis], 1e-14);
      for (const char* name : {"Displacement", "DisplacementReference", "DisplacementError"})
        EXPECT_DOUBLE_EQ(tuple3(*data->GetPointData()->GetArray(name), point)[axis],
                         1e3 * tuple3(*data_->GetPointData()->GetArray(name), point)[axis]);
    }
  for (vtkIdType cell = 0; cell < data_->GetNumberOfCells(); ++cell)
    for (const char* name : {"Strain", "Stress", "VonMises", "FiberDirection"})
      EXPECT_EQ(data->GetCellData()->GetArray(name)->GetComponent(cell, 0),
                data_->GetCellData()->GetArray(name)->GetComponent(cell, 0));
  auto* units = vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray("Units"));
  const std::string text = units->GetValue(0);
  EXPECT_TRUE(text.starts_with("lengths: mm;")) << text;
  EXPECT_TRUE(test::has(text, "DisplacementErrorEstimate: mm;"));
  EXPECT_TRUE(test::has(text, "Stress: Pa"));
}

TEST_P(ExportedFileContract, PutsNodesAndCellsWhereTheyAre) {
  const Specimen& specimen = scene().specimen;
  ASSERT_EQ(data_->GetNumberOfPoints(), specimen.n_matter_nodes()); // no unused points
  ASSERT_EQ(data_->GetNumberOfCells(), specimen.n_matter_cells());
  vtkIdType point = 0;
  for (const std::int64_t node : nodes_of(specimen)) {
    const Vec3 expected = specimen.position(specimen.grid.node_at(node));
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(data_->GetPoint(point)[axis], expected[axis], 1e-17); // a rounding of 7e-3
    ++point;
  }
  vtkIdType number = 0;
  for (const std::int64_t cell : cells_of(specimen)) {
    const Vec3 low = specimen.position(specimen.grid.cell_at(cell));
    std::array<double, 6> bounds{};
    data_->GetCellBounds(number++, bounds.data());
    for (int axis = 0; axis < scene().dimension(); ++axis) {
      const auto a = std::size_t(axis);
      EXPECT_NEAR(bounds[2 * a], low[a], 1e-17);
      EXPECT_NEAR(bounds[2 * a + 1], low[a] + specimen.grid.spacing()[a], 1e-17);
    }
  }
}

TEST_P(ExportedFileContract, IsAppendedCompressedAndWide) {
  const std::string text = text_of(file_);
  EXPECT_TRUE(test::has(text, "compressor=\"vtkZLibDataCompressor\""));
  EXPECT_TRUE(test::has(text, "header_type=\"UInt64\""));
  EXPECT_TRUE(test::has(text, "<AppendedData encoding=\"raw\">"));
  // Written twice, it is the same file.
  const fs::path again = write_vtk(scene(), {&displacement_, &reference_, nullptr, R"({"maille":"0"})", 0.25},
                                   folder_ / "again");
  EXPECT_EQ(text_of(again), text_of(file_));
}

INSTANTIATE_TEST_SUITE_P(Bodies, ExportedFileContract, testing::ValuesIn(bodies()),
                         [](const auto& parameter) { return std::string(parameter.param.name); });

TEST(ExportContract, LeavesOutWhatIsNotGiven) {
  const Scene scene = block(3, {2, 2, 2});
  const Displacement displacement = wave(scene, 1e-4);
  TemporaryFolder folder;
  const auto data = read_back(write_vtk(scene, {&displacement}, folder / "answer"));
  EXPECT_EQ(data->GetPointData()->GetNumberOfArrays(), 1);
  EXPECT_EQ(data->GetFieldData()->GetArray("TimeValue"), nullptr);
}

TEST(ExportContract, ForcesStandAtTheNodesThatTheyHold) {
  Scene scene = block(3, {2, 2, 2});
  const std::int64_t corner = 0, other = scene.specimen.grid.n_nodes() - 1;
  scene.prescribed = {{corner, 0, 0, true}, {other, 0, 1e-4, false}, {other, 2, 0, false}};
  const std::vector<double> reaction{-2.5, 2.5, 0.75};
  const Displacement displacement = wave(scene, 1e-4);
  ExportFields fields;
  fields.displacement = &displacement;
  fields.reaction = &reaction;
  fields.strain_energy = 1.25e-4;
  std::vector<std::array<double, 6>> stress(std::size_t(other) + 1);
  stress.back() = {1, 2, 3, 4, 5, 6};
  fields.nodal_stress = &stress;
  TemporaryFolder folder;
  const auto data = read_back(write_vtk(scene, fields, folder / "answer"));
  vtkDataArray* const forces = data->GetPointData()->GetArray("Reaction");
  ASSERT_NE(forces, nullptr);
  EXPECT_EQ(tuple3(*forces, corner), (Vec3{-2.5, 0, 0}));
  EXPECT_EQ(tuple3(*forces, 1), (Vec3{0, 0, 0}));
  EXPECT_EQ(tuple3(*forces, other), (Vec3{2.5, 0, 0.75}));
  EXPECT_EQ(data->GetFieldData()->GetArray("StrainEnergy")->GetTuple1(0), 1.25e-4);
  vtkDataArray* const nodal = data->GetPointData()->GetArray("NodalStress");
  ASSERT_NE(nodal, nullptr);
  EXPECT_STREQ(nodal->GetComponentName(4), "YZ");
  EXPECT_EQ(nodal->GetComponent(other, 4), 5);
  EXPECT_EQ(data->GetPointData()->GetArray("NodalStrain"), nullptr);
}

TEST(ExportContract, KeepsValuesAtTheExtremes) {
  const Scene scene = block(1, {5, 1, 1});
  Displacement displacement(scene.specimen.grid);
  using Limits = std::numeric_limits<double>;
  std::ranges::copy(std::vector<double>{Limits::denorm_min(), Limits::max(), -Limits::max(),
                                        Limits::infinity(), Limits::quiet_NaN(), Limits::min()},
                    displacement.component(0).begin());
  TemporaryFolder folder;
  const auto data = read_back(write_vtk(scene, {&displacement}, folder / "answer"));
  for (vtkIdType node = 0; node < 6; ++node) {
    const double expected = displacement(0, node);
    const Vec3 found = tuple3(*data->GetPointData()->GetArray("Displacement"), node);
    EXPECT_TRUE(found[0] == expected || (std::isnan(found[0]) && std::isnan(expected))) << node;
    EXPECT_EQ(found[1], 0);
  }
}

/// A rigid box of one cell, and a soft one that stands turned by a right angle.
WorldScene scene() {
  return parse_world_scene(
      test::world_text("[20, 20]") + test::object_text("a box", "rigid", "[1, 1]") +
          test::object_text("soft", "deformable", "[2, 1]", "material = " + test::soft + R"(
position = ["10 mm", "10 mm"]
turn = { angle = "90 deg" }
)"),
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
  EXPECT_TRUE(test::has(list, "timestep=\"0.5\" part=\"0\" file=\"soft_a_box_0000.vtu\""));
  EXPECT_TRUE(test::has(list, "timestep=\"0.5\" part=\"1\" file=\"soft_soft_0001.vtu\""));

  const auto data = read_back(folder / "soft_soft_0001.vtu");
  const std::vector<Vec3> start = soft_nodes(1), now = soft_nodes(1.1);
  ASSERT_EQ(data->GetNumberOfPoints(), 6);
  for (int i = 0; i < 6; ++i) {
    const auto at = std::size_t(i);
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
  EXPECT_TRUE(test::has(list, "part=\"0\" file=\"hands_____0000.vtu\""));
  EXPECT_TRUE(test::has(list, "part=\"1\" file=\"hands____-2_0000.vtu\""));
  ASSERT_EQ(series.files().size(), 2u);
  EXPECT_EQ(read_back(series.files()[0])->GetNumberOfCells(), 1);
  EXPECT_EQ(read_back(series.files()[1])->GetNumberOfCells(), 2);
}

} // namespace
} // namespace maille::studies
