/// Surfaces of deformed bodies, out as files and in as bodies.
#include "conditions/voxelise.hpp"
#include "maille/materials/fault.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/warp/surface.hpp"

#include "scene/warp/warp_bodies.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

using test::ImagedBody;

/// By the divergence theorem, over the quads' two triangles from their first corner.
double volume_of(const BodySurface& surface) {
  double sum = 0;
  const auto triple = [](const Vec3& a, const Vec3& b, const Vec3& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
  };
  for (const auto& quad : surface.quads)
    for (std::size_t i = 1; i < 3; ++i)
      sum += triple(surface.points[static_cast<std::size_t>(quad[0])],
                    surface.points[static_cast<std::size_t>(quad[i])],
                    surface.points[static_cast<std::size_t>(quad[i + 1])]) /
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
      EXPECT_NE(text.find(words), std::string::npos) << file;
      if (std::string(ending) != ".stl") {
        EXPECT_NE(text.find(is_vtp ? "109 117 115 99 108 101 47" : "part 0 muscle/soleus"),
                  std::string::npos);
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
      triangles.push_back({ring[static_cast<std::size_t>(quarter)],
                           ring[static_cast<std::size_t>((quarter + 1) % 4)], Vec3{0, 0, z}});
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
