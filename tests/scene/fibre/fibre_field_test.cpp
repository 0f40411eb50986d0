#include "maille/scene/fibre/fibre_field.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"

#include <Eigen/Eigenvalues>

namespace maille {
namespace {

using std::numbers::pi;

/// The corners of a regular polygon on a circle around the z axis, the first again at the end.
std::vector<Vec3> polygon(int n, double radius) {
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i)
    points.push_back({radius * std::cos(2 * pi * i / n), radius * std::sin(2 * pi * i / n), 0.01});
  points.push_back(points.front());
  return points;
}

/// Angle between two directions without a sign.
double angle(const Vec3& a, const Vec3& b) {
  const Vec3 c{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  return std::atan2(std::hypot(c[0], c[1], c[2]), std::abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]));
}

// Truth: a circle's tangent at the polar angle phi is (-sin phi, cos phi).
TEST(FibreCurveAnalytic, TangentsOfAPolygonOnACircle) {
  constexpr int n = 24;
  const FibreCurve curve(polygon(n, 0.05));
  for (int i = 0; i < 500; ++i) {
    const double phi = 2 * pi * i / 500;
    const double from_middle = std::remainder(phi - pi / n, 2 * pi / n);
    const double on_line = 0.05 * std::cos(pi / n) / std::cos(from_middle);
    const Vec3 tangent{-std::sin(phi), std::cos(phi), 0};
    const auto at = [&](double radius) {
      return curve.direction_at({radius * std::cos(phi), radius * std::sin(phi), 0.02});
    };
    EXPECT_LT(angle(at(on_line), tangent), 1e-12) << phi;
    EXPECT_GT(at(on_line)[1] * std::cos(phi) - at(on_line)[0] * std::sin(phi), 0) << "runs along the line";
    for (const double radius : {0.03, 0.05, 0.08})
      EXPECT_LE(angle(at(radius), tangent), pi / n + 1e-12) << phi;
  }
}

TEST(FibreCurveAnalytic, TwoPointsMakeOneDirectionAndOpenEndsTheirOwn) {
  const std::vector<Vec3> two{{0, 0, 0}, {3, 4, 0}};
  const FibreCurve line(two);
  EXPECT_LT(angle(line.direction_at({-7, 5, 2}), {0.6, 0.8, 0}), 1e-15);
  // A right angle: the pieces' own directions at and beyond the ends, halfway between them at the corner,
  // 22.5 degrees on the way.
  const std::vector<Vec3> three{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  const FibreCurve bent(three);
  EXPECT_LT(angle(bent.direction_at({-1, 0, 0}), {1, 0, 0}), 1e-15);
  EXPECT_LT(angle(bent.direction_at({2, -1, 0}), {1, 1, 0}), 1e-15);
  EXPECT_LT(angle(bent.direction_at({1.5, 3, 0}), {0, 1, 0}), 1e-15);
  // Halfway the blend is of (1, 0) and (1, 1) / sqrt 2, both of length 1: it halves their angle.
  EXPECT_LT(angle(bent.direction_at({0.5, 0, 0}), {std::cos(pi / 8), std::sin(pi / 8), 0}), 1e-15);
}

/// A row of cells with directions in the plane of x and y, at the given angles to x [degrees].
Specimen row(const std::vector<double>& degrees) {
  Specimen body = test::box_scene(3, {int(degrees.size()), 1, 1}).specimen;
  for (const double d : degrees)
    body.fibres.push_back({float(std::cos(d * pi / 180)), float(std::sin(d * pi / 180)), 0});
  return body;
}

double degrees_of(const Specimen& body, std::int64_t cell) {
  const Vec3 f = body.fibre_of(cell);
  return std::remainder(std::atan2(f[1], f[0]) * 180 / pi, 180);
}

constexpr double float_rounding = 1e-4; // degrees; directions are float32

// Truth: the first eigenvector of the mean of two dyads halves the smaller angle between their directions.
TEST(FibreFieldAnalytic, TheMeanHalvesTheAngleAndStopsAtBorders) {
  Specimen body = row({30, -30, 30, -30, 80, 100, 80, 100});
  FibreField field(body, {0, 0, 0, 0, 1, 1, 1, 1}, std::vector<bool>(8, true));
  const double turned = field.smooth(10e-3);
  for (std::int64_t cell = 0; cell < 4; ++cell) {
    EXPECT_NEAR(degrees_of(body, cell), 0, float_rounding);
    EXPECT_NEAR(std::abs(degrees_of(body, cell + 4)), 90, float_rounding);
  }
  EXPECT_NEAR(turned * 180 / pi, (4 * 30 + 4 * 10) / 8.0, float_rounding);
}

TEST(FibreFieldAnalytic, SignsDoNotMatterToTheBit) {
  std::mt19937 random(3);
  Specimen body = test::box_scene(3, {6, 5, 4}, {1e-3, 1e-3, 2e-3}).specimen;
  std::normal_distribution<float> normal;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    body.fibres.push_back({normal(random), normal(random), normal(random)});
  Specimen flipped = body;
  for (auto& f : flipped.fibres)
    if (random() % 2 == 0)
      for (float& c : f)
        c = -c;
  const std::vector<std::int32_t> one(body.fibres.size(), 0);
  const std::vector<bool> known(body.fibres.size(), true);
  FibreField(body, one, known).smooth(2e-3);
  FibreField(flipped, one, known).smooth(2e-3);
  EXPECT_EQ(body.fibres, flipped.fibres);
}

// Truth: of two cells a distance apart the radius reaches one or both; at right angles no direction stands
// out of their mean.
TEST(FibreFieldAnalytic, TheRadiusIsALengthAndWhatDoesNotStandOutStays) {
  Specimen body = row({0, 60});
  body.grid = Grid(3, {2, 1, 1}, {3e-3, 1e-3, 1e-3});
  Specimen near = body;
  FibreField(body, {0, 0}, {true, true}).smooth(2.9e-3);
  EXPECT_NEAR(degrees_of(body, 1), 60, float_rounding);
  FibreField(near, {0, 0}, {true, true}).smooth(3e-3);
  EXPECT_NEAR(degrees_of(near, 0), 30, float_rounding);
  Specimen crossed = row({0, 90});
  FibreField(crossed, {0, 0}, {true, true}).smooth(1e-3);
  EXPECT_NEAR(degrees_of(crossed, 0), 0, float_rounding);
}

TEST(FibreFieldAnalytic, GapsAreFilledLayerByLayerWithinTheirRegion) {
  // Cells 1 and 3 see one known neighbour each, cell 2 both of them a layer later; cells 6 and 7 have
  // neighbours of another region only, cell 6 a region with a direction elsewhere, cell 8.
  Specimen body = row({10, 0, 0, 0, 50, -20, 0, 0, -40, 0});
  FibreField field(body, {0, 0, 0, 0, 0, 1, 2, 3, 2, 4},
                   {true, false, false, false, true, true, false, false, true, false});
  FibreReport report;
  field.fill(report);
  EXPECT_NEAR(degrees_of(body, 1), 10, float_rounding);
  EXPECT_NEAR(degrees_of(body, 2), 30, float_rounding);
  EXPECT_NEAR(degrees_of(body, 3), 50, float_rounding);
  EXPECT_NEAR(degrees_of(body, 6), -40, float_rounding);
  EXPECT_EQ(report.from_neighbours, 3);
  EXPECT_EQ(report.from_label, 1);
  EXPECT_EQ(report.from_body, 2);
  // The mean of 10, 50, -20 and -40 degrees: half the argument of the sum of unit vectors at twice the
  // angles.
  double x = 0, y = 0;
  for (const double d : {10, 50, -20, -40}) {
    x += std::cos(2 * d * pi / 180);
    y += std::sin(2 * d * pi / 180);
  }
  EXPECT_NEAR(degrees_of(body, 7), std::atan2(y, x) / 2 * 180 / pi, float_rounding);
  EXPECT_NEAR(degrees_of(body, 9), degrees_of(body, 7), float_rounding);
}

// Truth: all pieces, one after another, of which the first nearest counts.
TEST(FibreCurveOracle, TheNearestPieceIsFound) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-4, 4);
  for (const int n : {2, 3, 7, 200, 3000}) {
    std::vector<Vec3> points;
    std::vector<Eigen::Vector3d> at, of_piece, of_point;
    for (int i = 0; i < n; ++i) {
      points.push_back({std::round(place(random)), place(random), place(random)});
      at.emplace_back(points.back().data());
      if (i > 0)
        of_piece.push_back((at[at.size() - 1] - at[at.size() - 2]).normalized());
    }
    for (std::size_t i = 0; i < at.size(); ++i)
      of_point.push_back(
          (of_piece[i > 0 ? i - 1 : 0] + of_piece[std::min(i, of_piece.size() - 1)]).normalized());
    const FibreCurve curve(points);
    for (int i = 0; i < 300; ++i) {
      const Eigen::Vector3d x(std::round(2 * place(random)), std::round(place(random)), place(random));
      double nearest = INFINITY;
      Eigen::Vector3d direction = Eigen::Vector3d::Zero();
      for (std::size_t piece = 0; piece + 1 < at.size(); ++piece) {
        const Eigen::Vector3d along = at[piece + 1] - at[piece];
        const double t = std::clamp((x - at[piece]).dot(along) / along.squaredNorm(), 0.0, 1.0);
        if (const double away = (x - at[piece] - t * along).norm(); away < nearest * (1 - 1e-12)) {
          nearest = away;
          direction = (of_point[piece] + t * (of_point[piece + 1] - of_point[piece])).normalized();
        }
      }
      const Vec3 found = curve.direction_at({x[0], x[1], x[2]});
      EXPECT_LT((Eigen::Vector3d(found.data()) - direction).norm(), 1e-9) << n;
    }
  }
}

/// Fibres of a real calf, where MAILLE_DATA says that it is.

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
  return sum / double(pairs) * 180 / std::numbers::pi;
}

double mean_z(const Specimen& body) {
  double sum = 0;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    sum += body.is_matter(cell) ? std::abs(body.fibre_of(cell)[2]) : 0;
  return sum / double(body.n_matter_cells());
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
  const auto n = double(body.n_matter_cells());
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
