#include "stability/extremes.hpp"
#include "stability/questions.hpp"

#include <fmt/format.h>

namespace maille::lab {

namespace {

/// Both ends turned about one axis: nothing is deformed.
std::string both_ends_turned(int angle) {
  std::string text;
  for (const char* end : {"x-", "x+"})
    text += fmt::format("[[move]]\nwhere = \"{}\"\nturn = {{ angle = \"{} deg\", axis = [1, 2, 3], "
                        "about = [0.003, 0.002, 0.002] }}\n",
                        end, angle);
  return text;
}

/// Held at one end, the other turned about the bar's axis.
std::string twisted(int angle) {
  return fmt::format("[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\n"
                     "turn = {{ angle = \"{} deg\", axis = [1, 0, 0] }}\n",
                     angle);
}

} // namespace

void add_extremes_of_turns(std::vector<Extreme>& list) {
  for (int angle = 0; angle <= 720; angle += 90)
    list.push_back({.extreme = "rotation of both ends of a free body",
                    .setting = angle == 0 ? "normal: 1 deg" : fmt::format("{} deg", angle),
                    .scene =
                        [=] {
                          return Question{.cells = "[6, 4, 4]",
                                          .conditions = both_ends_turned(angle == 0 ? 1 : angle)}
                              .scene();
                        },
                    .truth = rigid_turn(),
                    .is_normal = angle == 0,
                    .is_for_lattice = true});
  for (int angle = 0; angle <= 720; angle += 90)
    list.push_back({.extreme = "a bar twisted, frame = \"blocks\"",
                    .setting = angle == 0 ? "normal: 1 deg" : fmt::format("{} deg", angle),
                    .scene =
                        [=] {
                          return Question{.cells = "[16, 4, 4]",
                                          .conditions = twisted(angle == 0 ? 1 : angle),
                                          .relaxation = "frame = \"blocks\"\n"}
                              .scene();
                        },
                    .is_normal = angle == 0});
}

} // namespace maille::lab
