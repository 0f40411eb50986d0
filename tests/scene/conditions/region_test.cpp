/// Regions in words of anatomy: the nodes that they select, held against positions in the world found here.
#include "maille/materials/text_file.hpp"
#include "maille/scene/scene_builder.hpp"
#include "support/bodies/scenes.hpp"
#include "support/dice.hpp"
#include "support/kit.hpp"
#include "support/label_scene.hpp"

#include <Eigen/Dense>

namespace maille {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::LabelArray;
using test::Mistake;

const std::string head = R"(units = "mm"
[specimen]
shape = "image"
image = "labels.nii"
labels = { 17 = "muscle/soleus", 5 = { youngs_modulus = "30 kPa", poisson_ratio = 0.4 } }
fibre = [0, 3, 4]
)";

/// A place in the world, to the micrometre.
using Place = std::array<std::int64_t, 3>;
using Places = std::set<Place>;

Place rounded(const Vector3d& x) {
  return {std::llround(1e6 * x.x()), std::llround(1e6 * x.y()), std::llround(1e6 * x.z())};
}

struct Axes {
  Matrix3d matrix;
  Vector3d origin;
  explicit Axes(const LabelArray& array) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        matrix(r, c) = array.affine[std::size_t(r)][std::size_t(c)];
      origin(r) = array.affine[std::size_t(r)][3];
    }
  }
  /// Lower corner of a voxel.
  Vector3d corner(int i, int j, int k) const { return matrix * Vector3d(i - 0.5, j - 0.5, k - 0.5) + origin; }
};

/// A corner of voxels: where it is, and the labels around it, 0 for what is no matter.
struct Corner {
  Vector3d x;
  Index3 at{};
  std::set<int> labels;
};

std::vector<Corner> corners_of(const LabelArray& array) {
  const Axes axes(array);
  std::vector<Corner> corners;
  for (const auto& [i, j, k] : test::all_below({array.size[0] + 1, array.size[1] + 1, array.size[2] + 1})) {
    Corner corner{axes.corner(i, j, k), {i, j, k}, {}};
    for (const auto& [x, y, z] : test::all_below({2, 2, 2})) {
      const Index3 voxel{i - x, j - y, k - z};
      if (std::ranges::min(voxel) >= 0 && voxel[0] < array.size[0] && voxel[1] < array.size[1] &&
          voxel[2] < array.size[2])
        corner.labels.insert(array.at(voxel));
    }
    if (corner.labels.contains(17) || corner.labels.contains(5))
      corners.push_back(corner);
  }
  return corners;
}

Places chosen(const LabelArray& array, const std::function<bool(const Corner&)>& is_in) {
  Places places;
  for (const Corner& corner : corners_of(array))
    if (is_in(corner))
      places.insert(rounded(corner.x));
  return places;
}

/// Where the nodes are that a scene holds.
Places held(const Scene& scene) {
  const Specimen& body = scene.specimen;
  Places places;
  for (const Prescribed& p : scene.prescribed) {
    const Vec3 x = point_in_world(body.placement, body.position(body.grid.node_at(p.node)));
    places.insert(rounded({x[0], x[1], x[2]}));
  }
  return places;
}

Scene scene_holding(const image_tests::TemporaryFolder& folder, const std::string& where,
                    const std::string& rest = "") {
  return read_scene(folder.write("scene.toml", head + "[[hold]]\nwhere = " + where + "\n" + rest));
}

std::string in_millimetres(const Vector3d& x) {
  return fmt::format("[{:.9f}, {:.9f}, {:.9f}]", 1e3 * x.x(), 1e3 * x.y(), 1e3 * x.z());
}

/// A text STL of one triangle.
std::string stl_of(const Vector3d& a, const Vector3d& b, const Vector3d& c, const std::string& name) {
  std::string text = "solid " + name + "\nfacet normal 0 0 0\nouter loop\n";
  for (const Vector3d& x : {a, b, c})
    text += fmt::format("  vertex {:.9e} {:.9e} {:.9e}\n", 1e3 * x.x(), 1e3 * x.y(), 1e3 * x.z());
  return text + "endloop\nendfacet\nendsolid\n";
}

// Truth: the same places of the world, found from the voxels' affine here, whichever way the image is stored.
TEST(RegionOracle, SelectsTheSamePlacesInEveryStorageOrder) {
  const LabelArray body = test::bent_body();
  const Axes axes(body);
  const Vector3d middle = axes.corner(2, 1, 1) + 1e-4 * Vector3d(1, 2, 3);
  const Vector3d far = axes.corner(4, 2, 2) + 1e-4 * Vector3d(1, 1, 1);
  const Vector3d low = middle.cwiseMin(far), high = middle.cwiseMax(far);
  const auto lps = [](const Vector3d& x) { return Vector3d(-x.x(), -x.y(), x.z()); };
  // A large triangle in the plane of the voxels' corners k = 1, moved by 0.3 mm.
  const Vector3d normal = axes.matrix.col(2).normalized();
  const Vector3d in_plane = axes.corner(2, 1, 1) + 3e-4 * normal;
  const Vector3d u = axes.matrix.col(0).normalized(), v = axes.matrix.col(1).normalized();
  const std::array<Vector3d, 3> triangle{in_plane - u - v, in_plane + 3 * u - v, in_plane - u + 3 * v};

  struct Case {
    std::string where;
    std::function<bool(const Corner&)> is_in;
  };
  const auto is_in_sphere = [&](const Corner& c) { return (c.x - middle).norm() <= 4e-3; };
  const auto has = [](int label) { return [label](const Corner& c) { return c.labels.contains(label); }; };
  const auto is_shared = [](const Corner& c) { return c.labels.contains(17) && c.labels.contains(5); };
  const std::vector<Case> cases{
      {"{ label = 17 }", has(17)},
      {"{ label = 17, touching = 5 }", is_shared},
      // Not matter, but in the image: 0 is what lies around.
      {"{ label = 5, touching = 0 }",
       [](const Corner& c) { return c.labels.contains(5) && c.labels.contains(0); }},
      {"{ image = \"labels.nii\", value = 17 }", has(17)},
      {"{ image = \"labels.nii\", value = \"1..9\" }", has(5)},
      {"{ image = \"labels.nii\" }", [](const Corner&) { return true; }},
      {"{ image = \"labels.nii\", value = 17, resample = true }", has(17)},
      {"{ sphere = { centre = " + in_millimetres(middle) + ", radius = 4 }, frame = \"world\" }",
       is_in_sphere},
      {"{ sphere = { centre = " + in_millimetres(middle) + ", radius = 4 }, frame = \"ras\" }", is_in_sphere},
      {"{ sphere = { centre = " + in_millimetres(lps(middle)) + ", radius = 4 }, frame = \"lps\" }",
       is_in_sphere},
      {"{ box = [" + in_millimetres(low) + ", " + in_millimetres(high) + "], frame = \"ras\" }",
       [&](const Corner& c) {
         return (c.x.array() >= low.array() - 1e-9).all() && (c.x.array() <= high.array() + 1e-9).all();
       }},
      {"{ points = \"points.fcsv\", within = 3 }",
       [&](const Corner& c) { return (c.x - middle).norm() <= 3e-3 || (c.x - far).norm() <= 3e-3; }},
      {"{ points = \"points.fcsv\", within = 3, name = \"far\" }",
       [&](const Corner& c) { return (c.x - far).norm() <= 3e-3; }},
      {"{ points = \"points.mrk.json\", within = 3 }",
       [&](const Corner& c) { return (c.x - far).norm() <= 3e-3; }},
      {"{ surface = \"surface.stl\", within = 1 }",
       [&](const Corner& c) { return std::abs(normal.dot(c.x - in_plane)) <= 1e-3; }},
      // Label 17 is three voxels of 5 mm long, along k, which points up.
      {"{ label = 17, end = \"proximal\", depth = 6 }",
       [&](const Corner& c) { return c.labels.contains(17) && c.at[2] >= 2; }},
      {"{ label = 17, end = \"inferior\", depth = 1 }",
       [&](const Corner& c) { return c.labels.contains(17) && c.at[2] == 0; }},
      // The upper end of the grid along k, and of what lies towards +x: column 0 of a turn by 0.5.
      {"\"superior\"", [&](const Corner& c) { return c.at[2] == 3; }},
      {"\"right\"", [&](const Corner& c) { return c.at[0] == 4; }},
      {"\"posterior\"", [&](const Corner& c) { return c.at[1] == 0; }},
      {"{ any = [{ label = 17 }, { sphere = { centre = " + in_millimetres(far) +
           ", radius = 4 }, frame = \"world\" }] }",
       [&](const Corner& c) { return c.labels.contains(17) || (c.x - far).norm() <= 4e-3; }},
      {"{ all = [\"superior\", { not = { label = 17 } }] }",
       [&](const Corner& c) { return c.at[2] == 3 && !c.labels.contains(17); }},
  };
  const std::string fcsv = fmt::format("# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n"
                                       "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc\n"
                                       "1,{:.9f},{:.9f},{:.9f},0,0,0,1,1,1,0,middle,\n"
                                       "2,{:.9f},{:.9f},{:.9f},0,0,0,1,1,1,0,far,\n",
                                       1e3 * lps(middle).x(), 1e3 * lps(middle).y(), 1e3 * lps(middle).z(),
                                       1e3 * lps(far).x(), 1e3 * lps(far).y(), 1e3 * lps(far).z());
  for (const test::Orientation& orientation : test::all_orientations()) {
    image_tests::TemporaryFolder folder;
    folder.write("labels.nii", test::nifti_of(test::turned(body, orientation)));
    folder.write("points.fcsv", fcsv);
    folder.write("points.mrk.json",
                 "{\"markups\": [{\"coordinateSystem\": \"RAS\", \"coordinateUnits\": \"mm\", "
                 "\"controlPoints\": [{\"label\": \"far\", \"position\": " +
                     in_millimetres(far) + "}]}]}");
    folder.write("surface.stl",
                 stl_of(lps(triangle[0]), lps(triangle[1]), lps(triangle[2]), "cut; SPACE=LPS"));
    for (const Case& one : cases) {
      const Places expected = chosen(body, one.is_in);
      ASSERT_GT(expected.size(), 0u) << one.where;
      EXPECT_EQ(held(scene_holding(folder, one.where)), expected) << one.where;
    }
  }
}

// Truth: vectors of the world, turned by the affine's own axes here.
TEST(RegionOracle, VectorsInTheWorldAreTheSameInEveryStorageOrder) {
  const LabelArray body = test::bent_body();
  const Vector3d by(1e-4, -2e-4, 3e-4), traction(10, 20, -30), gravity(0, 0, -9.81);
  const Vector3d axis = Vector3d(1, 2, 2) / 3, about(0.01, -0.02, 0.03);
  for (const test::Orientation& orientation : test::all_orientations()) {
    image_tests::TemporaryFolder folder;
    folder.write("labels.nii", test::nifti_of(test::turned(body, orientation)));
    const Scene scene = scene_holding(folder, "\"inferior\"", R"([[move]]
where = "superior"
frame = "ras"
by = [0.1, -0.2, 0.3]
turn = { angle = "7 deg", axis = [1, 2, 2], about = [10, -20, 30] }
[[load]]
where = { label = 5 }
frame = "lps"
traction = ["-10 Pa", "-20 Pa", "-30 Pa"]
[[load]]
frame = "ras"
gravity = [0, 0, -9.81]
)");
    const Specimen& specimen = scene.specimen;
    const auto in_world = [&](const Vec3& vector) {
      const Vec3 w = to_world(specimen.placement, vector);
      return Vector3d(w[0], w[1], w[2]);
    };
    EXPECT_LT((in_world(scene.gravity) - gravity).norm(), 1e-6 * gravity.norm());
    ASSERT_FALSE(scene.tractions.empty());
    for (const FaceLoad& face : scene.tractions) {
      EXPECT_EQ(specimen.label[std::size_t(face.cell)], 5);
      EXPECT_LT((in_world(face.traction) - traction).norm(), 1e-6 * traction.norm());
    }
    std::map<std::int64_t, Vec3> moved;
    for (const Prescribed& p : scene.prescribed)
      if (!p.held)
        moved[p.node][std::size_t(p.component)] = p.value;
    ASSERT_FALSE(moved.empty());
    const Eigen::AngleAxisd turn(7 * std::numbers::pi / 180, axis);
    for (const auto& [node, displacement] : moved) {
      const Vec3 x = point_in_world(specimen.placement, specimen.position(specimen.grid.node_at(node)));
      const Vector3d at(x[0], x[1], x[2]);
      const Vector3d expected = turn * (at - about) + about - at + by;
      EXPECT_LT((in_world(displacement) - expected).norm(), 1e-9);
    }
  }
}

const std::string block = R"(units = "mm"
[specimen]
shape = "box"
cells = [4, 3, 2]
spacing = 1
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
[[hold]]
where = "x-"
)";

// Truth: the force is the sum over faces of traction and area; a closed surface under pressure has none.
/// What a viewer shows of a body's nodes, in an image whose affine has gone through float32.
class ViewedBody {
public:
  explicit ViewedBody(std::mt19937& random) {
    const auto below = [&](int most) { return int(random() % unsigned(most)); };
    std::array<std::size_t, 3> axis{0, 1, 2};
    std::ranges::shuffle(axis, random);
    Index3 size{};
    Affine affine{};
    for (std::size_t r = 0; r < 3; ++r) {
      n[r] = 3 + below(5);
      h[r] = 0.4 + 0.003 * below(1000);
      low[r] = 0.01 * (below(40000) - 20000);
    }
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t r = axis[a];
      const bool is_reversed = below(2) == 1;
      size[a] = n[r];
      affine[r][a] = 1e-3 * double{float(is_reversed ? -h[r] : h[r])};
      affine[r][3] = 1e-3 * double{float(low[r] + h[r] * (is_reversed ? n[r] - 0.5 : 0.5))};
      cut[r] = {below(n[r]), 1 + below(n[r])};
      std::ranges::sort(cut[r]);
      cut[r][1] += cut[r][1] == cut[r][0] ? 1 : 0;
    }
    affine[3][3] = 1;
    const std::vector<std::uint8_t> ones(std::size_t(size[0] * size[1] * size[2]), 1);
    builder.labels(ones, ArrayLayout::x_fastest(size), affine).world(WorldAxes::ras);
  }
  /// A region's corners with four digits behind the point. @param flat the upper face along that axis alone
  std::string box(std::size_t flat = 3) const {
    std::array<std::string, 2> corners;
    for (std::size_t end = 0; end < 2; ++end)
      for (std::size_t r = 0; r < 3; ++r)
        corners[end] += fmt::format("{}\"{:.4f} mm\"", r > 0 ? ", " : "",
                                    low[r] + h[r] * (r == flat ? n[r] : cut[r][end]));
    return fmt::format("{{ box = [[{}], [{}]], frame = \"ras\" }}", corners[0], corners[1]);
  }
  Scene scene(const std::string& conditions) const {
    SceneBuilder asked = builder;
    return asked
        .keys("[specimen]\nmaterial = { youngs_modulus = \"1 kPa\", poisson_ratio = 0.3 }\n" + conditions)
        .build();
  }

  SceneBuilder builder{"viewed"};
  Index3 n{};
  Vec3 h{}, low{}; ///< [mm]
  std::array<std::array<int, 2>, 3> cut{};
};

// Truth: whole numbers of node planes between the corners.
TEST(RegionOracle, BoxesReadOffAViewerAreInclusive) {
  std::mt19937 random(7);
  int wrong = 0;
  for (int i = 0; i < 500; ++i) {
    const ViewedBody body(random);
    std::size_t nodes = 3, faces = 1;
    for (std::size_t r = 0; r < 3; ++r) {
      nodes *= std::size_t(body.cut[r][1] - body.cut[r][0] + 1);
      faces *= std::size_t(r == 2 ? 1 : body.cut[r][1] - body.cut[r][0]);
    }
    const Scene held = body.scene("[[hold]]\nwhere = " + body.box() + "\n");
    const Scene ball =
        body.scene(fmt::format("[[hold]]\nwhere = {{ sphere = {{ centre = [\"{:.4f} mm\", \"{:.4f} mm\", "
                               "\"{:.4f} mm\"], radius = \"{:.4f} mm\" }}, frame = \"ras\" }}\n",
                               body.low[0], body.low[1], body.low[2], *std::ranges::min_element(body.h)));
    const auto in_ball = 3 * std::size_t(1 + std::ranges::count(body.h, *std::ranges::min_element(body.h)));
    const Scene pressed = body.scene(
        "[[hold]]\nwhere = \"inferior\"\n[[load]]\npressure = \"1 kPa\"\nwhere = " + body.box(2) + "\n");
    wrong += held.prescribed.size() == nodes && pressed.tractions.size() == faces &&
                     ball.prescribed.size() == in_ball
                 ? 0
                 : 1;
  }
  std::cout << fmt::format("{{\"name\": \"ras_regions_wrong\", \"value\": {}, \"goal\": 0}}\n", wrong);
  EXPECT_EQ(wrong, 0);
}

// Truth: the same body in a larger image, to the bit. Bodies of noise pass beyond their image's border, too.
TEST(PartialVolumeConsistent, VoidAroundAnImageChangesNoBit) {
  for (unsigned i = 0; i < 40; ++i) {
    const auto body_with = [&](int voids) {
      std::mt19937 random(i);
      const int n = 3 + int(i % 4), size = n + 2 * voids;
      std::vector<std::uint8_t> values(std::size_t(size * size * size), 0);
      const auto at = [&](int x, int y, int z) -> std::uint8_t& {
        return values[std::size_t(x + voids + size * (y + voids + size * (z + voids)))];
      };
      for (const auto& [x, y, z] : test::all_below({n, n, n}))
        at(x, y, z) = std::uint8_t(random() % 3);
      at(0, 0, 0) = 1;
      at(1, 0, 0) = 2;
      const double first = -1e-3 * voids;
      const Affine affine{{{1e-3, 0, 0, first}, {0, 1e-3, 0, first}, {0, 0, 1e-3, first}, {0, 0, 0, 1}}};
      return SceneBuilder()
          .labels(values, ArrayLayout::x_fastest({size, size, size}), affine)
          .keys(fmt::format("[specimen]\nlabels = {{ 1 = \"muscle/soleus\", 2 = \"bone/cortical_tibia\" "
                            "}}\nfibre = [1, 0, 0]\n"
                            "partial_volume = {{ smooth = \"0.{} mm\" }}\n[[hold]]\n"
                            "where = {{ sphere = {{ centre = [0, 0, 0], radius = \"1 m\" }} }}\n",
                            6 + i % 4))
          .build()
          .specimen;
    };
    const Specimen tight = body_with(0), padded = body_with(1 + int(i % 3));
    EXPECT_EQ(tight.grid.cells(), padded.grid.cells()) << i;
    EXPECT_EQ(tight.tissue, padded.tissue) << i;
    EXPECT_EQ(tight.material_id, padded.material_id) << i;
    EXPECT_EQ(tight.label, padded.label) << i;
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR(point_in_world(tight.placement, tight.origin)[a],
                  point_in_world(padded.placement, padded.origin)[a], 1e-15);
  }
}

TEST(RegionAnalytic, LoadsOnFaces) {
  const auto force_of = [](const std::string& load) {
    const Scene scene = parse_scene(block + "[[load]]\n" + load);
    Vector3d force = Vector3d::Zero();
    for (const FaceLoad& face : scene.tractions)
      force += 1e-6 * Vector3d(face.traction[0], face.traction[1], face.traction[2]);
    return std::pair{force, scene.tractions.size()};
  };
  const auto [shared, n_shared] =
      force_of("where = { any = [\"x+\", \"y+\"] }\nforce = [\"2 N\", 0, \"-4 mN\"]");
  EXPECT_EQ(n_shared, 6u + 8u);
  EXPECT_LT((shared - Vector3d(2, 0, -4e-3)).norm(), 1e-12);
  const auto [pushed, n_pushed] = force_of("where = \"y+\"\npressure = \"100 mmHg\"");
  EXPECT_EQ(n_pushed, 8u);
  EXPECT_LT((pushed - Vector3d(0, -13332.2387415 * 8e-6, 0)).norm(), 1e-12);
  const auto [closed, n_closed] =
      force_of("where = { any = [\"x-\", { not = \"x-\" }] }\npressure = \"1 kPa\"");
  EXPECT_EQ(n_closed, 2 * (12u + 8u + 6u));
  EXPECT_LT(closed.norm(), 1e-15);
}

/// A random union of two boxes of labels 17 and 5, which fills its array's box.
LabelArray random_body(test::Dice& dice, bool is_one_box) {
  LabelArray body{{7 + dice.below(5), 6 + dice.below(5), 7 + dice.below(6)}, {}, {}};
  body.affine =
      affine_of({1 / 1024.0, 1 / 512.0, 3 / 2048.0}, {0, 0, 0}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
  const int split = 2 + dice.below(body.size[0] - 4),
            high = is_one_box ? body.size[2] : 2 + dice.below(body.size[2] - 2);
  for (const auto& [i, j, k] : test::all_below(body.size))
    body.values.push_back(i < split ? 17 : k < high ? 5 : 0);
  return body;
}

// Truth: a pressure times the vector area, of whole voxels counted here by their corners; with partial volume
// of a side the area of the voxels' side, and of a region and all else nothing.
TEST(RegionIndependent, ResultantsOfRandomRegions) {
  constexpr double pressure = 1e3;
  std::mt19937 random(41);
  test::Dice dice{random};
  const Vec3 h{1 / 1024.0, 1 / 512.0, 3 / 2048.0}; // as float32 has them
  double resultant_error = 0;
  int n_patches = 0;
  for (int n = 0; n < 300; ++n) {
    const bool is_partial = n % 3 == 2;
    const LabelArray body = random_body(dice, is_partial);
    const int axis = dice.below(3), upper = dice.below(2);
    const std::string side = fmt::format("\"{}{}\"", "xyz"[axis], upper ? '+' : '-');
    Index3 low{}, high{};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = dice.below(body.size[a]);
      high[a] = low[a] + 1 + dice.below(body.size[a] - low[a]);
    }
    const int form = is_partial ? 7 * dice.below(2) : dice.below(7);
    if (form == 6)
      high[2] = low[2]; // a rectangle, of triangles that overlap
    const std::string box =
        fmt::format("{{ box = [[{}, {}, {}], [{}, {}, {}]] }}", low[0] * h[0], low[1] * h[1], low[2] * h[2],
                    high[0] * h[0], high[1] * h[1], high[2] * h[2]);
    const std::vector<std::string> forms{side,
                                         box,
                                         "{ not = " + box + " }",
                                         "{ label = 5 }",
                                         "{ all = [" + side + ", { label = 17 }] }",
                                         "{ any = [" + side + ", " + box + "] }",
                                         "{ surface = \"patch.stl\", within = 1e-4 }"};
    const std::string where =
        form == 7 ? "{ any = [" + box + ", { not = " + box + " }] }" : forms[std::size_t(form)];
    const auto is_corner_in = [&](const Index3& x) {
      bool is_in = true;
      for (std::size_t a = 0; a < 3; ++a)
        is_in = is_in && x[a] >= low[a] && x[a] <= high[a];
      return is_in;
    };
    Vector3d expected = Vector3d::Zero();
    double total = 0;
    for (const auto& [i, j, k] : test::all_below(body.size))
      for (int s = 0; s < 6; ++s) {
        const auto a = std::size_t(s / 2);
        Index3 beyond{i, j, k};
        beyond[a] += s % 2 ? 1 : -1;
        const bool is_outer = beyond[a] < 0 || beyond[a] >= body.size[a];
        if (body.at({i, j, k}) == 0 || (!is_outer && body.at(beyond) != 0))
          continue;
        bool is_in_box = true;
        for (int c = 0; c < 8; ++c)
          is_in_box = is_in_box &&
                      ((c >> a & 1) != s % 2 || is_corner_in({i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)}));
        const bool is_side = is_outer && s == 2 * axis + upper;
        const std::array<bool, 8> is_in{is_side,
                                        is_in_box,
                                        !is_in_box,
                                        body.at({i, j, k}) == 5,
                                        is_side && body.at({i, j, k}) == 17,
                                        is_side || is_in_box,
                                        is_in_box,
                                        true};
        const double area = h[0] * h[1] * h[2] / h[a];
        total += area;
        if (is_in[std::size_t(form)])
          expected[s / 2] += pressure * area * (s % 2 ? -1 : 1);
      }
    image_tests::TemporaryFolder folder;
    folder.write("labels.nii", test::nifti_of(body));
    const auto corner = [&](int i, int j) { // LPS, from the middle of voxel 0
      return Vector3d((0.5 - i) * h[0], (0.5 - j) * h[1], (low[2] - 0.5) * h[2]);
    };
    const Vector3d a = corner(low[0], low[1]), b = corner(high[0], low[1]), c = corner(high[0], high[1]),
                   d = corner(low[0], high[1]);
    folder.write("patch.stl", stl_of(a, b, c, "p; SPACE=LPS") + stl_of(a, c, d, "q") + stl_of(a, b, d, "r"));
    const auto file = folder.write(
        "scene.toml",
        "units = \"m\"\n[specimen]\nshape = \"image\"\nimage = \"labels.nii\"\nlabels = { 17 = { "
        "youngs_modulus = 1e4, poisson_ratio = 0.3 }, 5 = { youngs_modulus = 2e4, poisson_ratio = 0.3 } "
        "}\n" +
            std::string(is_partial ? "coarsen = 2\npartial_volume = true\n" : "") +
            "[[hold]]\nwhere = \"z-\"\n[[load]]\npressure = 1e3\nwhere = " + where + "\n");
    try {
      const Scene scene = read_scene(file);
      const Vec3& cell = scene.specimen.grid.spacing();
      Vector3d force = Vector3d::Zero();
      for (const FaceLoad& face : scene.tractions)
        force += cell[0] * cell[1] * cell[2] / cell[std::size_t(face.axis)] *
                 Vector3d(face.traction[0], face.traction[1], face.traction[2]);
      resultant_error = std::max(resultant_error, (force - expected).norm() / (pressure * total));
      n_patches += form == 6 && total > 0 && force.norm() > 0;
      EXPECT_LT((force - expected).norm(), 1e-9 * pressure * total) << read_text_file(file, "a scene");
    } catch (const InputError& error) {
      EXPECT_TRUE(error.faults().front().key.starts_with("load[1].where")) << "no whole face is in it";
    }
  }
  EXPECT_GT(n_patches, 0);
  std::cout << "resultant_error " << resultant_error << '\n';
}

// Truth: whole cells in a ball, counted by their corners here; those outside are all others.
TEST(RegionOracle, CellsOfABallAndOfWhatIsOutside) {
  const auto contracting = [](const std::string& where) {
    const Scene scene = parse_scene(block + "[[load]]\ncontraction = \"1 kPa\"\nwhere = " + where);
    std::set<std::int64_t> cells;
    for (std::size_t cell = 0; cell < scene.active_stress.size(); ++cell)
      if (scene.active_stress[cell] > 0)
        cells.insert(std::int64_t(cell));
    return cells;
  };
  std::set<std::int64_t> inside, outside;
  for (const auto& [i, j, k] : test::all_below({4, 3, 2})) {
    double farthest = 0;
    for (int c = 0; c < 8; ++c)
      farthest = std::max(farthest,
                          std::hypot(i + (c & 1) - 1.0, j + ((c >> 1) & 1) - 1.0, k + ((c >> 2) & 1) - 1.0));
    (farthest <= 1.8 ? inside : outside).insert(i + 4 * (j + 3 * k));
  }
  ASSERT_EQ(inside.size(), 8u);
  const std::string ball = "{ sphere = { centre = [1, 1, 1], radius = 1.8 } }";
  EXPECT_EQ(contracting(ball), inside);
  EXPECT_EQ(contracting("{ not = " + ball + " }"), outside);
}

constexpr const char* good = "{ label = 17 }";
const Mistake mistakes[] = {
    {"no_such_label", good, "{ label = 18 }", 8, "hold[1].where.label", "5, 17"},
    {"never_touches", good, "{ label = 17, touching = 99 }", 8, "hold[1].where.touching", "99"},
    {"two_kinds", good, "{ label = 17, surface = \"here.stl\" }", 8, "hold[1].where", "more than one"},
    {"no_kind", good, "{ near = 17 }", 8, "hold[1].where", "sphere"},
    {"unknown_key", good, "{ label = 17, within = 3 }", 8, "hold[1].where.within", "label"},
    {"no_depth", good, "{ label = 17, end = \"distal\" }", 8, "hold[1].where.depth", "10 mm"},
    {"no_end", good, "{ label = 17, depth = 3 }", 8, "hold[1].where.depth", "end"},
    {"unknown_end", good, "{ label = 17, end = \"up\", depth = 3 }", 8, "hold[1].where.end", "proximal"},
    {"end_across", good, "{ label = 17, end = \"left\", depth = 3 }", 8, "hold[1].where.end", "degrees off"},
    {"no_end_of_what_is_stout", good, "{ label = 5, end = \"left\", depth = 3 }", 8, "hold[1].where.end",
     "off it"},
    {"negative_depth", good, "{ label = 17, end = \"distal\", depth = -3 }", 8, "hold[1].where.depth", "> 0"},
    {"sphere_without_radius", good, "{ sphere = { centre = [0, 0, 0] } }", 8, "hold[1].where.sphere.radius",
     "> 0"},
    {"unknown_frame", good, "{ box = [[0,0,0],[1,1,1]], frame = \"lab\" }", 8, "hold[1].where.frame", "lps"},
    {"nothing_there", good, "{ box = [[0,0,0],[1,1,1]], frame = \"lps\" }", 8, "hold[1].where",
     "in the world"},
    {"mask_on_another_grid", good, "{ image = \"shifted.nii\", value = 17 }", 8, "hold[1].where.image",
     "resample"},
    {"no_mask", good, "{ image = \"nowhere.nii\" }", 8, "hold[1].where.image", "nowhere"},
    {"mask_value", good, "{ image = \"labels.nii\", value = \"a..b\" }", 8, "hold[1].where.value", "17..19"},
    {"surface_misses", good, "{ surface = \"here.stl\", within = 1 }", 8, "hold[1].where", "reaches"},
    {"surface_cut_off", good, "{ surface = \"cut.stl\", within = 1 }", 8, "hold[1].where.surface",
     "endsolid"},
    {"surface_of_words", good, "{ surface = \"word.stl\", within = 1 }", 8, "hold[1].where.surface",
     "word.stl:3"},
    {"no_surface", good, "{ surface = \"labels.nii\", within = 1 }", 8, "hold[1].where.surface", "neither"},
    {"landmarks_in_an_unknown_frame", good, "{ points = \"unknown.fcsv\", within = 1 }", 8,
     "hold[1].where.points", "coordinate system"},
    {"no_landmark", good, "{ points = \"none.fcsv\", within = 1 }", 8, "hold[1].where.points",
     "at least one"},
    {"landmark_that_is_none", good, "{ points = \"odd.fcsv\", within = 1 }", 8, "hold[1].where.points",
     "odd.fcsv:2"},
    {"markups_of_another_form", good, "{ points = \"odd.mrk.json\", within = 1 }", 8, "hold[1].where.points",
     "[x, y, z] in millimetres"},
    {"landmark_of_no_such_name", good,
     "{ points = \"unknown.fcsv\", within = 1, frame = \"ras\", name = \"top\" }", 8, "hold[1].where.name",
     "tip"},
    {"empty_list", good, "{ any = [] }", 8, "hold[1].where.any", "list of regions"},
    {"fault_inside", good, "{ any = [\"x-\", { not = \"w+\" }] }", 8, "hold[1].where.any[2].not", "superior"},
    {"single_axes_of_a_world", good, "{ label = 17 }\nframe = \"ras\"\naxes = \"x\"", 10, "hold[1].axes",
     "grid"},
};

TEST(RegionMistakeContract, IsReportedWithItsLineAndKey) {
  image_tests::TemporaryFolder folder;
  folder.write("labels.nii", test::nifti_of(test::bent_body()));
  LabelArray shifted = test::bent_body();
  shifted.affine[0][3] += 3e-4;
  folder.write("shifted.nii", test::nifti_of(shifted));
  folder.write("here.stl", stl_of({1, 1, 1}, {2, 1, 1}, {1, 2, 1}, "far"));
  folder.write("cut.stl", "solid x\nfacet\nvertex 1 2 3\n");
  folder.write("word.stl", "solid x\nfacet\nvertex 1 2 three\nendsolid\n");
  folder.write("unknown.fcsv", "1,0,0,0,0,0,0,1,1,1,0,tip\n");
  folder.write("none.fcsv", "# CoordinateSystem = LPS\n");
  folder.write("odd.fcsv", "# CoordinateSystem = LPS\n1,0,nan,0,0,0,0,1,1,1,0,tip\n");
  folder.write("odd.mrk.json", "{\"markups\": [{\"controlPoints\": 3}]}");
  for (const Mistake& mistake : mistakes) {
    SCOPED_TRACE(mistake.name);
    const auto faults = test::faults_found_by([&] {
      read_scene(folder.write("scene.toml",
                              test::with_mistake(head + "[[hold]]\nwhere = { label = 17 }\n", mistake)));
    });
    test::expect_only(mistake, faults);
  }
}

// Truth: an image that does not say where the patient is has no superior face, and says what would.
TEST(RegionContract, APatientHasToBeKnown) {
  const auto faults = test::faults_found_by(
      [] { parse_scene(test::box_text("[2, 2, 2]") + test::hold_text("superior"), "scene.toml"); });
  EXPECT_TRUE(test::says_only(faults, {.line = 7, .expected = "NIfTI"}));
}

// Truth: a calf from MRI hangs head up, so the upper end of a long muscle is where its voxels are highest.
TEST(RegionData, TheUpperEndOfASoleus) {
  if (!std::getenv("MAILLE_DATA"))
    GTEST_SKIP() << "MAILLE_DATA is not set";
  const auto scene_of = [](const std::string& where) {
    return parse_scene("[specimen]\nshape = \"image\"\nimage = \"$MAILLE_DATA/calf_mri/labels.nii.gz\"\n"
                       "labels = { 17 = \"muscle/soleus\", 14 = \"muscle/soleus\", 16 = \"muscle/soleus\" "
                       "}\nfibre = [0, 0, 1]\n[[hold]]\nwhere = " +
                       where + "\n");
  };
  const auto height = [](const Scene& scene, std::int64_t node) {
    const Specimen& body = scene.specimen;
    return point_in_world(body.placement, body.position(body.grid.node_at(node)))[2];
  };
  const auto heights = [&](const Scene& scene) {
    std::set<double> all;
    for (const Prescribed& p : scene.prescribed)
      all.insert(height(scene, p.node));
    return all;
  };
  const auto whole = heights(scene_of("{ label = 17 }"));
  const auto upper = heights(scene_of("{ label = 17, end = \"proximal\", depth = \"10 mm\" }"));
  const auto lower = heights(scene_of("{ label = 17, end = \"distal\", depth = \"10 mm\" }"));
  ASSERT_FALSE(upper.empty());
  ASSERT_FALSE(lower.empty());
  EXPECT_EQ(*upper.rbegin(), *whole.rbegin());
  EXPECT_EQ(*lower.begin(), *whole.begin());
  EXPECT_GT(*upper.begin(), *lower.rbegin());
  EXPECT_LT(*upper.rbegin() - *upper.begin(), 15e-3);
  // Two neighbours that meet at three faces of voxels, counted in the file, of 4 nodes each.
  const auto shared = scene_of("{ label = 14, touching = 16 }").prescribed.size() / 3;
  EXPECT_GE(shared, 4u);
  EXPECT_LE(shared, 16u);
}

} // namespace
} // namespace maille
