/// Fibres of a real calf, where MAILLE_DATA says that it is.

#include "maille/scene/read_scene.hpp"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

namespace maille {
namespace {

Scene soleus(const std::string& smooth) {
  return parse_scene("[specimen]\nshape = \"image\"\nimage = \"$MAILLE_DATA/calf_mri/labels.nii.gz\"\n"
                     "labels = { 17 = \"muscle/soleus\" }\n"
                     "fibre = { tensor_image = \"$MAILLE_DATA/calf_mri/DTI-tensor.nii.gz\"" +
                         smooth + " }\n[[hold]]\nwhere = \"z-\"\n",
                     "soleus.toml");
}

/// Mean angle between directions of cells that share a face [degrees].
double roughness(const Specimen& body) {
  double sum = 0;
  std::int64_t pairs = 0;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    for (std::size_t a = 0; a < 3 && body.is_matter(cell); ++a) {
      Index3 next = body.grid.cell_at(cell);
      ++next[a];
      if (!body.grid.has_cell(next) || !body.is_matter(body.grid.cell(next)))
        continue;
      const Vec3 f = body.fibre_of(cell), g = body.fibre_of(body.grid.cell(next));
      sum += std::acos(std::min(1.0, std::abs(f[0] * g[0] + f[1] * g[1] + f[2] * g[2])));
      ++pairs;
    }
  return sum / static_cast<double>(pairs) * 180 / std::numbers::pi;
}

double mean_z(const Specimen& body) {
  double sum = 0;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    sum += body.is_matter(cell) ? std::abs(body.fibre_of(cell)[2]) : 0;
  return sum / static_cast<double>(body.n_matter_cells());
}

/// First eigenvector of the scatter of the cells' middles.
Eigen::Vector3d long_axis(const Specimen& body) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell)) {
      const Vec3 x = body.position(body.grid.cell_at(cell));
      mean += Eigen::Vector3d(x[0], x[1], x[2]);
      squares += Eigen::Vector3d(x[0], x[1], x[2]) * Eigen::Vector3d(x[0], x[1], x[2]).transpose();
    }
  const auto n = static_cast<double>(body.n_matter_cells());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(squares / n -
                                                              mean / n * (mean / n).transpose());
  return solver.eigenvectors().col(2);
}

// Truth: the data's README: 6,417 voxels of label 17; over all muscles the mean |z| of the fibres is 0.85.
TEST(FibreData, SoleusFibresRunAlongTheMuscleAndSmoothingEvensThemOut) {
  if (std::getenv("MAILLE_DATA") == nullptr)
    GTEST_SKIP() << "MAILLE_DATA is not set: no calf";
  const Specimen raw = soleus("").specimen, smooth = soleus(", smooth = \"6 mm\"").specimen,
                 more = soleus(", smooth = \"12 mm\"").specimen;
  EXPECT_EQ(raw.fibre_report.cells, 6417);
  EXPECT_EQ(raw.fibre_report.without_direction(),
            raw.fibre_report.from_neighbours + raw.fibre_report.from_label + raw.fibre_report.from_body);
  for (std::int64_t cell = 0; cell < raw.grid.n_cells(); ++cell)
    if (raw.is_matter(cell)) {
      const Vec3 f = smooth.fibre_of(cell);
      ASSERT_NEAR(std::hypot(f[0], f[1], f[2]), 1, 1e-6);
    }
  EXPECT_GT(std::abs(long_axis(raw)[2]), 0.95) << "the muscle runs along the leg";
  EXPECT_GT(mean_z(raw), 0.6);
  EXPECT_GT(mean_z(smooth), mean_z(raw)) << "noise turns fibres away from the muscle's axis";
  EXPECT_LT(roughness(smooth), 0.6 * roughness(raw));
  EXPECT_LT(roughness(more), roughness(smooth));
  EXPECT_GT(smooth.fibre_report.smoothing_turn, 0);
}

TEST(FibreData, TwoReadingsAreTheSameToTheBit) {
  if (std::getenv("MAILLE_DATA") == nullptr)
    GTEST_SKIP() << "MAILLE_DATA is not set: no calf";
  EXPECT_EQ(soleus(", smooth = \"6 mm\"").specimen.fibres, soleus(", smooth = \"6 mm\"").specimen.fibres);
}

} // namespace
} // namespace maille
