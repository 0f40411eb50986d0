#include "maille/studies/export/vtk_files.hpp"

#include "maille/scene/cell_fields.hpp"
#include "maille/studies/export/whole_file.hpp"
#include "studies/export_scenes.hpp"
#include "support/full_disk.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <pugixml.hpp>

#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <fstream>
#include <limits>
#include <ostream>
#include <sstream>

namespace maille::studies {
namespace {
namespace fs = std::filesystem;
using test::block;
using test::block_with_holes;
using test::FullDisk;
using test::TemporaryFolder;
using test::wave;

vtkSmartPointer<vtkDataSet> read_back(const fs::path& file) {
  if (file.extension() == ".vti") {
    vtkNew<vtkXMLImageDataReader> reader;
    reader->SetFileName(file.c_str());
    reader->Update();
    return vtkSmartPointer<vtkDataSet>(reader->GetOutputAsDataSet());
  }
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  return vtkSmartPointer<vtkDataSet>(reader->GetOutputAsDataSet());
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

Vec3 tuple3(vtkDataArray& array, vtkIdType tuple) {
  Vec3 values{};
  array.GetTuple(tuple, values.data());
  return values;
}

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
  fs::path file_ = write_vtk(GetParam().scene, {&displacement_, &reference_, R"({"maille":"0"})", 0.25},
                             folder_ / "answer.v1");
  vtkSmartPointer<vtkDataSet> data_ = read_back(file_);
};

// Names, component counts and order as in the design, "Files for ParaView".
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
  ASSERT_EQ(cells.GetNumberOfArrays(), 5);
  const std::vector<std::pair<const char*, int>> expected{
      {"MaterialId", 1}, {"FiberDirection", 3}, {"Strain", 6}, {"Stress", 6}, {"VonMises", 1}};
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
      EXPECT_STREQ(cells.GetArray(name)->GetComponentName(component),
                   order[static_cast<std::size_t>(component)]);
}

TEST_P(ExportedFileContract, HoldsUnitsProvenanceAndTime) {
  vtkFieldData& fields = *data_->GetFieldData();
  const auto text = [&](const char* name) {
    auto* array = vtkStringArray::SafeDownCast(fields.GetAbstractArray(name));
    return array == nullptr ? std::string("missing") : std::string(array->GetValue(0));
  };
  EXPECT_EQ(text("Provenance"), R"({"maille":"0"})");
  EXPECT_NE(text("Units").find("Stress: Pa"), std::string::npos) << text("Units");
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
      moved[static_cast<std::size_t>(axis)] = displacement_(axis, node);
      expected[static_cast<std::size_t>(axis)] = reference_(axis, node);
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
    const auto c = static_cast<std::size_t>(cell);
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
      const auto a = static_cast<std::size_t>(axis);
      EXPECT_NEAR(bounds[2 * a], low[a], 1e-17);
      EXPECT_NEAR(bounds[2 * a + 1], low[a] + specimen.grid.spacing()[a], 1e-17);
    }
  }
}

TEST_P(ExportedFileContract, IsAppendedCompressedAndWide) {
  const std::string text = text_of(file_);
  EXPECT_NE(text.find("compressor=\"vtkZLibDataCompressor\""), std::string::npos);
  EXPECT_NE(text.find("header_type=\"UInt64\""), std::string::npos);
  EXPECT_NE(text.find("<AppendedData encoding=\"raw\">"), std::string::npos);
}

TEST_P(ExportedFileContract, IsTheSameFileTwice) {
  const fs::path again =
      write_vtk(scene(), {&displacement_, &reference_, R"({"maille":"0"})", 0.25}, folder_ / "again");
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

TEST(ExportContract, KeepsValuesAtTheExtremes) {
  const Scene scene = block(1, {5, 1, 1});
  Displacement displacement(scene.specimen.grid);
  using Limits = std::numeric_limits<double>;
  displacement.component[0] = {Limits::denorm_min(), Limits::max(),       -Limits::max(),
                               Limits::infinity(),   Limits::quiet_NaN(), Limits::min()};
  TemporaryFolder folder;
  const auto data = read_back(write_vtk(scene, {&displacement}, folder / "answer"));
  for (vtkIdType node = 0; node < 6; ++node) {
    const double expected = displacement(0, node);
    const Vec3 found = tuple3(*data->GetPointData()->GetArray("Displacement"), node);
    EXPECT_TRUE(found[0] == expected || (std::isnan(found[0]) && std::isnan(expected))) << node;
    EXPECT_EQ(found[1], 0);
  }
}

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
      displacement.component[static_cast<std::size_t>(axis)].assign(
          static_cast<std::size_t>(scene.specimen.grid.n_nodes()), axis + 1.0);
      reference.component[static_cast<std::size_t>(axis)].assign(
          static_cast<std::size_t>(scene.specimen.grid.n_nodes()), 10.0 * (axis + 1));
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

TEST(ExportContract, RefusesFieldsOfAnotherGrid) {
  const Scene scene = block(3, {2, 2, 2});
  const Displacement fits(scene.specimen.grid), other(Grid(3, {2, 2, 3}, {1, 1, 1}));
  TemporaryFolder folder;
  EXPECT_THROW(write_vtk(scene, {}, folder / "answer"), std::invalid_argument);
  EXPECT_THROW(write_vtk(scene, {&other}, folder / "answer"), std::invalid_argument);
  EXPECT_THROW(write_vtk(scene, {&fits, &other}, folder / "answer"), std::invalid_argument);
  EXPECT_TRUE(folder.is_empty());
}

TEST(ExportContract, SaysWhereItCouldNotWrite) {
  for (const Scene& scene : {block(3, {2, 2, 2}), block_with_holes(3, {2, 2, 2})}) {
    const Displacement displacement(scene.specimen.grid);
    TemporaryFolder folder;
    for (const fs::path& stem : {folder / "missing/answer", folder / "file/answer"}) {
      std::ofstream(folder / "file") << "no folder";
      try {
        write_vtk(scene, {&displacement}, stem);
        ADD_FAILURE() << "written to " << stem;
      } catch (const fs::filesystem_error& error) {
        EXPECT_NE(std::string(error.what()).find(stem.string()), std::string::npos) << error.what();
      }
    }
    EXPECT_FALSE(fs::exists(folder / "missing"));
    EXPECT_EQ(text_of(folder / "file"), "no folder");
  }
}

TEST(ExportContract, LeavesNoHalfFileOnAFullDisk) {
  for (const Scene& scene : {block(3, {12, 12, 12}), block_with_holes(3, {12, 12, 12})}) {
    const Displacement displacement = wave(scene, 1e-4);
    TemporaryFolder folder;
    {
      // All room but for the last kilobytes, so that the writer has long begun.
      const fs::path whole = write_vtk(scene, {&displacement}, folder / "answer");
      const auto size = fs::file_size(whole);
      fs::remove(whole);
      const FullDisk full(size - 4096);
      testing::internal::CaptureStderr();
      EXPECT_THROW(write_vtk(scene, {&displacement}, folder / "answer"), std::runtime_error);
      EXPECT_EQ(testing::internal::GetCapturedStderr(), ""); // libraries never print
      EXPECT_THROW(write_whole(folder / "text", std::string(size, 'x')), std::runtime_error);
    }
    EXPECT_TRUE(folder.is_empty());
  }
}

TEST(ExportContract, KeepsTheOlderFileIfItFails) {
  const Scene scene = block(3, {12, 12, 12});
  const Displacement displacement = wave(scene, 1e-4);
  TemporaryFolder folder;
  std::ofstream(folder / "answer.vti") << "older";
  {
    const FullDisk full(2000);
    EXPECT_THROW(write_vtk(scene, {&displacement}, folder / "answer"), std::runtime_error);
  }
  EXPECT_EQ(text_of(folder / "answer.vti"), "older");
  write_vtk(scene, {&displacement}, folder / "answer");
  EXPECT_EQ(read_back(folder / "answer.vti")->GetNumberOfCells(), 12 * 12 * 12);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

TEST(PvdContract, ListsASeriesWithTimesAndRelativePaths) {
  const Scene scene = block(2, {3, 2, 1});
  const Displacement displacement = wave(scene, 1e-4);
  TemporaryFolder folder;
  PvdSeries series(folder / "pull & <turn>", 3);
  const std::array<double, 3> times{0, 0.1, 1.0 / 3};
  for (const double time : times)
    series.add(scene, {&displacement}, time);
  const fs::path pvd = series.write();
  EXPECT_EQ(pvd, folder / "pull & <turn>.pvd");

  pugi::xml_document document;
  ASSERT_TRUE(document.load_file(pvd.c_str()));
  EXPECT_STREQ(document.child("VTKFile").attribute("type").value(), "Collection");
  std::size_t step = 0;
  for (const pugi::xml_node entry : document.child("VTKFile").child("Collection").children("DataSet")) {
    ASSERT_LT(step, times.size());
    EXPECT_EQ(entry.attribute("timestep").as_double(), times[step]);
    const std::string file = entry.attribute("file").value();
    EXPECT_EQ(file, "pull & <turn>_000" + std::to_string(step) + ".vti");
    const auto data = read_back(folder / file);
    EXPECT_EQ(data->GetFieldData()->GetArray("TimeValue")->GetTuple1(0), times[step]);
    ++step;
  }
  EXPECT_EQ(step, times.size());
}

TEST(PvdContract, ReachesFilesInOtherFolders) {
  TemporaryFolder folder;
  fs::create_directories(folder / "list");
  write_pvd({{0, folder / "steps/a.vtu"}, {1, folder / "list/b.vtu"}}, folder / "list/run.pvd");
  pugi::xml_document document;
  ASSERT_TRUE(document.load_file((folder / "list/run.pvd").c_str()));
  const pugi::xml_node first = document.child("VTKFile").child("Collection").first_child();
  EXPECT_STREQ(first.attribute("file").value(), "../steps/a.vtu");
  EXPECT_STREQ(first.next_sibling().attribute("file").value(), "b.vtu");
}

TEST(PvdContract, NumbersStepsWithEnoughDigits) {
  const Scene scene = block(1, {1, 1, 1});
  const Displacement displacement(scene.specimen.grid);
  TemporaryFolder folder;
  EXPECT_EQ(PvdSeries(folder / "a", 10000).add(scene, {&displacement}, 0), folder / "a_0000.vti");
  EXPECT_EQ(PvdSeries(folder / "b", 10001).add(scene, {&displacement}, 0), folder / "b_00000.vti");
  EXPECT_THROW(write_pvd({}, folder / "missing/c.pvd"), fs::filesystem_error);
}

} // namespace
} // namespace maille::studies
