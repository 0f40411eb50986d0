/// Several processes as a user starts them: the same files as by one.

#include "studies/commands/run_command.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;

std::string bytes_of_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The reference is what one process writes.
TEST(RanksCommandContract, CoupledWritesTheSameFileByTwoProcesses) {
  if (test::shell("command -v mpirun").code != 0)
    GTEST_SKIP() << "mpirun is not installed";
  const test::TemporaryFolder folder;
  const std::string line = std::string(" run ") + MAILLE_SCENES +
                           "/muscle_belly.toml --methods coupled --threads 1 --json - --out ";
  const auto alone = maille_command(line + (folder / "alone").string());
  ASSERT_EQ(alone.code, 0) << alone.err;
  const auto together =
      test::shell("OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun --oversubscribe -n 2 " +
                  std::string(MAILLE_COMMAND) + line + (folder / "together").string());
  ASSERT_EQ(together.code, 0) << together.err;
  const std::string file = "muscle_belly_coupled_0001.vtu";
  ASSERT_FALSE(bytes_of_file(folder / "alone" / file).empty());
  EXPECT_TRUE(bytes_of_file(folder / "alone" / file) == bytes_of_file(folder / "together" / file));
  const json one = json::parse(alone.out)["results"][0], two = json::parse(together.out)["results"][0];
  EXPECT_EQ(one.at("iterations").get<int>(), two.at("iterations").get<int>());
  EXPECT_EQ(one.at("strain_energy").get<double>(), two.at("strain_energy").get<double>());
}

} // namespace
} // namespace maille
