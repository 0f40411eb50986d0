#include "study/sensitivity/sensitivity.hpp"

#include "study/plan/sampling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace maille::studies {

double sobol_error_of_ishigami() {
  constexpr double a = 7, b = 0.1, pi = std::numbers::pi;
  constexpr int n_samples = 512;
  SampledValues samples;
  samples.axes.resize(3);
  for (const std::vector<double>& unit : latin_hypercube(n_samples, 3, 1)) {
    std::vector<double>& point = samples.points.emplace_back();
    for (const double u : unit)
      point.push_back(2 * u - 1);
    samples.values.emplace_back(std::sin(pi * point[0]) + a * std::pow(std::sin(pi * point[1]), 2) +
                                b * std::pow(pi * point[2], 4) * std::sin(pi * point[0]));
  }
  const double of_first = 0.5 * std::pow(1 + b * std::pow(pi, 4) / 5, 2), of_second = a * a / 8;
  const double of_both = 8 * b * b * std::pow(pi, 8) / 225; // the first with the third
  const double all = of_first + of_second + of_both;
  const std::array<double, 3> first{of_first / all, of_second / all, 0},
      total{(of_first + of_both) / all, of_second / all, of_both / all};
  const Sensitivity found = sobol_by_chaos(samples);
  double error = 0;
  for (std::size_t i = 0; i < 3; ++i)
    error = std::max({error, std::abs(found.first[i].value.value_or(INFINITY) - first[i]),
                      std::abs(found.total[i].value.value_or(INFINITY) - total[i])});
  return error;
}

} // namespace maille::studies
