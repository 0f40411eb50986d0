#include "stability/extremes.hpp"
#include "stability/questions.hpp"

#include <fmt/format.h>

namespace maille::lab {

namespace {

constexpr double nu = 0.3, strain = 0.01;
constexpr int n = 6;

/// A pulled cube whose numbers are of any size; the strain is the same.
Extreme pull(const char* extreme, std::string setting, double spacing, double modulus) {
  return {.extreme = extreme,
          .setting = std::move(setting),
          .scene =
              [=] {
                return Question{.cells = "[6, 6, 6]",
                                .spacing = fmt::format("{}", spacing),
                                .material =
                                    fmt::format("{{ youngs_modulus = {}, poisson_ratio = {} }}", modulus, nu),
                                .conditions = pulled(3, 0, strain * n * spacing)}
                    .scene();
              },
          .truth = uniform_strain({strain, -nu * strain, -nu * strain}, 0),
          .is_normal = spacing == 1e-3 && modulus == 10e3};
}

/// A cube of 6 mm that is pulled by any amount.
Extreme pull_by(const char* extreme, double by) {
  const double e = by / (n * 1e-3);
  return {.extreme = extreme,
          .setting = fmt::format("moved by {:g} m", by),
          .scene = [=] { return Question{.cells = "[6, 6, 6]", .conditions = pulled(3, 0, by)}.scene(); },
          .truth = uniform_strain({e, -nu * e, -nu * e}, 0)};
}

Extreme ask(const char* extreme, std::string setting, const Question& question) {
  return {.extreme = extreme, .setting = std::move(setting), .scene = [=] { return question.scene(); }};
}

} // namespace

void add_extremes_of_numbers(std::vector<Extreme>& list) {
  constexpr const char* ends = "values near float32's ends";
  list.push_back(pull(ends, "normal: millimetres, 10 kPa", 1e-3, 10e3));
  for (const double spacing : {1e-38, 3e37}) // the body is six of them
    list.push_back(pull(ends, fmt::format("spacing {:g} m", spacing), spacing, 10e3));
  for (const double modulus : {1e-38, 3e38})
    list.push_back(pull(ends, fmt::format("E = {:g} Pa", modulus), 1e-3, modulus));
  for (const double by : {1e-38, 3e38})
    list.push_back(pull_by(ends, by));
  list.push_back(ask(ends, "limits 3e38 wide",
                     {.limits = given_limits(3e38, 0, 3e38), .conditions = poked({1e-3, 1e-3, 1e-3}, 1e-3)}));
  list.push_back(ask(ends, "a free body shifted by 3e38 m",
                     {.limits = given_limits(1.3, 0.7, 0.3),
                      .conditions = "[[move]]\nwhere = \"x+\"\nby = [3e38, 0, 0]\n"}));
  list.push_back(ask(ends, "gravity 3e38 m/s^2",
                     {.conditions = "[[hold]]\nwhere = \"z-\"\n[[load]]\ngravity = [0, 0, -3e38]\n"}));

  constexpr const char* denormals = "denormals";
  list.push_back(pull(denormals, "normal: millimetres, 10 kPa", 1e-3, 10e3));
  for (const double by : {1e-40, 1e-310}) // of float32, of float64
    list.push_back(pull_by(denormals, by));
  for (const double spacing : {1e-40, 1e-310})
    list.push_back(pull(denormals, fmt::format("spacing {:g} m", spacing), spacing, 10e3));
  for (const double modulus : {1e-40, 1e-310})
    list.push_back(pull(denormals, fmt::format("E = {:g} Pa", modulus), 1e-3, modulus));
}

} // namespace maille::lab
