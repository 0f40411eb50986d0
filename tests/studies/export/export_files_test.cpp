#include "export/answer_fields.hpp"
#include "export/vtk_files.hpp"
#include "export/whole_file.hpp"
#include "program.hpp"
#include "studies/export/export_reading.hpp"
#include "studies/export/export_scenes.hpp"
#include "support/kit.hpp"

#include <future>
#include <pugixml.hpp>
#include <sys/stat.h>
#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkCompositeDataSet.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkMatrix3x3.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLMultiBlockDataReader.h>
#include <vtkXMLPUnstructuredGridReader.h>

namespace maille::studies {
namespace {

namespace fs = std::filesystem;
using test::block;
using test::block_with_holes;
using test::FullDisk;
using test::read_back;
using test::TemporaryFolder;
using test::text_of;
using test::tuple3;
using test::wave;

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
        EXPECT_TRUE(test::has(std::string(error.what()), stem.string()));
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

/// @returns by its name and place, every number of an array of points
std::map<std::pair<std::string, std::array<double, 3>>, std::vector<double>>
numbers_at_points(vtkDataSet& body) {
  std::map<std::pair<std::string, std::array<double, 3>>, std::vector<double>> numbers;
  vtkPointData& data = *body.GetPointData();
  for (int a = 0; a < data.GetNumberOfArrays(); ++a)
    for (vtkIdType i = 0; i < body.GetNumberOfPoints(); ++i) {
      std::array<double, 3> at{};
      body.GetPoint(i, at.data());
      std::vector<double>& of = numbers[{data.GetArray(a)->GetName(), at}];
      of.resize(static_cast<std::size_t>(data.GetArray(a)->GetNumberOfComponents()));
      data.GetArray(a)->GetTuple(i, of.data());
    }
  return numbers;
}

void expect_same_cell_arrays(vtkCellData& pieces, vtkCellData& whole) {
  ASSERT_EQ(pieces.GetNumberOfArrays(), whole.GetNumberOfArrays());
  for (int a = 0; a < whole.GetNumberOfArrays(); ++a) {
    vtkDataArray &one = *pieces.GetArray(whole.GetArrayName(a)), &other = *whole.GetArray(a);
    ASSERT_EQ(one.GetNumberOfValues(), other.GetNumberOfValues()) << other.GetName();
    for (vtkIdType i = 0; i < other.GetNumberOfTuples(); ++i)
      for (int c = 0; c < other.GetNumberOfComponents(); ++c)
        ASSERT_EQ(one.GetComponent(i, c), other.GetComponent(i, c)) << other.GetName() << ' ' << i;
  }
}

// Truth: the file of the whole. With one material and with two; nodes at the border may have either value.
TEST(ExportContract, PiecesOfALargeBodyHaveWhatOneFileHas) {
  for (const bool has_two : {false, true}) {
    Scene scene = block_with_holes(3, {5, 4, 17});
    if (!has_two)
      std::ranges::replace(scene.specimen.material_id, std::uint8_t{1}, std::uint8_t{0});
    for (std::int64_t node = 0; node < 4; ++node)
      scene.prescribed.push_back({node, 2, 0, true, -1});
    const Displacement displacement = wave(scene, 1e-4);
    const std::vector<double> reaction{1, 2, 3, 4};
    const std::vector<std::array<double, 6>> recovered;
    ExportFields fields{&displacement};
    fields.reaction = &reaction;
    fields.nodal_strain = fields.nodal_stress = &recovered;
    TemporaryFolder folder;
    const auto whole = read_back(write_vtk(scene, fields, folder / "whole"));
    fields.most_cells = 220; // of 227
    fields.threads = 2;
    const fs::path list = write_vtk(scene, fields, folder / "parts");
    EXPECT_EQ(list, folder / "parts.pvtu");
    EXPECT_TRUE(fs::exists(folder / "parts/0003.vtu"));
    vtkNew<vtkXMLPUnstructuredGridReader> reader;
    reader->SetFileName(list.c_str());
    reader->Update();
    vtkDataSet& pieces = *reader->GetOutput();
    expect_same_cell_arrays(*pieces.GetCellData(), *whole->GetCellData());
    auto at_points = numbers_at_points(pieces), expected = numbers_at_points(*whole);
    if (has_two)
      for (auto* const numbers : {&at_points, &expected})
        std::erase_if(*numbers, [](const auto& of) { return of.first.first.starts_with("Nodal"); });
    EXPECT_EQ(at_points, expected);
    EXPECT_EQ(read_answer_fields(scene, list).displacement, displacement);
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

// Truth: VTK's own reader of multi-block data sets.
TEST(BlocksContract, AnswersAreBlocksWithTheNamesOfTheirMethods) {
  const Scene scene = block(3, {2, 2, 2}), holed = block_with_holes(3, {4, 3, 2});
  const Displacement small = wave(scene, 1e-4), other = wave(holed, 1e-4);
  TemporaryFolder folder;
  write_blocks({{"limits", write_vtk(scene, {&small}, folder / "a_limits")},
                {"fem_q1", write_vtk(holed, {&other}, folder / "a_fem_q1")}},
               folder / "a.vtm");
  vtkNew<vtkXMLMultiBlockDataReader> reader;
  reader->SetFileName((folder / "a.vtm").c_str());
  reader->Update();
  auto* const blocks = vtkMultiBlockDataSet::SafeDownCast(reader->GetOutput());
  ASSERT_NE(blocks, nullptr);
  ASSERT_EQ(blocks->GetNumberOfBlocks(), 2u);
  const std::array<const char*, 2> names{"limits", "fem_q1"};
  for (unsigned i = 0; i < 2; ++i) {
    EXPECT_STREQ(blocks->GetMetaData(i)->Get(vtkCompositeDataSet::NAME()), names[i]);
    auto* const body = vtkDataSet::SafeDownCast(blocks->GetBlock(i));
    ASSERT_NE(body, nullptr);
    EXPECT_EQ(body->GetNumberOfCells(), (i == 0 ? scene : holed).specimen.n_matter_cells());
    EXPECT_NE(body->GetPointData()->GetArray("Displacement"), nullptr);
  }
}

// Bytes changed at random in files of either kind and compression: a field or a fault, at once.
TEST(AnswerFieldsContract, DamagedFilesAreFaults) {
  const Scene scene = block(3, {6, 4, 4});
  const Displacement displacement = wave(scene, 1e-4);
  Scene holed = scene;
  holed.specimen.material_id.assign(96, 0);
  holed.specimen.material_id[5] = no_material;
  TemporaryFolder folder;
  ExportFields fields{&displacement};
  const fs::path box = write_vtk(scene, fields, folder / "box"),
                 body = write_vtk(holed, fields, folder / "body");
  fields.most_cells = 48;
  write_vtk(holed, fields, folder / "parts");
  std::mt19937 random(2);
  int n_refused = 0;
  const auto damage = [&](const fs::path& file, const fs::path& asked, const Scene& of) {
    const std::string whole = test::text_of(file);
    EXPECT_NO_THROW(read_answer_fields(of, asked));
    for (int i = 0; i < 300; ++i) {
      std::string bytes = whole;
      for (std::uint64_t n = 1 + random() % 20; n > 0; --n)
        bytes[random() % bytes.size()] = static_cast<char>(random());
      std::ofstream(file, std::ios::binary)
          << (i % 5 == 0 ? bytes.substr(0, random() % bytes.size()) : bytes);
      try {
        read_answer_fields(of, asked);
      } catch (const InputError& error) {
        ++n_refused;
        EXPECT_EQ(error.faults().front().file, file.string());
      } catch (const std::runtime_error& error) {
        ++n_refused;
        EXPECT_TRUE(test::has(std::string(error.what()), file.parent_path().string()));
      }
    }
  };
  damage(box, box, scene);
  damage(body, body, holed);
  damage(folder / "parts/0001.vtu", folder / "parts.pvtu", holed);
  EXPECT_GT(n_refused, 100);
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

TEST(WholeFileContract, ReplacesWhatALinkLeadsToAndKeepsTheLink) {
  const test::TemporaryFolder folder;
  folder.write("target", "old");
  fs::create_symlink("target", folder / "link");
  write_whole(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(test::text_of(folder / "target"), "new");
}

TEST(WholeFileContract, WritesIntoAPipeInsteadOfReplacingIt) {
  const test::TemporaryFolder folder;
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  auto reader = std::async(std::launch::async, [&] { return test::text_of(pipe); });
  write_whole(pipe, "through the pipe");
  EXPECT_EQ(reader.get(), "through the pipe");
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(WholeFileContract, RefusesWritersOfFilesWhereAPipeStands) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THROW(write_whole(folder / "pipe", [](const fs::path&) {}), fs::filesystem_error);
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
}

TEST(WholeFileContract, EndsAtLinksThatLeadToThemselves) {
  const test::TemporaryFolder folder;
  fs::create_symlink("loop", folder / "loop");
  EXPECT_THROW(write_whole(folder / "loop", "text"), fs::filesystem_error);
}

TEST(WholeFileContract, PiecesOfOthersInAGuardedFolderStay) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "out/box_limits");
  const FolderLock lock(folder / "out", "box", FolderLock::Sharing::none);
  const fs::path mine = folder.write("out/box_limits/0000.vtu", "mine");
  EXPECT_THROW(write_whole(mine, "new"), FolderTaken);
  EXPECT_EQ(test::text_of(mine), "mine");
  write_whole(folder / "out/box_limits/0001.vtu", "new");
  write_whole(folder / "out/box_limits/0001.vtu", "newer"); // its own
}

TEST(WholeFileContract, AFileThatSpeaksOfMailleIsNotOfMaille) {
  const test::TemporaryFolder folder;
  std::mt19937 dice(41);
  const std::vector<std::string> words{"maille",    "\"maille\": \"1\"", "# maille\n", "Comment = maille\n",
                                       "<VTKFile ", "Name=\"Units\" ",   "NRRD0005\n", "ply\n",
                                       "{\n",       "study,case",        "<svg></svg>"};
  for (const std::string ending : {"vti", "pvd", "csv", "json", "jsonl", "nii", "nii.gz", "nrrd", "mha",
                                   "stl", "ply", "html", "png", "svg", "mp4"})
    for (int i = 0; i < 20; ++i) {
      std::string text = "of ";
      for (int n = 0; n < 40; ++n)
        text += words[dice() % words.size()] + std::string(dice() % 9, ' ');
      EXPECT_FALSE(is_own_result(folder.write("box_limits." + ending, text + "."))) << ending << text;
    }
}

// The shell itself reads the words.
TEST(ProgramIndependent, AShellReadsAWordAsItIs) {
  const test::TemporaryFolder folder;
  for (const std::string text :
       {"", "plain", "two words", "it's", "'", "\"$HOME\" `id` \\ %d", "a\nb", "*;&|<>"}) {
    const auto file = folder / "it's here";
    ASSERT_EQ(std::system(("printf %s " + shell_word(text) + " > " + shell_word(file.string())).c_str()), 0);
    EXPECT_EQ(test::text_of(file), text);
  }
}

TEST(ProgramContract, ProgramsAreFoundByTheirNamesAlone) {
  EXPECT_TRUE(has_program("sh"));
  EXPECT_FALSE(has_program("maille-no-such-program"));
  EXPECT_FALSE(has_program("sh; true"));
}

} // namespace
} // namespace maille::studies
