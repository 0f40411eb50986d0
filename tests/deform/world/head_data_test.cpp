#include "maille/deform/world/rigid_world.hpp"
#include "maille/scene/image.hpp"
#include "world/occupancy/posed_shape.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>

namespace maille::deform {
namespace {

constexpr float bone = 1150;

/// Cells that one voxel can come to from `start`, through faces.
std::vector<bool> reachable_from(const OccupancyMap& map, const Index3& start) {
  const Index3& n = map.cells();
  const auto number = [&](const Index3& at) {
    return static_cast<std::size_t>(at[0] + n[0] * (at[1] + n[1] * at[2]));
  };
  std::vector<bool> seen(static_cast<std::size_t>(n[0] * n[1] * n[2]));
  std::vector<Index3> front{start};
  while (!front.empty()) {
    const Index3 at = front.back();
    front.pop_back();
    if (map.is_blocked(at) || seen[number(at)])
      continue;
    seen[number(at)] = true;
    for (std::size_t a = 0; a < 3; ++a)
      for (const int step : {-1, 1}) {
        Index3 next = at;
        next[a] += step;
        front.push_back(next);
      }
  }
  return seen;
}

// Real data: a head from CT. Truth: what can be reached through faces, found by a flood (oracle).
TEST(HeadData, AFingertipFeelsTheSkullAndNeverEntersIt) {
  const char* const data = std::getenv("MAILLE_DATA");
  const std::filesystem::path file =
      std::filesystem::path(data == nullptr ? "" : data) / "head_ct/headsq.mha";
  if (data == nullptr || !std::filesystem::exists(file))
    GTEST_SKIP() << "MAILLE_DATA names no folder with head_ct/headsq.mha";
  const Image image = read_image(file);
  std::vector<std::uint8_t> matter;
  for (const float value : image.values)
    matter.push_back(value > bone);
  const Index3& cells = image.info.size;
  RigidWorld world(cells, image.info.spacing);
  ASSERT_TRUE(world.add(RigidShape(cells, image.info.spacing, matter), {}).object);
  const RigidShape tip({1, 1, 1}, image.info.spacing, std::vector<std::uint8_t>{1});
  const int finger = *world.add(tip, {}).object;
  // The flood is of the world without the fingertip.
  RigidWorld without(cells, image.info.spacing);
  ASSERT_TRUE(without.add(RigidShape(cells, image.info.spacing, matter), {}).object);
  const std::vector<bool> reachable = reachable_from(without.map(), {0, 0, 0});

  std::mt19937 random(21);
  std::normal_distribution<double> normal;
  int felt = 0;
  for (int path = 0; path < 100'000; ++path) {
    RigidMotion motion;
    const double reach = std::pow(10, -3 + 3.0 * static_cast<double>(random() % 1000) / 1000); // 1 mm to 1 m
    motion.by = reach * Eigen::Vector3d(normal(random), normal(random), normal(random));
    const MoveResult result = path % 2 == 0 ? world.move(finger, motion) : world.slide(finger, motion);
    for (const Contact& contact : result.contacts)
      felt += contact.other != no_voxel;
    const Index3 at = PosedShape(tip, world.pose(finger), world.cell_size()).cell(0);
    ASSERT_TRUE(reachable[static_cast<std::size_t>(at[0] + cells[0] * (at[1] + cells[1] * at[2]))])
        << "in path " << path;
  }
  EXPECT_GT(felt, 1000); // it does come to the skull
}

} // namespace
} // namespace maille::deform
