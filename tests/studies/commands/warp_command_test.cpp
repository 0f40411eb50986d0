/// `maille warp`, `run --warp` and `maille new`: files, tables and what is wrong.

#include "studies/commands/run_command.hpp"
#include "support/label_scene.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

class WarpCommandContract : public testing::Test {
protected:
  WarpCommandContract() {
    labels_ = folder_.write("labels.nii", test::nifti_of(test::bent_body())).string();
    scene_ =
        folder_
            .write("scene.toml",
                   "[specimen]\nshape = \"image\"\nimage = \"labels.nii\"\n"
                   "labels = { 17 = \"muscle/soleus\", 5 = \"muscle/vastus_lateralis\" }\nfibre = [1, 0, 0]\n"
                   "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"0.1 mm\", 0, 0]\n")
            .string();
  }
  std::string out(const std::string& name) const { return (folder_.path() / name).string(); }
  const test::TemporaryFolder folder_;
  std::string labels_, scene_;
};

TEST_F(WarpCommandContract, WritesImagesFieldsSurfacesAndATable) {
  const Outcome run =
      maille_command("warp " + scene_ + " --image " + labels_ +
                     " --also mha,nrrd --surface stl,ply,vtp --out " + out("out") + " --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out)["results"][0];
  EXPECT_EQ(result["method"], "coupled");
  EXPECT_EQ(result["voxels_at_rest"], 3 * 2 * 3 + 1);
  EXPECT_EQ(result["folded_cells"], 0);
  ASSERT_EQ(result["labels"].size(), 2U);
  EXPECT_EQ(result["labels"][0]["label"], 5);
  EXPECT_EQ(result["labels"][1]["voxels"], 3 * 3);
  EXPECT_GT(result["labels"][0]["integral_of_det_f_m3"], 0);
  const auto files = result["files"].get<std::vector<std::string>>();
  for (const char* name : {"warped.nii.gz", "warped.mha", "warped.nrrd", "labels_warped.nii.gz",
                           "pull.nii.gz", "pull.mha", "pull.nrrd", "push.nrrd", "jacobian.nii.gz",
                           "labels.csv", "surface_5.stl", "surface_17.stl", "surface.ply", "surface.vtp"}) {
    EXPECT_NE(std::ranges::find(files, name), files.end()) << name;
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "out" / name)) << name;
  }
  const Image field = read_image(folder_.path() / "out" / "pull.nii.gz");
  EXPECT_EQ(field.info.components, 3);
  EXPECT_EQ(field.info.size, (Index3{5, 4, 3}));
}

TEST_F(WarpCommandContract, RunWritesTheSameBesideItsOtherFiles) {
  const Outcome run = maille_command("run " + scene_ + " --warp --out " + out("run"));
  ASSERT_EQ(run.code, 0) << run.err;
  const Outcome warp = maille_command("warp " + scene_ + " --out " + out("warp"));
  ASSERT_EQ(warp.code, 0) << warp.err;
  for (const char* name : {"labels_warped.nii.gz", "pull.nii.gz"})
    EXPECT_EQ(read_image(folder_.path() / "run" / (std::string("scene_coupled_") + name)).values,
              read_image(folder_.path() / "warp" / name).values)
        << name;
  EXPECT_NE(warp.out.find("integral of det F"), std::string::npos);
}

TEST_F(WarpCommandContract, SaysWhatIsWrong) {
  EXPECT_EQ(maille_command("warp " + scene_).code, 2); // no --out
  EXPECT_EQ(maille_command("warp " + scene_ + " --also png --out " + out("a")).code, 2);
  EXPECT_EQ(maille_command("warp " + scene_ + " --image " + out("none.nii") + " --out " + out("a")).code, 2);
  const auto box =
      folder_.write("box.toml", "[specimen]\nshape = \"box\"\ncells = [2, 2, 2]\nspacing = \"1 mm\"\n"
                                "material = \"muscle/soleus\"\n[[hold]]\nwhere = \"x-\"\n");
  const Outcome none = maille_command("warp " + box.string() + " --out " + out("a"));
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.err.find("--image or --labels"), std::string::npos);
}

TEST_F(WarpCommandContract, NewScenesAreReadyToRun) {
  for (const std::string& kind : {std::string("strip"), "image " + labels_}) {
    const std::string file = out(kind.substr(0, 5) + ".toml");
    const Outcome made = maille_command("new " + kind + " --out " + file);
    ASSERT_EQ(made.code, 0) << made.err;
    EXPECT_EQ(maille_command("check " + file).code, 0);
    const Outcome run = maille_command("run " + file);
    EXPECT_EQ(run.code, 0) << run.out << run.err;
    EXPECT_EQ(maille_command("new " + kind + " --out " + file).code, 2) << "it is there";
    EXPECT_EQ(maille_command("new " + kind + " --overwrite --out " + file).code, 0);
  }
  const std::string world = out("press.toml");
  ASSERT_EQ(maille_command("new world --out " + world).code, 0);
  const Outcome played = maille_command("play " + world + " " + out("press_path.toml") + " --json");
  ASSERT_EQ(played.code, 0) << played.err;
  EXPECT_EQ(json::parse(played.out)["frames"].size(), 20U);
  EXPECT_EQ(maille_command("new image").code, 2);
  EXPECT_EQ(maille_command("new strip " + labels_ + " --out " + out("b.toml")).code, 2);
}

TEST_F(WarpCommandContract, SaysWhatHasLeftTheImage) {
  test::LabelArray block = test::bent_body();
  block.size = {14, 14, 12}; // room at its sides, none at its ends
  block.values.assign(14 * 14 * 12, 0);
  for (int k = 0; k < 12; ++k)
    for (int j = 2; j < 12; ++j)
      for (int i = 2; i < 12; ++i)
        block.values[static_cast<std::size_t>(i + 14 * (j + 14 * k))] = 17;
  folder_.write("block.nii", test::nifti_of(block));
  const auto pulled = [&](const char* by) {
    return folder_
        .write(
            "block.toml",
            std::string("[specimen]\nshape = \"image\"\nimage = \"block.nii\"\nlabels = { 17 = "
                        "\"muscle/soleus\" }\nfibre = [0, 0, 1]\n[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = "
                        "\"z+\"\nby = [0, 0, \"") +
                by + "\"]\n")
        .string();
  };
  const Outcome out_of_it = maille_command("warp " + pulled("6 mm") + " --out " + out("a"));
  ASSERT_EQ(out_of_it.code, 0) << out_of_it.err;
  EXPECT_NE(out_of_it.out.find("label 17's volume is not in the warped image"), std::string::npos)
      << out_of_it.out;
  const Outcome within = maille_command("warp " + pulled("-6 mm") + " --out " + out("b"));
  EXPECT_EQ(within.out.find("not in the warped image"), std::string::npos) << within.out;
}

// Two legs, further apart than they are long: pulled along themselves, both of them.
TEST_F(WarpCommandContract, ANewSceneOfPartsThatDoNotTouchHoldsThemAll) {
  test::LabelArray legs = test::bent_body();
  legs.size = {24, 3, 8};
  legs.values.assign(24 * 3 * 8, 0);
  for (int k = 0; k < 8; ++k)
    for (int j = 0; j < 3; ++j)
      for (const int i : {0, 1, 2, 21, 22, 23})
        legs.values[static_cast<std::size_t>(i + 24 * (j + 3 * k))] = i < 3 ? 3 : 4;
  const std::string file = out("legs.toml");
  const std::string image = folder_.write("legs.nii", test::nifti_of(legs)).string();
  ASSERT_EQ(maille_command("new image " + image + " --out " + file).code, 0);
  const Scene scene = read_scene(file);
  EXPECT_EQ(scene.specimen.n_matter_cells(), 2 * 3 * 3 * 8);
  EXPECT_TRUE(scene.left_out.empty());
  EXPECT_EQ(scene.prescribed.size(), std::size_t{3 * 2 * 2 * 4 * 4}) << "both ends of both legs";
}

} // namespace
} // namespace maille
