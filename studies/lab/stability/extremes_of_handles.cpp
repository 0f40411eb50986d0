#include "stability/extremes.hpp"
#include "stability/questions.hpp"

#include <fmt/format.h>

namespace maille::lab {

namespace {

constexpr double length = 8e-3; ///< of the body
constexpr double far = 1000 * length;
constexpr Vec3 h{1e-3, 1e-3, 1e-3};
const std::string held_below = "[[hold]]\nwhere = \"z-\"\n";

Extreme ask(std::string extreme, std::string setting, const Question& question, Truth truth = {}) {
  return {.extreme = std::move(extreme),
          .setting = std::move(setting),
          .scene = [=] { return question.scene(); },
          .truth = std::move(truth)};
}

Extreme normal(std::string extreme, const std::string& limits) {
  Extreme one = ask(std::move(extreme), "normal: poked by half a spacing",
                    {.limits = limits, .conditions = poked(h, 0.5e-3)});
  one.is_normal = true;
  return one;
}

void add_far_handles(std::vector<Extreme>& list) {
  constexpr const char* extreme = "handles 1,000 body lengths away";
  const std::string given = given_limits(1.3, 0.7, 0.3);
  list.push_back(normal(extreme, given));
  list.push_back(ask(extreme, "one node of a free body",
                     {.limits = given, .conditions = moved_node({0, 0, 0}, {far, -far, far})}));
  list.push_back(
      ask(extreme, "one face of a free body",
          {.limits = given, .conditions = fmt::format("[[move]]\nwhere = \"x+\"\nby = [{}, 0, 0]\n", far)},
          shift({far, 0, 0}, true)));
  list.push_back(
      ask(extreme, "one node of a held body",
          {.limits = given, .conditions = held_below + moved_node({4e-3, 4e-3, 8e-3}, {far, 0, far})}));
  list.push_back(ask(extreme, "one node of a held body, taut limits",
                     {.conditions = held_below + moved_node({4e-3, 4e-3, 8e-3}, {far, 0, far})}));
}

void add_opposite_handles(std::vector<Extreme>& list) {
  constexpr const char* extreme = "opposite handles on neighbouring nodes";
  const std::string apart = held_below + moved_node({4e-3, 4e-3, 8e-3}, {length, 0, 0}) +
                            moved_node({5e-3, 4e-3, 8e-3}, {-length, 0, 0});
  list.push_back(normal(extreme, ""));
  list.push_back(ask(extreme, "by a body length, given limits",
                     {.limits = given_limits(1.3, 0.7, 0.3), .conditions = apart}));
  list.push_back(ask(extreme, "by a body length, taut limits", {.conditions = apart}));
  list.push_back(ask(extreme, "by a body length, limits of width 0",
                     {.limits = given_limits(1, 1, 0), .conditions = apart}));
}

void add_contradictions(std::vector<Extreme>& list) {
  constexpr const char* extreme = "contradictory holds";
  const std::string given = given_limits(1.1, 0.9, 0.1);
  list.push_back(normal(extreme, given));
  Extreme both = ask(extreme, "nodes held and moved",
                     {.conditions = held_below + "[[move]]\nwhere = \"z-\"\nby = [0, 0, 0.001]\n"});
  both.must_be_refused = true;
  list.push_back(both);
  Extreme two = ask(extreme, "nodes moved to two places",
                    {.conditions = held_below + "[[move]]\nwhere = \"z+\"\nby = [0, 0, 0.001]\n"
                                                "[[move]]\nwhere = \"z+\"\nby = [0, 0, 0.002]\n"});
  two.must_be_refused = true;
  list.push_back(two);
  list.push_back(ask(extreme, "a face moved farther than its links to the held one reach",
                     {.limits = given, .conditions = clamped("[0.008, 0, 0]")}));
  list.push_back(ask(extreme, "two faces of a free body moved apart farther than links reach",
                     {.limits = given,
                      .conditions = "[[move]]\nwhere = \"x-\"\nby = [-0.008, 0, 0]\n"
                                    "[[move]]\nwhere = \"x+\"\nby = [0.008, 0, 0]\n"}));
}

} // namespace

void add_extremes_of_handles(std::vector<Extreme>& list) {
  add_far_handles(list);
  add_opposite_handles(list);
  add_contradictions(list);
}

} // namespace maille::lab
