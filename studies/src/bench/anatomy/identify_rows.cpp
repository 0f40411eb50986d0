// Constants from measured numbers: how near, how sure, at how many solves.
#include "bench/anatomy/anatomy.hpp"

#include "maille/deform/solve.hpp"
#include "maille/scene/scene_builder.hpp"
#include "maille/studies/identify.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace maille::studies {

namespace {

constexpr std::array<double, 2> truth{30e3, 9e3}; ///< Young's modulus along the fibre, shear modulus [Pa]

Scene strip(const std::vector<double>& values) {
  Material muscle;
  muscle.name = "muscle";
  muscle.elasticity = ElasticConstants::transversely_isotropic(values[0], 12e3, values[1], 0.3, 0.4);
  return SceneBuilder("strip")
      .box(3, {8, 3, 3}, {1e-3, 1e-3, 1e-3})
      .material(muscle)
      .hold("x-")
      .move("x+", {4e-4, 0, 2e-4})
      .build();
}

/// Forces on the moved end, and how far its middle plane goes.
std::optional<std::vector<double>> measured(const std::vector<double>& values) {
  Scene scene = strip(values);
  scene.relaxation.tolerance = 1e-8;
  const Answer answer = deform::solve(scene, Method::coupled, {});
  if (answer.status != Status::done)
    return std::nullopt;
  std::vector<double> numbers(3, 0);
  for (std::size_t i = 0; i < answer.reaction.size(); ++i)
    if (!scene.prescribed[i].held && scene.prescribed[i].component != 1)
      numbers[scene.prescribed[i].component == 0 ? 0 : 1] += answer.reaction[i];
  numbers[2] = answer.displacement(2, scene.specimen.grid.node({4, 1, 1}));
  return numbers;
}

std::vector<Observation> observations(const std::vector<double>& values, double noise) {
  std::vector<Observation> all;
  const char* const names[]{"pull_x", "pull_z", "sag"};
  for (std::size_t i = 0; i < values.size(); ++i)
    all.push_back(
        {names[i], values[i], noise > 0 ? std::optional(noise * std::abs(values[i])) : std::nullopt, 0});
  return all;
}

} // namespace

std::vector<BenchCheck> bench_identify(const BenchOptions& options, BenchReport& report) {
  const std::vector<Unknown> start{{"E_fibre", 12e3}, {"G_fibre", 20e3}};
  const std::vector<double> exact = *measured({truth.begin(), truth.end()});
  const Identification found = identify(start, observations(exact, 0), measured);
  double error = 0;
  for (std::size_t k = 0; k < truth.size(); ++k)
    error = std::max(error, std::abs(found.unknowns[k].value / truth[k] - 1));
  int solves = found.solves;
  report.add({{"case", "constants without noise"}, {"error", error}, {"solves", found.solves}});

  constexpr double noise = 0.02;
  const int sets = options.quick ? 10 : 100;
  std::mt19937_64 dice(20031); // the same data in every run
  std::normal_distribution<double> normal;
  int covered = 0, intervals = 0;
  for (int set = 0; set < sets; ++set) {
    if (!goes_on(report.control, static_cast<double>(set) / sets, "finding constants"))
      throw BenchStopped();
    std::vector<double> noisy = exact;
    std::vector<Observation> data = observations(exact, noise);
    for (Observation& number : data)
      number.value *= 1 + noise * normal(dice);
    const Identification of_set = identify(start, data, measured);
    solves = std::max(solves, of_set.solves);
    for (std::size_t k = 0; k < truth.size(); ++k)
      if (const auto& interval = of_set.unknowns[k].interval) {
        ++intervals;
        covered += interval->first <= truth[k] && truth[k] <= interval->second ? 1 : 0;
      }
  }
  const double coverage = intervals > 0 ? static_cast<double>(covered) / (2 * sets) : 0,
               per_unknown = solves / static_cast<double>(truth.size());
  report.add({{"case", "constants with noise of 2 %"},
              {"data_sets", sets},
              {"intervals", intervals},
              {"covered", covered},
              {"most_solves", solves}});
  return {{"identify_error_noiseless", error, 0.01, false},
          {"identify_coverage", coverage, 0.93},
          {"solves_per_identified_parameter", per_unknown, 12, false}};
}

} // namespace maille::studies
