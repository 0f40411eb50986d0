/// Measures of oriented images: the same in the world whichever way the image is stored.
#include "maille/scene/measure/measure.hpp"

#include "support/label_scene.hpp"

#include <Eigen/Dense>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace maille {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d vec(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

Matrix3d gradient_in_world() {
  Matrix3d m;
  m << 0.02, -0.01, 0.03, 0.04, -0.03, 0.005, 0.01, 0.02, 0.015;
  return m;
}

std::string in_toml(const Vector3d& v) {
  return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

// Truth: the field as it is in the world does not depend on how an image is stored; places are taken into
// the image's own coordinates here, by its affine.
TEST(MeasureIndependent, OrientedImagesAnswerAlikeInTheWorld) {
  const test::LabelArray body = test::bent_body();
  const auto affine_of_array = [](const test::LabelArray& array) {
    Matrix3d axes;
    Vector3d origin;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        axes(r, c) = array.affine[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
      origin(r) = array.affine[static_cast<std::size_t>(r)][3];
    }
    return std::pair{axes, origin};
  };
  // The middle of voxel (2, 1, 1), a bit off, in the world.
  const auto [axes, origin] = affine_of_array(body);
  const Vector3d point = axes * Vector3d(2.1, 0.8, 1.2) + origin, normal = Vector3d(1, 2, -1).normalized();
  const Vector3d force(0.3, -0.2, 0.5);
  std::vector<std::vector<MeasuredValue>> answers;
  for (const test::Orientation& orientation : test::all_orientations()) {
    const test::LabelArray array = test::turned(body, orientation);
    const auto [to, from] = affine_of_array(array);
    const Vector3d index = to.inverse() * (point - from), size = to.colwise().norm();
    const Vector3d place = (index.array() + 0.5) * size.array();
    const Vector3d across = (to * size.cwiseInverse().asDiagonal()).transpose() * normal;
    image_tests::TemporaryFolder folder;
    folder.write("labels.nii", test::nifti_of(array));
    const std::string where = fmt::format("[{}, {}, {}]", place.x(), place.y(), place.z());
    const std::string text = fmt::format(
        "units = \"m\"\n[specimen]\nshape = \"image\"\nimage = \"labels.nii\"\nlabels = {{ 17 = "
        "\"muscle/soleus\", 5 = {{ youngs_modulus = \"30 kPa\", poisson_ratio = 0.4 }} }}\nfibre = [1, 0, "
        "0]\n"
        "[[hold]]\nwhere = {{ box = [[-1, -1, -1], [1, 1, 1]] }}\n"
        "[[measure]]\nname = \"at\"\ndisplacement = {{ at = {0} }}\n"
        "[[measure]]\nname = \"mean\"\ndisplacement = {{ mean = {{ label = 17 }} }}\n"
        "[[measure]]\nname = \"xx\"\nstrain = {{ mean = {{ label = 17 }} }}\nkind = \"xx\"\n"
        "[[measure]]\nname = \"yz\"\nstrain = {{ at = {0} }}\nkind = \"yz\"\n"
        "[[measure]]\nname = \"volume_17\"\nvolume = {{ label = 17 }}\n"
        "[[measure]]\nname = \"held\"\nforce = \"hold[1]\"\n"
        "[[measure]]\nname = \"cut\"\nforce = {{ section = {{ point = {0}, normal = [{1}, {2}, {3}] }} }}\n"
        "[[measure]]\nname = \"through\"\nforce = {{ section = {{ point = {0}, normal = [{1}, {2}, {3}] }} "
        "}}\ncomponent = \"normal\"\n"
        "[[measure]]\nname = \"at_world\"\ndisplacement = {{ at = {4} }}\nframe = \"world\"\n"
        "[[measure]]\nname = \"at_lps\"\ndisplacement = {{ at = {5} }}\ncomponent = \"x\"\nframe = \"lps\"\n"
        "[[measure]]\nname = \"cut_ras\"\nforce = {{ section = {{ point = {4}, normal = {6} }} }}\n"
        "component = \"normal\"\nframe = \"ras\"\n"
        "[[measure]]\nname = \"near\"\nvolume = {{ sphere = {{ centre = {4}, radius = {7} }} }}\nframe = "
        "\"world\"\n"
        "[[measure]]\nname = \"boxed\"\nvolume = {{ where = {{ sphere = {{ centre = {4}, radius = {7} }} }} "
        "}}\n"
        "frame = \"world\"\n",
        where, across.x(), across.y(), across.z(), in_toml(point),
        in_toml({-point.x(), -point.y(), point.z()}), in_toml(normal), 2.2 * size.maxCoeff());
    const SceneAndMeasures read = read_scene_and_measures(folder.write("scene.toml", text));
    const Specimen& specimen = read.scene.specimen;
    Matrix3d direction;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        direction(r, c) =
            specimen.placement.direction[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
    Answer answer;
    answer.method = "coupled";
    answer.displacement = Displacement(specimen.grid);
    for (std::int64_t node = 0; node < specimen.grid.n_nodes(); ++node) {
      const Vector3d x =
          vec(specimen.placement.origin) + direction * vec(specimen.position(specimen.grid.node_at(node)));
      const Vector3d u = direction.transpose() * (gradient_in_world() * x);
      for (int b = 0; b < 3; ++b)
        answer.displacement(b, node) = u(b);
    }
    for (const Prescribed& p : read.scene.prescribed)
      answer.reaction.push_back((direction.transpose() * force)(p.component));
    answers.push_back(measured(read.scene, read.measures, answer));
  }
  const Matrix3d E = (gradient_in_world() + gradient_in_world().transpose()) / 2;
  constexpr double tolerance = 1e-6; // places of images are those of float32
  for (const auto& values : answers) {
    EXPECT_LT((vec(*values[0].vector) - gradient_in_world() * point).norm(), tolerance * point.norm());
    EXPECT_LT((vec(*values[1].vector) - vec(*answers[0][1].vector)).norm(), tolerance * point.norm());
    EXPECT_NEAR(*values[2].value, E(0, 0), tolerance);
    EXPECT_NEAR(*values[3].value, E(1, 2), tolerance);
    EXPECT_NEAR(*values[4].value / *answers[0][4].value, 1, tolerance);
    const double n_nodes = *answers[0][5].value / force.norm();
    EXPECT_NEAR(n_nodes, std::round(n_nodes), 1e-6);
    EXPECT_LT((vec(*values[5].vector) - std::round(n_nodes) * force).norm(), tolerance * n_nodes);
    EXPECT_LT((vec(*values[6].vector) - vec(*answers[0][6].vector)).norm(), tolerance * n_nodes);
    EXPECT_GT(*values[6].value, 0.0);
    EXPECT_LT(*values[6].value, *values[5].value);
    EXPECT_NEAR(*values[7].value, normal.dot(vec(*values[6].vector)), tolerance * n_nodes);
    // The same places as a viewer shows them: one text for all ways of storing.
    EXPECT_LT((vec(*values[8].vector) - gradient_in_world() * point).norm(), tolerance * point.norm());
    EXPECT_NEAR(*values[9].value, -(gradient_in_world() * point).x(), tolerance * point.norm());
    EXPECT_NEAR(*values[10].value, *values[7].value, tolerance * n_nodes);
    EXPECT_GT(*values[11].value, 0);
    EXPECT_NEAR(*values[11].value / *answers[0][11].value, 1, tolerance);
    EXPECT_GT(*values[12].value, 0);
    EXPECT_NEAR(*values[12].value / *answers[0][12].value, 1, tolerance);
  }
}

} // namespace
} // namespace maille
