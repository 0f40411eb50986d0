/// Several processes as a user starts them: the same files as by one.

#include "studies/commands/run_command.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <tuple>
#include <utility>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;

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
  ASSERT_FALSE(test::text_of(folder / "alone" / file).empty());
  EXPECT_TRUE(test::text_of(folder / "alone" / file) == test::text_of(folder / "together" / file));
  const json one = json::parse(alone.out)["results"][0], two = json::parse(together.out)["results"][0];
  EXPECT_EQ(one.at("iterations").get<int>(), two.at("iterations").get<int>());
  EXPECT_EQ(one.at("strain_energy").get<double>(), two.at("strain_energy").get<double>());
}

// Each pair is what ranks 0 and 1 are asked; files that lag on a shared disk, scripts that differ.
TEST(RanksContract, RanksThatDifferEndWithTheDifferenceNamed) {
  if (test::shell("command -v mpirun").code != 0)
    GTEST_SKIP() << "mpirun is not installed";
  const test::TemporaryFolder folder;
  for (const auto& [name, modulus] : {std::pair{"a", "10 kPa"}, {"b", "20 kPa"}})
    folder.write(std::string(name) + ".toml",
                 std::string("[specimen]\nshape = \"box\"\ncells = [4, 3, 3]\nspacing = \"1 mm\"\n"
                             "material = { youngs_modulus = \"") +
                     modulus +
                     "\", poisson_ratio = 0.3 }\n[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = "
                     "\"x+\"\nby = [\"0.1 mm\", 0, 0]\n");
  const std::string maille = "exec " + std::string(MAILLE_COMMAND), at = (folder / "").string();
  for (const auto& [first, second, word] :
       {std::tuple{" run " + at + "a.toml", " run " + at + "b.toml", "scene"},
        {" run " + at + "a.toml", " run " + at + "none.toml", "none.toml"},
        {" run " + at + "none.toml", " run " + at + "a.toml", "none.toml"},
        {" run " + at + "a.toml", " check " + at + "a.toml", "command"},
        {" run " + at + "a.toml", " run " + at + "a.toml --steps 2", "options"}}) {
    folder.write("ranks.sh", "[ $OMPI_COMM_WORLD_RANK = 0 ] && " + maille + first + "\n" + maille + second);
    const auto run =
        test::shell("OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 timeout 60 mpirun "
                    "--oversubscribe -n 2 sh " +
                    at + "ranks.sh");
    EXPECT_EQ(run.code, 2) << first << second << "\n124: it did not end\n" << run.err;
    EXPECT_NE(run.err.find(word), std::string::npos) << run.err;
  }
}

} // namespace
} // namespace maille
