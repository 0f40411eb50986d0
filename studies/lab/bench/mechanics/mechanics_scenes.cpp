#include "bench/mechanics/mechanics_scenes.hpp"

#include "maille/scene/read_scene.hpp"
#include "maille/scene/scene_builder.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace maille::lab {

namespace {

namespace fs = std::filesystem;

bool has_calf() {
  return has_data("calf_mri/labels.nii.gz") && has_data("calf_mri/DTI-tensor.nii.gz");
}

/// The strip of strip_pulled.toml.
Scene strip(const BenchOptions& options) {
  if (!options.quick)
    return read_scene(fs::path(MAILLE_SCENES) / "strip_pulled.toml");
  return parse_scene(
      "[specimen]\nshape = \"box\"\ncells = [8, 4, 4]\nspacing = \"2 mm\"\n"
      "material = \"muscle/vastus_lateralis\"\n[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\n"
      "by = [\"2 mm\", 0, 0]\n");
}

Scene isotropic(Scene scene, double poisson_ratio) {
  scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, poisson_ratio);
  return scene;
}

/// Without limits, which finite elements do not know.
Scene elastic(Scene scene) {
  scene.limits = {};
  return scene;
}

/// The body of muscle_belly.toml on cells of 4 mm in place of 2.
Scene coarse_belly() {
  return parse_scene(
      "[specimen]\nshape = \"muscle\"\ncells = [30, 9, 9]\nspacing = \"4 mm\"\n"
      "material = \"muscle/vastus_lateralis\"\nfibre = { angle = \"20 deg\", plane = \"xz\" }\n"
      "tendon = { material = \"tendon/tibialis_anterior\", fraction = 0.15 }\n"
      "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"4.8 mm\", 0, 0]\n");
}

/// The body of calf_soleus_dti.toml, blocks of 2 x 2 x 2 voxels merged.
Scene coarse_calf() {
  return parse_scene(
      "[specimen]\nshape = \"image\"\nimage = \"$MAILLE_DATA/calf_mri/labels.nii.gz\"\ncoarsen = 2\n"
      "labels = { 17 = \"muscle/soleus\" }\n"
      "fibre = { tensor_image = \"$MAILLE_DATA/calf_mri/DTI-tensor.nii.gz\", smooth = \"6 mm\" }\n"
      "[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = \"z+\"\nby = [0, 0, \"7.5 mm\"]\n");
}

} // namespace

Scene two_tissue_block(int cells_across) {
  const Index3 size{2 * cells_across, cells_across, cells_across};
  std::vector<std::uint8_t> labels;
  for (int cell = 0; cell < size[0] * size[1] * size[2]; ++cell)
    labels.push_back(cell < size[0] * size[1] * size[2] / 2 ? 1 : 2);
  const double spacing = 8e-3 / cells_across;
  Material soft;
  soft.name = "soft, nearly incompressible";
  soft.elasticity = ElasticConstants::isotropic(3e3, 0.45);
  SceneBuilder builder("two_tissue_block");
  builder.labels(labels, ArrayLayout::x_fastest(size), affine_of({spacing, spacing, spacing}))
      .material(1, "muscle/vastus_lateralis")
      .material(2, soft)
      .hold("x-")
      .move("x+", {1e-3, 0, 0});
  return builder.build();
}

std::optional<Scene> both_legs() {
  return has_calf() ? std::optional(read_scene(fs::path(MAILLE_SCENES) / "calf_both_legs.toml"))
                    : std::nullopt;
}

std::vector<MechanicsScene> mechanics_scenes(const BenchOptions& options, BenchReport& report) {
  const Scene pulled = strip(options);
  std::vector<MechanicsScene> scenes{{"strip_pulled", pulled},
                                     {"strip, isotropic, nu 0.45", isotropic(pulled, 0.45)},
                                     {"strip, isotropic, nu 0.49", isotropic(pulled, 0.49)},
                                     {"block of two tissues", two_tissue_block(options.quick ? 4 : 8)}};
  if (options.quick)
    return scenes;
  scenes.push_back({"muscle_belly", elastic(read_scene(fs::path(MAILLE_SCENES) / "muscle_belly.toml")),
                    ReferenceLattices::same});
  scenes.push_back({"muscle_belly, cells of 4 mm", coarse_belly(), ReferenceLattices::finer});
  report.notes.emplace_back(
      "Stress of the belly is measured on cells of 4 mm, not 2: quadratic elements on a finer lattice of the "
      "body itself have 1.7 million unknowns.");
  if (has_calf()) {
    scenes.push_back({"calf_soleus_dti",
                      elastic(read_scene(fs::path(MAILLE_SCENES) / "calf_soleus_dti.toml")),
                      ReferenceLattices::same});
    scenes.push_back({"calf_soleus_dti, 2 x 2 x 2 voxels merged", coarse_calf(), ReferenceLattices::finer});
    report.notes.emplace_back(
        "Stress of the calf is measured with blocks of 2 x 2 x 2 voxels merged, for the same reason.");
  } else {
    report.notes.emplace_back("Left out: calf_soleus_dti and both legs. MAILLE_DATA names no folder with "
                              "calf_mri/labels.nii.gz and calf_mri/DTI-tensor.nii.gz.");
  }
  return scenes;
}

} // namespace maille::lab
