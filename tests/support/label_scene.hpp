#pragma once
/// The same scene of a label array from a file and from a builder.

#include "maille/scene/read_scene.hpp"
#include "maille/scene/scene_builder.hpp"
#include "scene/image/image_writers.hpp"
#include "support/oriented_labels.hpp"

namespace maille::test {

/// A NIfTI-1 file of bytes with the array's affine in metres.
inline std::string nifti_of(const LabelArray& array) {
  image_tests::NiftiFile file;
  file.dim = {3, array.size[0], array.size[1], array.size[2]};
  file.units = 1;
  file.sform = 1;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column)
      file.srow[4 * row + column] = array.affine[row][column];
  for (const int value : array.values)
    file.data += static_cast<char>(value);
  return file.bytes();
}

inline constexpr const char* label_scene_text = R"(units = "m"
[specimen]
shape = "image"
image = "labels.nii"
labels = { 17 = "muscle/soleus", 5 = { youngs_modulus = "30 kPa", poisson_ratio = 0.4, name = "firm" } }
fibre = [0, 3, 4]
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = [0.0001, 0, 0.0002]
axes = "xz"
)";

inline Scene label_scene_by_file(const image_tests::TemporaryFolder& folder, const LabelArray& array) {
  folder.write("labels.nii", nifti_of(array));
  return read_scene(folder.write("scene.toml", label_scene_text));
}

/// The scene without its labels.
inline SceneBuilder label_scene() {
  Material firm;
  firm.name = "firm";
  firm.elasticity = ElasticConstants::isotropic(30e3, 0.4);
  return SceneBuilder()
      .material(17, "muscle/soleus")
      .material(5, firm)
      .fibre({0, 3, 4})
      .hold("x-")
      .move("x+", {1e-4, 0, 2e-4}, "xz");
}

} // namespace maille::test
