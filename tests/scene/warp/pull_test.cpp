/// Where voxels of a deformed image come from.
#include "maille/scene/warp/warp.hpp"

#include "scene/warp/warp_bodies.hpp"
#include "support/oriented_labels.hpp"

#include <gtest/gtest.h>

#include <set>

namespace maille {
namespace {

using test::ImagedBody;

/// The trilinear map of a cell from its corners, by their weights.
Vec3 mapped(const ImagedBody& body, const Index3& cell, const Vec3& xi) {
  const Specimen& specimen = body.scene.specimen;
  Vec3 x{};
  for (int c = 0; c < 8; ++c) {
    const Index3 node{cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2 & 1)};
    const double weight =
        (c & 1 ? xi[0] : 1 - xi[0]) * (c & 2 ? xi[1] : 1 - xi[1]) * (c & 4 ? xi[2] : 1 - xi[2]);
    const Vec3 rest = specimen.position(node), u = body.u.at(specimen.grid.node(node));
    for (std::size_t a = 0; a < 3; ++a)
      x[a] += weight * (rest[a] + u[a]);
  }
  return x;
}

/// The obvious inversion: a box of the cell is halved along every axis as long as the box around its mapped
/// corners, which holds what is mapped from within, has the place in it.
void search(const ImagedBody& body, const Index3& cell, const Vec3& x, const Vec3& low, double width,
            std::vector<Vec3>& found) {
  Vec3 least{1e9, 1e9, 1e9}, most{-1e9, -1e9, -1e9};
  for (int c = 0; c < 8; ++c) {
    const Vec3 corner =
        mapped(body, cell,
               {low[0] + (c & 1 ? width : 0), low[1] + (c & 2 ? width : 0), low[2] + (c & 4 ? width : 0)});
    for (std::size_t a = 0; a < 3; ++a) {
      least[a] = std::min(least[a], corner[a]);
      most[a] = std::max(most[a], corner[a]);
    }
  }
  for (std::size_t a = 0; a < 3; ++a)
    if (x[a] < least[a] - 1e-12 || x[a] > most[a] + 1e-12)
      return;
  if (width < 1e-6) {
    found.push_back(low);
    return;
  }
  for (int c = 0; c < 8; ++c)
    search(body, cell, x,
           {low[0] + (c & 1 ? width / 2 : 0), low[1] + (c & 2 ? width / 2 : 0),
            low[2] + (c & 4 ? width / 2 : 0)},
           width / 2, found);
}

/// All places at rest [m] of what is at x now.
std::vector<Vec3> origins(const ImagedBody& body, const Vec3& x) {
  const Specimen& specimen = body.scene.specimen;
  std::vector<Vec3> places;
  for (std::int64_t cell = 0; cell < specimen.grid.n_cells(); ++cell) {
    if (!specimen.is_matter(cell))
      continue;
    std::vector<Vec3> found;
    search(body, specimen.grid.cell_at(cell), x, {0, 0, 0}, 1, found);
    const Vec3 first = specimen.position(specimen.grid.cell_at(cell));
    for (const Vec3& xi : found) {
      Vec3 place{};
      for (std::size_t a = 0; a < 3; ++a)
        place[a] = first[a] + xi[a] * specimen.grid.spacing()[a];
      places.push_back(place);
    }
  }
  return places;
}

int bent(int i, int j, int k) {
  if (i < 2 || i > 6 || j < 2 || j > 4 || k < 1 || k > 4 || (i > 4 && k > 2))
    return 0;
  return j < 3 ? 3 : 8;
}

/// Truth: the search above, which knows neither Newton's steps nor an order of cells.
TEST(PullOracle, IsWhatASearchThroughHalvedBoxesFinds) {
  for (const double part :
       {0.05, 0.2, 0.3}) { // of 0.3 some cells are far from parallelepipeds, none is folded
    ImagedBody body = test::imaged_body(test::oblique_grid({10, 7, 7}, {2e-3, 3e-3, 4e-3}), bent);
    test::displace(body, [](const Vec3& x) {
      return Vec3{0.1 * x[0] + 0.2 * x[1], 0.003 - 0.1 * x[2], 0.2 * x[0]};
    });
    test::shake(body, part, 7);
    const Pull pull = pull_of(body.labels.info, body.bodies());
    ASSERT_EQ(pull.folded_cells, 0);
    EXPECT_EQ(pull.reached_twice, 0);
    const auto n = static_cast<std::size_t>(pull.grid.n_voxels());
    std::size_t voxel = 0;
    std::int64_t n_reached = 0;
    for (int k = 0; k < pull.grid.size[2]; ++k)
      for (int j = 0; j < pull.grid.size[1]; ++j)
        for (int i = 0; i < pull.grid.size[0]; ++i, ++voxel) {
          const Vec3 at{double(i), double(j), double(k)};
          const auto places = origins(body, test::place_of(body, at));
          ASSERT_EQ(places.empty(), pull.source[voxel] == Pull::nothing) << part << " at " << i << j << k;
          if (places.empty())
            continue;
          ++n_reached;
          const Vec3 rest = test::index_of(body, places.front());
          for (std::size_t a = 0; a < 3; ++a)
            EXPECT_NEAR(pull.shift[a * n + voxel], rest[a] - at[a], 2e-5);
        }
    EXPECT_EQ(pull.reached, n_reached);
    EXPECT_GT(n_reached, 30);
  }
}

/// Truth: the map itself. What pull says goes back through it.
TEST(PullAnalytic, GoesBackToTheVoxelToAMillionth) {
  ImagedBody body =
      test::imaged_body(test::oblique_grid({14, 12, 12}, {2e-3, 3e-3, 4e-3}), [](int i, int j, int k) {
        return i > 1 && i < 11 && j > 1 && j < 10 && k > 2 && k < 9 ? 1 : 0;
      });
  test::displace(body, [](const Vec3& x) {
    return Vec3{3e-3 * std::sin(300 * x[1]), 4e-3 * std::sin(200 * x[2]) + 1e-3, 5e-3 * std::sin(150 * x[0])};
  });
  const Pull pull = pull_of(body.labels.info, body.bodies());
  const Specimen& specimen = body.scene.specimen;
  const auto n = static_cast<std::size_t>(pull.grid.n_voxels());
  std::size_t voxel = 0;
  double worst = 0;
  for (int k = 0; k < 12; ++k)
    for (int j = 0; j < 12; ++j)
      for (int i = 0; i < 14; ++i, ++voxel) {
        if (pull.source[voxel] == Pull::nothing)
          continue;
        const Vec3 rest =
            test::place_of(body, {i + double{pull.shift[voxel]}, j + double{pull.shift[n + voxel]},
                                  k + double{pull.shift[2 * n + voxel]}});
        Index3 cell{};
        Vec3 xi{};
        for (std::size_t a = 0; a < 3; ++a) {
          const double s = (rest[a] - specimen.origin[a]) / specimen.grid.spacing()[a];
          cell[a] = std::clamp(static_cast<int>(std::floor(s)), 0, specimen.grid.cells()[a] - 1);
          xi[a] = s - cell[a];
        }
        const Vec3 back = test::index_of(body, mapped(body, cell, xi));
        for (std::size_t a = 0; a < 3; ++a)
          worst = std::max(worst, std::abs(back[a] - std::array{double(i), double(j), double(k)}[a]));
      }
  EXPECT_GT(pull.reached, 400);
  EXPECT_LT(worst, 5e-6); // float32 of a shift of some voxels, stretched by the map
}

/// Truth: bodies that move by whole voxels, on grids of every orientation, are their arrays moved.
TEST(PullAnalytic, AMoveByWholeVoxelsMovesTheArray) {
  for (const test::Orientation& orientation : test::all_orientations()) {
    const test::LabelArray array = test::turned(test::bent_body(), orientation);
    ImageInfo grid;
    grid.size = array.size;
    grid.world = WorldAxes::ras;
    for (std::size_t a = 0; a < 3; ++a) {
      grid.spacing[a] = std::hypot(array.affine[0][a], array.affine[1][a], array.affine[2][a]);
      grid.origin[a] = array.affine[a][3];
      for (std::size_t r = 0; r < 3; ++r)
        grid.direction[r][a] = array.affine[r][a] / grid.spacing[a];
    }
    ImagedBody body = test::imaged_body(grid, [&](int i, int j, int k) { return array.at({i, j, k}); });
    const Index3 by{1, -1, 1};
    for (std::int64_t node = 0; node < body.scene.specimen.grid.n_nodes(); ++node)
      for (int a = 0; a < 3; ++a)
        body.u(a, node) = by[static_cast<std::size_t>(a)] * grid.spacing[static_cast<std::size_t>(a)];
    const Pull pull = pull_of(grid, body.bodies());
    const Image after = warped_labels(pull, body.labels, -7);
    std::size_t voxel = 0;
    for (int k = 0; k < grid.size[2]; ++k)
      for (int j = 0; j < grid.size[1]; ++j)
        for (int i = 0; i < grid.size[0]; ++i, ++voxel) {
          const Index3 from{i - by[0], j - by[1], k - by[2]};
          bool is_inside = true;
          for (std::size_t a = 0; a < 3; ++a)
            is_inside = is_inside && from[a] >= 0 && from[a] < grid.size[a];
          const int label = is_inside ? array.at(from) : 0;
          EXPECT_EQ(after.values[voxel], label == 0 ? -7 : label);
        }
  }
}

TEST(PullAnalytic, ABodyAtRestPullsEveryVoxelFromItself) {
  ImagedBody body = test::imaged_body(test::oblique_grid({10, 7, 7}, {2e-3, 3e-3, 4e-3}), bent);
  const Pull pull = pull_of(body.labels.info, body.bodies());
  EXPECT_EQ(pull.reached, pull.at_rest);
  EXPECT_EQ(pull.vacated, 0);
  for (std::size_t voxel = 0; voxel < pull.source.size(); ++voxel)
    EXPECT_EQ(pull.source[voxel],
              body.labels.values[voxel] != 0 ? static_cast<std::int32_t>(voxel) : Pull::nothing);
  EXPECT_EQ(warped_labels(pull, body.labels).values, body.labels.values);
}

/// Truth: counted by hand. The last layer of cells goes through the one before it and past it.
TEST(PullAnalytic, FoldedCellsAreCountedAndLeaveTheirVoxelsToOthers) {
  ImagedBody body = test::imaged_body(test::grid_of({8, 3, 3}, {1e-3, 1e-3, 1e-3}),
                                      [](int i, int, int) { return i < 4 ? 1 : 0; });
  const Grid& grid = body.scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (grid.node_at(node)[0] == 4)
      body.u(0, node) = -1.5e-3; // the face at 4 goes to 2.5: the last cells reach from 3 back to 2.5
  const Pull pull = pull_of(body.labels.info, body.bodies());
  EXPECT_EQ(pull.folded_cells, 9);
  EXPECT_EQ(pull.reached, 27); // middles 0.5, 1.5 and 2.5
  EXPECT_EQ(pull.vacated, 9);
  for (std::size_t voxel = 0; voxel < pull.source.size();
       ++voxel) // the one at 2.5 stays with the cell at rest
    EXPECT_EQ(pull.source[voxel], voxel % 8 < 3 ? static_cast<std::int32_t>(voxel) : Pull::nothing);
}

/// Truth: supersampled. Two bars that touch slide along each other by parts of a voxel, turned against the
/// grid.
TEST(PullOracle, BodiesThatSlideAlongEachOtherDoNotBleed) {
  const ImageInfo grid = test::grid_of({24, 24, 12}, {1e-3, 1e-3, 1e-3});
  const auto bar = [&](int label, int from, int to) {
    return test::imaged_body(grid, [=](int i, int j, int k) {
      return i >= 6 && i < 18 && j >= from && j < to && k >= 2 && k < 10 ? label : 0;
    });
  };
  ImagedBody lower = bar(1, 6, 12), upper = bar(2, 12, 18);
  const double c = std::cos(0.2), s = std::sin(0.2), middle = 12e-3;
  // Slides along x by -2.3 and 3.4 voxels, and both turn about the middle.
  const auto moved = [&](double slide, const Vec3& x) {
    const double dx = x[0] + slide - middle, dy = x[1] - middle;
    return Vec3{middle + c * dx - s * dy, middle + s * dx + c * dy, x[2]};
  };
  for (auto [body, slide] : {std::pair(&lower, -2.3e-3), std::pair(&upper, 3.4e-3)})
    test::displace(*body, [&, slide = slide](const Vec3& x) {
      const Vec3 to = moved(slide, x);
      return Vec3{to[0] - x[0], to[1] - x[1], 0};
    });
  const std::vector<DeformedBody> bodies{lower.bodies()[0], upper.bodies()[0]};
  const Pull pull = pull_of(grid, bodies);
  EXPECT_EQ(pull.reached_twice, 0);
  Image both = lower.labels;
  for (std::size_t i = 0; i < both.values.size(); ++i)
    both.values[i] += upper.labels.values[i];
  const Image after = warped_labels(pull, both);
  // By the closed form: what is at a place came from the turn undone and the slide taken back.
  const auto label_at = [&](double x, double y, double z) {
    const double dx = x - middle, dy = y - middle;
    const double rx = middle + c * dx + s * dy, ry = middle - s * dx + c * dy;
    const bool is_deep = z >= 2e-3 && z < 10e-3;
    if (is_deep && ry >= 6e-3 && ry < 12e-3 && rx + 2.3e-3 >= 6e-3 && rx + 2.3e-3 < 18e-3)
      return 1;
    return is_deep && ry >= 12e-3 && ry < 18e-3 && rx - 3.4e-3 >= 6e-3 && rx - 3.4e-3 < 18e-3 ? 2 : 0;
  };
  for (const int label : {1, 2}) {
    double both_have = 0, truth = 0, ours = 0;
    std::size_t voxel = 0;
    for (int k = 0; k < 12; ++k)
      for (int j = 0; j < 24; ++j)
        for (int i = 0; i < 24; ++i, ++voxel) {
          int inside = 0;
          for (int q = 0; q < 8; ++q)
            for (int p = 0; p < 8; ++p)
              inside +=
                  label_at((i + (p + 0.5) / 8) * 1e-3, (j + (q + 0.5) / 8) * 1e-3, (k + 0.5) * 1e-3) == label;
          const bool is_ours = after.values[voxel] == static_cast<float>(label);
          // A voxel belongs to the label that has its middle; where that is within 1/8 of the border, to
          // either.
          const bool is_true = label_at((i + 0.5) * 1e-3, (j + 0.5) * 1e-3, (k + 0.5) * 1e-3) == label;
          if (inside == 0) {
            EXPECT_FALSE(is_ours) << "label " << label << " bleeds to " << i << ' ' << j << ' ' << k;
          } else if (inside == 64) {
            EXPECT_TRUE(is_ours) << "label " << label << " misses " << i << ' ' << j << ' ' << k;
          }
          truth += is_true;
          ours += is_ours;
          both_have += is_ours && is_true;
        }
    EXPECT_GE(2 * both_have / (truth + ours), 0.99);
    EXPECT_GT(truth, 500);
  }
}

TEST(PullContract, RefusesWhatItCannotTake) {
  ImagedBody body =
      test::imaged_body(test::grid_of({4, 3, 3}, {1e-3, 1e-3, 1e-3}), [](int, int, int) { return 1; });
  const Displacement other(3, 5);
  const std::vector<DeformedBody> wrong{{&body.scene.specimen, &other}};
  EXPECT_THROW(pull_of(body.labels.info, wrong), std::invalid_argument);
  const Pull pull = pull_of(body.labels.info, body.bodies());
  Image small;
  small.info.size = {2, 2, 2};
  small.values.assign(8, 1);
  EXPECT_THROW(warped(pull, small), std::invalid_argument);
}

} // namespace
} // namespace maille
