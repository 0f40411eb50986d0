/// Small files that claim much: the memory of a command follows the size of the file.

#include "support/kit.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace maille {
namespace {

struct Taken {
  int code = 0;
  double megabytes = 0, seconds = 0; ///< seconds of processor
};

Taken taken_by(const std::string& arguments, const std::filesystem::path& folder) {
  const std::string line = fmt::format("cd {} && exec {} {}", folder.string(), MAILLE_COMMAND, arguments);
  const pid_t child = fork();
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    _exit(126);
  }
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), double(usage.ru_maxrss) / 1024,
          double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec)};
}

std::string repeated(int n, const std::function<std::string(int)>& part) {
  std::string all;
  for (int i = 0; i < n; ++i)
    all += part(i);
  return all;
}

/// `n` coincident boxes of 2 x 1000 x 1000.
std::string shells(int n) {
  constexpr std::array<std::array<int, 3>, 12> faces{{{0, 2, 3},
                                                      {0, 3, 1},
                                                      {4, 5, 7},
                                                      {4, 7, 6},
                                                      {0, 1, 5},
                                                      {0, 5, 4},
                                                      {2, 6, 7},
                                                      {2, 7, 3},
                                                      {0, 4, 6},
                                                      {0, 6, 2},
                                                      {1, 3, 7},
                                                      {1, 7, 5}}};
  std::string stl(80, ' ');
  stl += test::raw_bytes(std::uint32_t(12 * n));
  for (int shell = 0; shell < n; ++shell)
    for (const auto& face : faces) {
      stl.append(12, '\0');
      for (const int corner : face)
        for (const float x :
             {corner & 1 ? 2.0F : 0.0F, corner & 2 ? 1000.0F : 0.0F, corner & 4 ? 1000.0F : 0.0F})
          stl += test::raw_bytes(x);
      stl.append(2, '\0');
    }
  return stl;
}

const std::string box =
    test::box_text("[4, 4, 4]") + test::hold_text("z-") + test::move_text("[0, 0, \"0.2 mm\"]", "z+");

class HostileFilesContract : public testing::Test {
protected:
  /// Checks `check NAMES`, of which the last is the file that asks for much.
  void expect_bounded(const std::string& names, const std::string& hostile) {
    const Taken usual = taken_by("check box.toml", folder_.path()),
                taken = taken_by("check " + names, folder_.path());
    const double size = double(std::filesystem::file_size(folder_.path() / hostile)) / (1 << 20);
    EXPECT_LT(taken.code, 3) << hostile;
    EXPECT_LE(taken.megabytes, usual.megabytes + 64 + 40 * size) << hostile << " of " << size << " MB";
    EXPECT_LE(taken.seconds, 20) << hostile;
    RecordProperty(hostile, fmt::format("{:.0f} MB, {:.0f} s", taken.megabytes, taken.seconds));
    fmt::print("{}: {:.2f} MB of file, {:.0f} MB (usual {:.0f}), {:.0f} s, code {}\n", hostile, size,
               taken.megabytes, usual.megabytes, taken.seconds, taken.code);
  }
  HostileFilesContract() { folder_.write("box.toml", box); }
  test::TemporaryFolder folder_;
};

TEST_F(HostileFilesContract, MemoryFollowsTheFile) {
  folder_.write("m.stl", shells(79));
  std::string scene = box;
  scene.replace(scene.find("shape"), scene.find("material") - scene.find("shape"),
                "shape = \"surface\"\nsurface = \"m.stl\"\nspacing = \"1 mm\"\n");
  folder_.write("shells.toml", scene);
  expect_bounded("shells.toml", "m.stl");
  folder_.write("world.toml", test::world_text("[20, 16, 16]") +
                                  test::object_text("soft", "deformable", "[10, 10, 10]",
                                                    "material = " + test::soft +
                                                        "\nhold = [{ where = \"x-\" }]\n"
                                                        "position = [\"2 mm\", \"3 mm\", \"3 mm\"]\n"));
  folder_.write("rows.csv",
                "frame,object,nodes,dx [mm]\n" + repeated(200'000, [](int) { return "1,soft,0-1330,0\n"; }));
  expect_bounded("world.toml rows.csv", "rows.csv");
  folder_.write("drives.toml", repeated(60'000, [](int) {
                  return "[[drive]]\nobject = \"soft\"\nwhere = \"not x-\"\nby = [\"1 mm\", 0, 0]\n";
                }));
  expect_bounded("world.toml drives.toml", "drives.toml");
  folder_.write("measures.toml",
                box + repeated(20'000, [](int i) {
                  return test::measure_text(
                      fmt::format("m{}", i),
                      "displacement = { along = [[0, 0, 0], [0.001, 0, 0]], points = 1000 }");
                }));
  expect_bounded("measures.toml", "measures.toml");
  folder_.write("keys.toml", box + repeated(100'000, [](int i) { return fmt::format("k{} = 1\n", i); }));
  expect_bounded("keys.toml", "keys.toml");
}

} // namespace
} // namespace maille
