/// Small questions whose instructions are counted, one a run: instruction_cases NAME. Without a name: all
/// names.

#include "maille/deform/drag.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/bodies/named_bodies.hpp"

#include <hwy/highway.h>

#include <array>
#include <cstdio>
#include <string>
#include <string_view>

namespace maille {
namespace {

/// What is counted: by its name, which stands in the symbols.
extern "C" __attribute__((noinline)) double counted(const Scene& scene, const char* method) {
  if (std::string_view(method) != "drag") {
    const Answer answer = deform::solve(scene, method);
    return static_cast<double>(answer.iterations);
  }
  const LinkLimits limits(scene);
  deform::Drag drag(scene, limits);
  double visited = 0;
  for (int i = 1; i <= 20; ++i)
    visited += static_cast<double>(drag.move_to(0, {-0.001 * i, 0.0005 * i, 0}).visited);
  return visited;
}

Scene box(int n, const std::string& more) {
  const std::string size = std::to_string(n);
  return parse_scene(
      "[specimen]\nshape = \"box\"\ncells = [" + size + ", " + size + ", " + size +
      "]\nspacing = \"1 mm\"\nmaterial = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n"
      "[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = \"z+\"\nby = [\"0.5 mm\", 0, \"1 mm\"]\n" +
      more);
}

const std::string wide = "[limits]\nfrom = \"given\"\nstretch = 1.5\ncompress = 0.5\nshear = 0.5\n";
const std::string narrow = "[limits]\nfrom = \"given\"\nstretch = 1.15\ncompress = 0.9\nshear = 0.07\n";

struct Case {
  const char* name;
  const char* method;
  Scene (*scene)();
};

const std::array cases{
    Case{"limits_box", "limits", [] { return box(24, wide); }},
    Case{"limits_random", "limits", [] { return named_body("random", 24); }},
    Case{"limits_bore", "limits", [] { return named_body("bore", 24); }},
    Case{"dijkstra_box", "dijkstra", [] { return box(16, wide); }},
    Case{"drag_box", "drag", [] { return box(24, wide); }},
    Case{"sweep_box", "sweep", [] { return box(8, wide); }},
    Case{"relaxed_box", "relaxed", [] { return box(16, wide); }},
    Case{"relaxed_limits", "relaxed", [] { return box(12, narrow); }},
    Case{"coupled_box", "coupled", [] { return box(16, wide); }},
    Case{"coupled_limits", "coupled", [] { return box(12, narrow); }},
};

} // namespace
} // namespace maille

int main(int argc, char** argv) {
  hwy::SetSupportedTargetsForTest(HWY_SSSE3 | HWY_SCALAR | HWY_EMU128); // the same vectors on every machine
  for (const maille::Case& one : maille::cases)
    if (argc < 2)
      std::puts(one.name);
    else if (std::string_view(argv[1]) == one.name)
      return maille::counted(one.scene(), one.method) >= 0 ? 0 : 1;
  return argc < 2 ? 0 : 1;
}
