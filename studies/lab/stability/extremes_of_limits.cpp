#include "stability/extremes.hpp"
#include "stability/questions.hpp"

#include <fmt/format.h>

namespace maille::lab {

namespace {

constexpr Vec3 h{1e-3, 1e-3, 1e-3};
constexpr double depth = 1e-3;

Question poke_within(std::string limits) {
  return {.limits = std::move(limits), .conditions = poked(h, depth)};
}

Extreme within(const char* extreme, const char* setting, const std::string& limits) {
  return {.extreme = extreme, .setting = setting, .scene = [=] { return poke_within(limits).scene(); }};
}

Extreme normal(const char* extreme) {
  Extreme one = within(extreme, "normal: 0.7 to 1.3, shear 0.3", given_limits(1.3, 0.7, 0.3));
  one.is_normal = true;
  return one;
}

/// One face of a body that nothing holds is shifted.
Extreme shifted(const char* extreme, const char* setting, const std::string& limits) {
  const Vec3 by{3e-3, -2e-3, 1e-3};
  return {.extreme = extreme,
          .setting = setting,
          .scene =
              [=] {
                return Question{.limits = limits,
                                .conditions = fmt::format("[[move]]\nwhere = \"x+\"\nby = [{}, {}, {}]\n",
                                                          by[0], by[1], by[2])}
                    .scene();
              },
          .truth = shift(by, limits != given_limits(1, 1, 0))};
}

void add_min_equals_max(std::vector<Extreme>& list) {
  constexpr const char* extreme = "min = max";
  list.push_back(normal(extreme));
  list.push_back(
      within(extreme, "along z, which is pushed",
             "from = \"given\"\nstretch = [1.3, 1.3, 1]\ncompress = [0.7, 0.7, 1]\nshear = 0.3\n"));
  list.push_back(within(extreme, "along x and y, across the push",
                        "from = \"given\"\nstretch = [1, 1, 1.3]\ncompress = [1, 1, 0.7]\nshear = 0.3\n"));
  list.push_back(within(extreme, "along every axis, shear free", given_limits(1, 1, 0.3)));
}

void add_widths(std::vector<Extreme>& list) {
  list.push_back(normal("zero shear"));
  list.push_back(within("zero shear", "0.7 to 1.3", given_limits(1.3, 0.7, 0)));
  list.push_back(
      shifted("zero shear", "0.7 to 1.3, one face of a free body shifted", given_limits(1.3, 0.7, 0)));

  list.push_back(normal("limits of width 0"));
  Extreme rigid = within("limits of width 0", "poked", given_limits(1, 1, 0));
  list.push_back(rigid); // cut back to nothing: only finite elements and literal move
  list.push_back(shifted("limits of width 0", "one face of a free body shifted", given_limits(1, 1, 0)));

  list.push_back(normal("limits 1e-6 wide"));
  list.push_back(within("limits 1e-6 wide", "poked", given_limits(1 + 1e-6, 1 - 1e-6, 1e-6)));
  list.push_back(normal("limits 1e6 wide"));
  list.push_back(within("limits 1e6 wide", "poked", given_limits(1e6, 0, 1e6)));
}

} // namespace

void add_extremes_of_limits(std::vector<Extreme>& list) {
  add_min_equals_max(list);
  add_widths(list);
}

} // namespace maille::lab
