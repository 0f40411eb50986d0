#include "maille/studies/export/vtk_files.hpp"

#include "maille/studies/export/whole_file.hpp"
#include "studies/export/export_reading.hpp"
#include "studies/export/export_scenes.hpp"
#include "support/full_disk.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <pugixml.hpp>

#include <vtkCompositeDataSet.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkPointData.h>
#include <vtkXMLMultiBlockDataReader.h>

namespace maille::studies {
namespace {
namespace fs = std::filesystem;
using test::block;
using test::block_with_holes;
using test::FullDisk;
using test::read_back;
using test::TemporaryFolder;
using test::text_of;
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

} // namespace
} // namespace maille::studies
