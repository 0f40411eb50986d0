/// Where voxels of a deformed image come from.

#include "conditions/voxelise.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/warp/warp.hpp"
#include "scene/warp/warp_bodies.hpp"
#include "support/kit.hpp"
#include "support/oriented_labels.hpp"

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
    const auto n = std::size_t(pull.grid.n_voxels());
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
  const auto n = std::size_t(pull.grid.n_voxels());
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
          cell[a] = std::clamp(int(std::floor(s)), 0, specimen.grid.cells()[a] - 1);
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
        body.u(a, node) = by[std::size_t(a)] * grid.spacing[std::size_t(a)];
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
          const bool is_ours = after.values[voxel] == float(label);
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

/// Surfaces of deformed bodies, out as files and in as bodies.

/// By the divergence theorem, over the quads' two triangles from their first corner.
double volume_of(const BodySurface& surface) {
  double sum = 0;
  const auto triple = [](const Vec3& a, const Vec3& b, const Vec3& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
  };
  for (const auto& quad : surface.quads)
    for (std::size_t i = 1; i < 3; ++i)
      sum += triple(surface.points[std::size_t(quad[0])], surface.points[std::size_t(quad[i])],
                    surface.points[std::size_t(quad[i + 1])]) /
             6;
  return sum;
}

/// Truth: the volume of a body that is stretched evenly; its surface is closed and turns outside, however its
/// grid stands in the world.
TEST(SurfaceAnalytic, HoldsTheVolumeOfAStretchedBody) {
  for (const bool is_left_handed : {false, true}) {
    const ImageInfo grid = is_left_handed ? test::oblique_grid({8, 7, 6}, {2e-3, 3e-3, 4e-3})
                                          : test::grid_of({8, 7, 6}, {2e-3, 3e-3, 4e-3});
    ImagedBody body = test::imaged_body(grid, [](int i, int j, int k) {
      return i > 0 && i < 6 && j > 0 && j < 5 && k > 0 && k < 5 && !(i > 3 && k > 2) ? 1 : 0;
    });
    test::displace(body, [](const Vec3& x) { return Vec3{0.5 * x[0], 0.1 * x[0], -0.25 * x[2]}; });
    const auto surfaces = surfaces_of(body.bodies()[0], body.scene.materials);
    ASSERT_EQ(surfaces.size(), 1U);
    const double cells = 5 * 4 * 4 - 2 * 4 * 2;
    EXPECT_NEAR(volume_of(surfaces[0]), 1.5 * 0.75 * cells * 24e-9, 1e-15);
    EXPECT_EQ(surfaces[0].name, "muscle/soleus");
  }
}

/// Truth: what is written out comes in again as the same voxels, through each of the files that are read.
TEST(SurfaceContract, WhatIsWrittenAsStlIsReadAsABodyOfTheSameVoxels) {
  ImagedBody body = test::imaged_body(test::grid_of({8, 7, 6}, {2e-3, 2e-3, 2e-3}), [](int i, int j, int k) {
    return i > 0 && i < 6 && j > 0 && j < 5 && k > 0 && k < 5 && !(i > 3 && k > 2) ? 1 : 0;
  });
  const test::TemporaryFolder folder;
  const auto surfaces = surfaces_of(body.bodies()[0], body.scene.materials);
  write_surfaces(surfaces, folder.path() / "body.stl", LengthUnit::millimetre);
  const std::string scene = "[specimen]\nshape = \"surface\"\nsurface = \"body.stl\"\nspacing = \"2 mm\"\n"
                            "material = \"fat/subcutaneous\"\n[[hold]]\nwhere = \"z-\"\n";
  const Scene read = parse_scene(scene, folder.path() / "scene.toml");
  EXPECT_EQ(read.specimen.grid.cells(), body.scene.specimen.grid.cells());
  EXPECT_EQ(read.specimen.material_id, body.scene.specimen.material_id);
  const Vec3 here = point_in_world(read.specimen.placement, read.specimen.origin);
  const Vec3 there = point_in_world(body.scene.specimen.placement, body.scene.specimen.origin);
  for (std::size_t a = 0; a < 3; ++a)
    EXPECT_NEAR(here[a], there[a], 1e-8);
}

// Truth: a surface of its own label that `labels` leaves out is no matter, which a warning says.
TEST(SurfaceContract, ASurfaceWithoutAMaterialIsNamed) {
  const auto write = [](const test::TemporaryFolder& folder, const char* name, int first) {
    ImagedBody body = test::imaged_body(test::grid_of({12, 4, 4}, {2e-3, 2e-3, 2e-3}),
                                        [&](int i, int, int) { return i >= first && i < first + 4 ? 1 : 0; });
    write_surfaces(surfaces_of(body.bodies()[0], body.scene.materials), folder.path() / name,
                   LengthUnit::millimetre);
  };
  const test::TemporaryFolder folder;
  write(folder, "a.stl", 0);
  write(folder, "b.stl", 6);
  const auto warnings = [&](const std::string& labels) {
    return plausibility(parse_scene("[specimen]\nshape = \"surface\"\nsurface = [\"a.stl\", \"b.stl\"]\n"
                                    "spacing = \"2 mm\"\n" +
                                        labels + "[[hold]]\nwhere = \"z-\"\n",
                                    folder.path() / "scene.toml"))
        .warnings;
  };
  const auto one = warnings("labels = { 1 = \"fat/subcutaneous\" }\n");
  EXPECT_EQ(
      std::ranges::count_if(one, [](const std::string& text) { return test::has(text, "surface b.stl"); }),
      1);
  EXPECT_EQ(
      std::ranges::count_if(one, [](const std::string& text) { return test::has(text, "surface a.stl"); }),
      0);
  for (const char* both :
       {"labels = { \"1..2\" = \"fat/subcutaneous\" }\n", "material = \"fat/subcutaneous\"\n"})
    for (const std::string& text : warnings(both))
      EXPECT_FALSE(test::has(text, "has no cells")) << text;
}

TEST(SurfaceContract, EveryFormatSaysItsUnitAndItsNames) {
  ImagedBody body =
      test::imaged_body(test::grid_of({4, 3, 3}, {1e-3, 1e-3, 1e-3}), [](int, int, int) { return 1; });
  auto surfaces = surfaces_of(body.bodies()[0], body.scene.materials);
  surfaces[0].world = WorldAxes::ras;
  const test::TemporaryFolder folder;
  for (const char* ending : {".stl", ".ply", ".vtp"})
    for (const auto unit : {LengthUnit::metre, LengthUnit::millimetre}) {
      const auto file = folder.path() / ("a" + std::string(ending));
      write_surfaces(surfaces, file, unit);
      const std::string text = test::text_of(file);
      const bool is_vtp = std::string(ending) == ".vtp";
      const std::string words =
          is_vtp ? (unit == LengthUnit::metre ? ">109 0<" : ">109 109 0<")
                 : (unit == LengthUnit::metre ? "SPACE=LPS; UNIT=m" : "SPACE=LPS; UNIT=mm");
      EXPECT_TRUE(test::has(text, words)) << file;
      if (std::string(ending) != ".stl") {
        EXPECT_TRUE(test::has(text, is_vtp ? "109 117 115 99 108 101 47" : "part 0 muscle/soleus"));
      }
    }
  EXPECT_THROW(write_surfaces(surfaces, folder.path() / "a.off", LengthUnit::metre), std::invalid_argument);
}

/// A ball of triangles, by halving those of an octahedron.
std::vector<reader::Triangle> ball(const Vec3& middle, double radius, int halvings) {
  std::vector<reader::Triangle> triangles;
  for (const double z : {1.0, -1.0})
    for (int quarter = 0; quarter < 4; ++quarter) {
      const std::array<Vec3, 4> ring{{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}};
      triangles.push_back({ring[std::size_t(quarter)], ring[std::size_t((quarter + 1) % 4)], Vec3{0, 0, z}});
    }
  const auto halfway = [](const Vec3& a, const Vec3& b) {
    Vec3 m{a[0] + b[0], a[1] + b[1], a[2] + b[2]};
    const double length = std::hypot(m[0], m[1], m[2]);
    return Vec3{m[0] / length, m[1] / length, m[2] / length};
  };
  for (int step = 0; step < halvings; ++step) {
    std::vector<reader::Triangle> finer;
    for (const auto& [a, b, c] : triangles) {
      const Vec3 ab = halfway(a, b), bc = halfway(b, c), ca = halfway(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  for (auto& triangle : triangles)
    for (Vec3& corner : triangle)
      for (std::size_t a = 0; a < 3; ++a)
        corner[a] = middle[a] + radius * corner[a];
  return triangles;
}

/// Truth: the ball's equation, but for voxels nearer to the surface than the triangles to the ball.
TEST(VoxeliseAnalytic, ABallIsItsVoxels) {
  const Vec3 middle{0.03, -0.01, 0.02};
  const auto image =
      reader::voxelised({ball(middle, 0.02, 4), ball(middle, 0.01, 4)}, {1e-3, 1.1e-3, 0.9e-3});
  ASSERT_TRUE(std::holds_alternative<Image>(image));
  const auto& [info, values] = std::get<Image>(image);
  std::size_t voxel = 0;
  int near = 0;
  for (int k = 0; k < info.size[2]; ++k)
    for (int j = 0; j < info.size[1]; ++j)
      for (int i = 0; i < info.size[0]; ++i, ++voxel) {
        const double r = std::hypot(info.origin[0] + i * info.spacing[0] - middle[0],
                                    info.origin[1] + j * info.spacing[1] - middle[1],
                                    info.origin[2] + k * info.spacing[2] - middle[2]);
        const float expected = r < 0.01 ? 2 : r < 0.02 ? 1 : 0;
        if (std::abs(r - 0.01) < 1e-4 || std::abs(r - 0.02) < 1e-4) {
          ++near;
        } else {
          EXPECT_EQ(values[voxel], expected) << i << ' ' << j << ' ' << k;
        }
      }
  EXPECT_LT(near, 2000);
  EXPECT_GT(voxel, 60000U);
}

/// Truth: a shell between the middles of voxels; two balls that overlap.
TEST(VoxeliseContract, LostPartsAreSaid) {
  const auto said = [](double radius, const Vec3& middle) {
    auto triangles = ball({0, 0, 0}, 0.02, 3);
    for (const auto& triangle : ball(middle, radius, 3))
      triangles.push_back(triangle);
    for (std::size_t t = 0; t < triangles.size(); ++t) // outwards: those below are the other way round
      if (triangles[t][2][2] < (t < 512 ? 0 : middle[2]))
        std::swap(triangles[t][0], triangles[t][1]);
    std::vector<std::string> lost;
    EXPECT_TRUE(std::holds_alternative<Image>(reader::voxelised({triangles}, {1e-3, 1e-3, 1e-3}, &lost)));
    return lost;
  };
  EXPECT_TRUE(said(3e-3, {0.03, 0, 0}).empty());
  const auto small = said(2e-4, {0.03, 0, 0}), overlap = said(0.02, {0.002, 0, 0});
  ASSERT_TRUE(small.size() == 1 && overlap.size() == 1);
  EXPECT_TRUE(test::has(small[0], "1 of 2 closed shells") && test::has(overlap[0], "encloses"));
}

TEST(VoxeliseContract, AHoleIsAFaultThatSaysWhere) {
  auto triangles = ball({0, 0, 0}, 0.02, 3);
  triangles.erase(triangles.begin() + 40, triangles.begin() + 60);
  const auto image = reader::voxelised({triangles}, {1e-3, 1e-3, 1e-3});
  ASSERT_TRUE(std::holds_alternative<reader::RegionFault>(image));
  EXPECT_EQ(std::get<reader::RegionFault>(image).expected, "a closed surface");
}

TEST(ObjContract, FacesOfAnyCornersAndNumbersBackwardsAreRead) {
  const test::TemporaryFolder folder;
  const auto cube = folder.write(
      "cube.obj", "# SPACE=RAS\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 0 0 4\nv 4 0 4\nv 4 4 4\n"
                  "v 0 4 4\nvn 0 0 1\nf 1//1 4//1 3//1 2//1\nf 5 6 7 8\nf -8 -7 -3 -4\nf 2 3 7 6\n"
                  "f 3 4 8 7\nf 4 1 5 8\n");
  const auto mesh = reader::read_surface_mesh(cube);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  EXPECT_EQ(mesh.frame, reader::CoordinateFrame::ras);
  const Scene read =
      parse_scene("[specimen]\nshape = \"surface\"\nsurface = [\"cube.obj\", \"cube.obj\"]\n"
                  "spacing = \"1 mm\"\nlabels = { 2 = \"fat/subcutaneous\" }\n[[hold]]\nwhere = \"z-\"\n",
                  folder.path() / "scene.toml");
  EXPECT_EQ(read.specimen.grid.cells(), (Index3{4, 4, 4}));
  EXPECT_EQ(read.specimen.placement.world, WorldAxes::ras);
  EXPECT_EQ(read.specimen.label.front(), 2);
  for (const char* wrong :
       {"v 0 0\n", "v 0 0 0\nf 1 2 3\n", "v 0 0 0\nf 1 1\n", "# nothing\n", "v 0 0 nan\n"})
    EXPECT_THROW(reader::read_obj(folder.write("wrong.obj", wrong)), InputError) << wrong;
}

} // namespace
} // namespace maille
