/// Answers that must not change unnoticed: a digest of every bit of the displacement, scene by scene.
/// A change on purpose is entered in tests/golden/displacements.txt; the failure shows the old and the new
/// line.

#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/kit.hpp"

#include <cstring>

namespace maille {
namespace {

/// FNV-1a over the bytes of all components; -0 counts as 0.
std::uint64_t digest(const Displacement& displacement) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const double value : displacement.values()) {
    const double same = value + 0.0;
    unsigned char bytes[sizeof same];
    std::memcpy(bytes, &same, sizeof same);
    for (const unsigned char byte : bytes)
      hash = (hash ^ byte) * 1099511628211ull;
  }
  return hash;
}

TEST(DisplacementsGolden, AreThoseOfTheLastBlessing) {
  std::ifstream golden(std::filesystem::path(MAILLE_GOLDEN) / "displacements.txt");
  int lines = 0;
  for (std::string line; std::getline(golden, line);) {
    if (line.empty() || line[0] == '#')
      continue;
    std::istringstream words(line);
    std::string scene_name, method, expected;
    words >> scene_name >> method >> expected;
    const Scene scene = read_scene(std::filesystem::path(MAILLE_SCENES) / (scene_name + ".toml"));
    const Answer answer = deform::solve(scene, method);
    std::ostringstream found;
    found << std::hex << digest(answer.displacement);
    EXPECT_EQ(found.str(), expected) << scene_name << " " << method;
    ++lines;
  }
  EXPECT_GE(lines, 4) << "the golden file is there and has entries";
}

} // namespace
} // namespace maille
