#include "maille/scene/world/world_scene.hpp"

#include "maille/base/arena.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

using test::expect_only;
using test::Mistake;

std::vector<Fault> faults_of(const std::string& text) {
  return test::faults_found_by([&] { parse_world_scene(text, "scene.toml"); });
}

const std::string good = R"([world]
cells = [20, 10]
spacing = "1 mm"
friction = 0.2
frame_budget = "16 ms"
method = "relaxed"
contact = "cells"
[[object]]
name = "wall"
kind = "fixed"
shape = "rows"
rows = ["##.", "#.#"]
[[object]]
name = "soft"
kind = "deformable"
shape = "box"
cells = [4, 3]
spacing = "0.9 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
position = ["5 mm", "2 mm"]
turn = { angle = "90 deg" }
hold = [{ where = "x-", axes = "y" }]
limits = { from = "given", stretch = 1.2, compress = 0.5, shear = 0.3 }
)";

// The scene has every value of the file.
TEST(ReadWorldSceneContract, EveryKeyArrives) {
  const WorldScene world = parse_world_scene(good, "some/soft_world.toml");
  EXPECT_EQ(world.name, "soft_world");
  EXPECT_EQ(world.dimension, 2);
  EXPECT_EQ(world.cells, (Index3{20, 10, 1}));
  EXPECT_EQ(world.spacing[0], 0.001);
  EXPECT_EQ(world.friction, 0.2);
  EXPECT_EQ(world.frame_budget, 0.016);
  EXPECT_EQ(world.method, "relaxed");
  EXPECT_EQ(world.contact, ContactLaw::cells);
  std::string surfaces = good;
  surfaces.replace(surfaces.find("\"cells\""), 7, "\"surfaces\"");
  EXPECT_EQ(parse_world_scene(surfaces).contact, ContactLaw::surfaces);
  ASSERT_EQ(world.objects.size(), 2u);
  const WorldObject &wall = world.objects[0], &soft = world.objects[1];
  EXPECT_EQ(wall.name, "wall");
  EXPECT_EQ(wall.kind, ObjectKind::fixed);
  EXPECT_EQ(wall.scene.specimen.grid.cells(), (Index3{3, 2, 1}));
  EXPECT_EQ(wall.scene.specimen.grid.spacing()[0], 0.001); // the world's
  // The first line is on top: its letters are the second row of cells.
  const std::vector<std::uint8_t> drawn{0, no_material, 0, 0, 0, no_material};
  EXPECT_EQ(wall.scene.specimen.material_id, drawn);
  EXPECT_EQ(soft.kind, ObjectKind::deformable);
  EXPECT_EQ(soft.scene.specimen.grid.spacing()[0], 0.0009);
  EXPECT_EQ(soft.position, (Vec3{0.005, 0.002, 0}));
  EXPECT_NEAR(soft.turn_angle, std::numbers::pi / 2, 1e-15);
  EXPECT_EQ(soft.scene.limits.from, LimitSource::given);
  ASSERT_EQ(soft.scene.prescribed.size(), 4u); // nodes of the face, one component each
  for (const Prescribed& held : soft.scene.prescribed) {
    EXPECT_TRUE(held.held);
    EXPECT_EQ(held.component, 1);
    EXPECT_EQ(held.value, 0);
  }
}

const std::string moving = R"([world]
cells = [20, 10]
spacing = "1 mm"
contact = "surfaces"
dynamics = { gravity = [0, "-9.81 m/s^2"], restitution = 0.5, damping = 0.1 }
[[object]]
name = "ball"
kind = "rigid"
shape = "box"
cells = [4, 4]
density = "2 g/cm^3"
velocity = [0.3, 0]
)";

// Settings of dynamics arrive; a scene without them has no dynamics.
TEST(ReadWorldSceneContract, DynamicsArrive) {
  EXPECT_FALSE(parse_world_scene(good).dynamics);
  const WorldScene world = parse_world_scene(moving);
  ASSERT_TRUE(world.dynamics);
  EXPECT_EQ(world.dynamics->gravity, (Vec3{0, -9.81, 0}));
  EXPECT_EQ(world.dynamics->restitution, 0.5);
  EXPECT_EQ(world.dynamics->damping, 0.1);
  EXPECT_EQ(world.objects[0].density, 2000);
  EXPECT_EQ(world.objects[0].velocity, (Vec3{0.3, 0, 0}));
}

TEST(ReadWorldSceneContract, FaultsOfDynamicsAreReported) {
  for (const Mistake& mistake :
       {Mistake{"too_much", "restitution = 0.5", "restitution = 1.5", 5, "world.dynamics.restitution",
                "from 0 to 1"},
        Mistake{"driving", "damping = 0.1", "damping = -0.1", 5, "world.dynamics.damping", ">= 0"},
        Mistake{"no_mass", "2 g/cm^3", "0 g/cm^3", 11, "object[1].density", "> 0"},
        Mistake{"by_cells", "\"surfaces\"", "\"cells\"", 5, "world.dynamics", "surfaces"},
        Mistake{"of_what_stands", "\"rigid\"\nshape = \"box\"\ncells = [4, 4]\ndensity = \"2 g/cm^3\"",
                "\"fixed\"\nshape = \"box\"\ncells = [4, 4]", 11, "object[1].velocity", "moves"}})
    expect_only(mistake, faults_of(with_mistake(moving, mistake)));
}

// A rigid object's surface: that of its voxels, unless a scene asks for the smooth one.
TEST(ReadWorldSceneContract, SmoothSurfacesArrive) {
  EXPECT_FALSE(parse_world_scene(moving).objects[0].is_smooth);
  std::string smooth = moving;
  smooth.replace(smooth.find("density"), 0, "surface = \"smooth\"\n");
  EXPECT_TRUE(parse_world_scene(smooth).objects[0].is_smooth);
  std::string by_cells = good;
  by_cells.replace(by_cells.find("name = \"wall\""), 0, "surface = \"smooth\"\n");
  EXPECT_THROW(parse_world_scene(by_cells), InputError);
}

const Mistake mistakes[] = {
    {"no_cells", "cells = [20, 10]\n", "", 1, "world.cells", "whole numbers"},
    {"too_many_cells", "[20, 10]", "[40000, 10]", 2, "world.cells", "32768"},
    {"negative_friction", "0.2", "-0.2", 4, "world.friction", ">= 0"},
    {"budget_without_unit_of_time", "16 ms", "16 mm", 5, "world.frame_budget", "a time"},
    {"unknown_method", "\"relaxed\"", "\"hand_on\"", 6, "world.method", "coupled"},
    {"unknown_contact", "\"cells\"", "\"halving\"", 7, "world.contact", "surfaces"},
    {"unknown_key", "friction", "stiction", 4, "world.stiction", "friction"},
    {"no_name", "name = \"wall\"\n", "", 8, "object[1].name", "trajectory"},
    {"name_twice", "\"soft\"", "\"wall\"", 14, "object[2].name", "no other"},
    {"unknown_kind", "\"fixed\"", "\"stiff\"", 10, "object[1].kind", "rigid"},
    {"unknown_shape", "\"rows\"", "\"rowz\"", 11, "object[1].shape", "puzzle_piece"},
    {"uneven_rows", "\"##.\"", "\"##\"", 12, "object[1].rows", "one length"},
    {"empty_rows", "\"##.\", \"#.#\"", "\"...\", \"...\"", 11, "object[1].shape", "matter"},
    {"another_dimension", "cells = [4, 3]", "cells = [4, 3, 2]", 16, "object[2].shape", "dimension 2"},
    {"no_material", "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n", "", 13,
     "object[2].material", "material"},
    {"turn_with_a_point", "angle = \"90 deg\"", "angle = \"90 deg\", about = [0, 0, 0]", 21, "object[2].turn",
     "about"},
    {"no_node_held", "where = \"x-\"", "where = { box = [[\"1 m\", \"1 m\"], [\"2 m\", \"2 m\"]] }", 22,
     "object[2].hold[1].where", "node"},
    {"limits_of_what_is_rigid", "kind = \"fixed\"", "kind = \"fixed\"\nlimits = { from = \"taut\" }", 11,
     "object[1].limits", "deformable"},
    {"moves_belong_to_scenes", "hold =", "move = [{ where = \"x+\", by = [0, 0] }]\nhold =", 22,
     "object[2].move", "unknown key"},
    {"specimen_beside_it", "[world]", "[specimen]\n[world]", 1, "specimen", "[[object]]"},
};

TEST(WorldMistakeContract, IsReportedWithItsLineAndKey) {
  for (const Mistake& mistake : mistakes) {
    SCOPED_TRACE(mistake.name);
    expect_only(mistake, faults_of(with_mistake(good, mistake)));
  }
}

TEST(ReadWorldSceneContract, AllFaultsComeAtOnce) {
  std::string text = good;
  for (const auto& [from, to] :
       {std::pair{"\"1 mm\"", "\"-1 mm\""}, {"\"fixed\"", "\"stiff\""}, {"0.3 }", "0.7 }"}})
    text.replace(text.find(from), std::string_view(from).size(), to);
  const auto faults = faults_of(text);
  ASSERT_EQ(faults.size(), 3u) << InputError(faults).what();
  EXPECT_EQ(faults[0].line, 3);
}

// 2048^3 bricks of 16^3 cells, 4 bytes each: 32 GiB.
TEST(ReadWorldSceneContract, AMapBeyondMemoryIsAFault) {
  if (available_memory() > (std::int64_t{32} << 30))
    GTEST_SKIP() << "this machine has room for it";
  const auto faults =
      faults_of("[world]\ncells = [32768, 32768, 32768]\nspacing = \"1 m\"\n[[object]]\nname = \"a\"\nkind = "
                "\"rigid\"\nshape = \"box\"\ncells = [1, 1, 1]\n");
  EXPECT_TRUE(test::says_only(faults, {.line = 2, .key = "world.cells"}));
}

TEST(ReadWorldSceneContract, ScenesOfOneKindAreNotTakenForTheOther) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("a.toml", good);
  EXPECT_TRUE(is_world_scene(file));
  EXPECT_FALSE(is_world_scene(folder / "nothing.toml"));
  EXPECT_FALSE(is_world_scene(folder.write("b.toml", "[specimen]\n")));
  EXPECT_TRUE(test::says_only(test::faults_found_by([&] { read_scene(file); }), {.key = "world"}));
}

std::string piece(int column, int row) {
  return test::object_text(fmt::format("{}{}", column, row), "rigid", "[45, 32]",
                           fmt::format("pieces = [3, 2]\npiece = [{}, {}]\n", column, row), "puzzle_piece");
}

// Every cell of the picture belongs to one piece. Edges bulge: a piece that were a rectangle would be no
// puzzle.
TEST(ObjectShapesAnalytic, PiecesMakeUpThePicture) {
  std::string text = test::world_text("[64, 64]");
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 3; ++column)
      text += piece(column, row);
  const WorldScene world = parse_world_scene(text);
  std::set<std::pair<int, int>> taken;
  std::int64_t cells = 0;
  for (const WorldObject& object : world.objects) {
    const Specimen& body = object.scene.specimen;
    EXPECT_GT(body.n_matter_cells(), 45 * 32 / 6 / 2);
    EXPECT_LT(body.n_matter_cells(), body.grid.n_cells());
    for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
      if (!body.is_matter(cell))
        continue;
      const Vec3 corner = body.position(body.grid.cell_at(cell));
      taken.emplace(std::lround(corner[0] / 1e-3), std::lround(corner[1] / 1e-3));
      ++cells;
    }
  }
  EXPECT_EQ(cells, 45 * 32);
  EXPECT_EQ(taken.size(), 45u * 32u);
}

Specimen solid(const std::string& keys) {
  return parse_world_scene("[world]\ncells = [64, 64, 64]\nspacing = \"1 mm\"\n[[object]]\nname = "
                           "\"it\"\nkind = \"rigid\"\n" +
                           keys)
      .objects[0]
      .scene.specimen;
}

constexpr const char* thread =
    "thread = { radius = \"8 mm\", depth = \"2 mm\", pitch = \"10 mm\", play = \"1 mm\" }\n";

// Volumes of a ring, and of a shaft whose ridge takes half of each turn; a cell is worth 1 mm^3.
TEST(ObjectShapesAnalytic, HardwareHasItsVolume) {
  const Specimen washer = solid("shape = \"washer\"\ncells = [40, 40, 3]\nhole = \"10 mm\"\n");
  EXPECT_NEAR(static_cast<double>(washer.n_matter_cells()), std::numbers::pi * (400 - 100) * 3, 30);
  const Specimen bolt =
      solid(std::string("shape = \"bolt\"\ncells = [28, 28, 48]\nhead = \"8 mm\"\n") + thread);
  const double head = 1.5 * std::sqrt(3) * 14 * 14 * 8;
  const double shaft = std::numbers::pi * (36 + 0.5 * (64 - 36)) * 40;
  EXPECT_NEAR(static_cast<double>(bolt.n_matter_cells()), head + shaft, 0.03 * (head + shaft));
}

// A bolt and a nut whose frames stand alike about one axis, a whole number of turns apart: ridges lie between
// ridges.
TEST(ObjectShapesAnalytic, ANutFitsOntoItsBolt) {
  const Specimen bolt =
      solid(std::string("shape = \"bolt\"\ncells = [28, 28, 48]\nhead = \"8 mm\"\n") + thread);
  const Specimen nut = solid(std::string("shape = \"nut\"\ncells = [28, 28, 10]\n") + thread);
  const auto shared = [&](int lift) {
    int cells = 0;
    for (std::int64_t cell = 0; cell < nut.grid.n_cells(); ++cell) {
      const Vec3 at = nut.position(nut.grid.cell_at(cell));
      Index3 other{};
      for (std::size_t a = 0; a < 3; ++a)
        other[a] = static_cast<int>(std::lround((at[a] - bolt.origin[a]) / 1e-3)) + (a == 2 ? lift : 0);
      cells += nut.is_matter(cell) && bolt.grid.has_cell(other) && bolt.is_matter(bolt.grid.cell(other));
    }
    return cells;
  };
  EXPECT_EQ(shared(20), 0);
  EXPECT_EQ(shared(30), 0);
  EXPECT_GT(shared(25), 50); // half a turn off
}

} // namespace
} // namespace maille
