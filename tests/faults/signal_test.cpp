/// Ctrl-C (SIGINT) in the middle of the work, also sent before the work has begun: the exit code says so and what is there is whole.

#include "writing_commands.hpp"

namespace maille {
namespace {

using test::CommandFolder;
using test::Files;
using test::files_in;
using test::Outcome;
using test::WritingCommand;

class InterruptContract : public testing::TestWithParam<WritingCommand> {};

/// Sweeps over these cells would take minutes.
const std::string slow_end =
    "[relaxation]\ntolerance = 1e-12\n[limits]\nfrom = \"given\"\nstretch = 2\ncompress = 0.1\nshear = 1\n";

TEST_P(InterruptContract, EndsSoonWithWholeFilesAndItsExitCode) {
  const CommandFolder folder;
  folder.folder().write("in/slow.toml", CommandFolder::box("[\"2 mm\", 0, 0]", "[60, 60, 60]") + slow_end);
  folder.folder().write("in/slower.toml", CommandFolder::box("[\"1 mm\", 0, 0]", "[60, 60, 60]") + slow_end);
  folder.folder().write("in/slow_study.toml",
                        "scene = \"slow.toml\"\nmethods = [\"sweep\"]\nreference = \"none\"\n");
  const Files before{{"earlier.json", "{}"}};
  folder.folder().write("out/earlier.json", "{}");
  for (const char* const seconds :
       {"0.05", "4"}) { // while libraries are loaded; in the work, on a busy machine too
    const Outcome run =
        folder.run(GetParam().arguments, fmt::format("timeout --preserve-status -s INT -k 60 {}", seconds));
    EXPECT_TRUE(run.code == 1 || run.code == 128 + 2) << seconds << " s: " << run.code << run.err;
    for (const auto& [name, text] : files_in(folder.out()))
      EXPECT_TRUE(test::is_whole(name, text, text)) << seconds << " s: " << name;
    EXPECT_EQ(test::text_of(folder.out() / "earlier.json"), "{}");
  }
}

INSTANTIATE_TEST_SUITE_P(
    Commands, InterruptContract,
    testing::Values(
        WritingCommand{"run", "run IN/slow.toml --methods sweep --out OUT --json OUT/r.json"},
        WritingCommand{"compare", "compare IN/slow.toml --methods sweep --reference sweep --out OUT"},
        WritingCommand{"study", "study IN/slow_study.toml --resume --out OUT"},
        WritingCommand{"trade", "trade IN/slow.toml --methods sweep --spacings 1 --tolerances 0.0001 "
                                "--reference sweep --out OUT"},
        WritingCommand{"fit", "fit IN/slow.toml --test IN/slower.toml --reference sweep --out OUT/m.toml"},
        WritingCommand{"bench", "bench propagate --json OUT/b.json"}),
    [](const auto& one) { return one.param.name; });

} // namespace
} // namespace maille
