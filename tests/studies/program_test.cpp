#include "program.hpp"

#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace maille::studies {
namespace {

// The shell itself reads the words.
TEST(ProgramIndependent, AShellReadsAWordAsItIs) {
  const test::TemporaryFolder folder;
  for (const std::string text :
       {"", "plain", "two words", "it's", "'", "\"$HOME\" `id` \\ %d", "a\nb", "*;&|<>"}) {
    const auto file = folder / "it's here";
    ASSERT_EQ(std::system(("printf %s " + shell_word(text) + " > " + shell_word(file.string())).c_str()), 0);
    EXPECT_EQ(test::text_of(file), text);
  }
}

TEST(ProgramContract, ProgramsAreFoundByTheirNamesAlone) {
  EXPECT_TRUE(has_program("sh"));
  EXPECT_FALSE(has_program("maille-no-such-program"));
  EXPECT_FALSE(has_program("sh; true"));
}

} // namespace
} // namespace maille::studies
