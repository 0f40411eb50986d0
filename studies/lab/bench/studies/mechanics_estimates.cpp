#include "bench/studies/mechanics_promises.hpp"

#include "bench/studies/studies.hpp"
#include "compare/methods.hpp"
#include "maille/deform/estimated_error.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "median.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <random>
#include <string_view>
#include <utility>

namespace maille::lab {

namespace {

constexpr std::uint32_t seed = 20270114;
constexpr int n_scenes = 50, n_quick = 5, every_so_many_is_a_strip = 5;
constexpr double factor = 2, most_reference_seconds = 4;
constexpr std::array<std::string_view, 2> methods{"relaxed", "coupled"};

struct Part {
  const char* name;
  std::optional<double> MechanicsErrors::*error;
};
constexpr std::array<Part, 4> parts{{{"force", &MechanicsErrors::force},
                                     {"energy", &MechanicsErrors::strain_energy},
                                     {"strain", &MechanicsErrors::strain},
                                     {"stress", &MechanicsErrors::stress}}};

/// Slender boxes of cells of 1 mm, with fibres along them, nearly.
DrawnScene draw_strip(std::mt19937& lot, int number) {
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(lot()) / 4294967296.0;
  };
  const auto even = [&](int low, int high) {
    return 2 * static_cast<int>(between(low / 2.0, high / 2.0 + 1));
  };
  constexpr std::array<std::string_view, 4> matter{"\"muscle/vastus_lateralis\"", "\"muscle/soleus\"",
                                                   "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.45 }",
                                                   "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.49 }"};
  const int length = even(20, 30), width = even(6, 8), height = even(4, 6);
  const std::string_view material = matter[lot() % matter.size()];
  const bool is_bent = lot() % 2 == 0;
  const double by = 1e-3 * length * between(0.02, 0.1);
  DrawnScene drawn;
  drawn.name = fmt::format("{}: strip {} x {} x {}, {}, {}", number, length, width, height,
                           is_bent ? "bend" : "pull", material);
  drawn.text = fmt::format(
      "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [{}, {}, {}]\nspacing = \"1 mm\"\nmaterial = "
      "{}\n"
      "fibre = {{ angle = \"{:.4g} deg\", plane = \"xz\" }}\n[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = "
      "\"x+\"\nby = [{:.6g}, 0, {:.6g}]\n",
      length, width, height, material, between(0, 20), is_bent ? 0 : by, is_bent ? by : 0);
  return drawn;
}

std::vector<DrawnScene> draw(int n) {
  std::mt19937 lot(seed);
  std::vector<DrawnScene> scenes = draw_scenes(n, seed);
  for (int i = every_so_many_is_a_strip - 1; i < n; i += every_so_many_is_a_strip)
    scenes[static_cast<std::size_t>(i)] = draw_strip(lot, i);
  return scenes;
}

/// What was found out about one figure of one method.
struct Tally {
  int answers = 0, within = 0;
  std::vector<double> ratios; ///< estimated over true
};

class MechanicsEstimates {
public:
  explicit MechanicsEstimates(BenchReport& report) : report_(report) { control_.threads = 1; }

  void ask(const DrawnScene& drawn) {
    const Scene scene = parse_scene(drawn.text, "drawn.toml");
    const auto truth = true_mechanics(scene, control_);
    if (!truth) {
      report_.notes.push_back(drawn.name + ": finite elements have no answer; not counted");
      return;
    }
    for (std::size_t i = 0; i < methods.size(); ++i) {
      const Answer answer = answer_by(scene, methods[i], control_);
      if (is_converged(answer.status))
        judge(drawn, scene, i, answer, *truth);
      else
        report_.notes.push_back(fmt::format("{}, {}: {}", drawn.name, methods[i], answer.message));
    }
  }

  std::vector<BenchCheck> conclude() {
    for (std::size_t i = 0; i < methods.size(); ++i)
      for (std::size_t k = 0; k < parts.size(); ++k) {
        Tally& tally = tallies_[i][k];
        const auto [least, most] = std::ranges::minmax_element(tally.ratios);
        report_.rows.push_back({{"method", methods[i]},
                                {"error of", parts[k].name},
                                {"answers", tally.answers},
                                {"within a factor of 2", tally.within},
                                {"least ratio", tally.ratios.empty() ? 0 : *least},
                                {"median ratio", upper_median(tally.ratios)},
                                {"largest ratio", tally.ratios.empty() ? 0 : *most}});
      }
    return {check("estimate_reliability_force", 0), check("estimate_reliability_stress", 3)};
  }

private:
  void judge(const DrawnScene& drawn, const Scene& scene, std::size_t method, const Answer& answer,
             const Answer& truth) {
    const MechanicsErrors errors = compare_mechanics(scene, answer, truth);
    const deform::ErrorEstimation found = deform::estimate_error(scene, answer, control_);
    const MechanicsErrors estimated = found.estimate ? found.estimate->mechanics : MechanicsErrors{};
    nlohmann::ordered_json row{{"mechanics of", drawn.name}, {"method", methods[method]}};
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const auto& error = errors.*parts[k].error;
      if (!error)
        continue;
      Tally& tally = tallies_[method][k];
      ++tally.answers;
      const auto& estimate = estimated.*parts[k].error;
      row[fmt::format("{}_error", parts[k].name)] = *error;
      if (!estimate)
        continue;
      const double ratio = *estimate / *error;
      tally.within += ratio >= 1 / factor && ratio <= factor ? 1 : 0;
      tally.ratios.push_back(ratio);
      row[fmt::format("{}_ratio", parts[k].name)] = ratio;
    }
    if (found.estimate)
      row["other_lattice"] = deform::to_string(found.estimate->lattice);
    else
      report_.notes.push_back(
          fmt::format("{}, {}: no estimate: {}", drawn.name, methods[method], found.reason));
    report_.rows.push_back(std::move(row));
  }

  BenchCheck check(const char* name, std::size_t part) const {
    int answers = 0, within = 0;
    for (const auto& of_method : tallies_) {
      answers += of_method[part].answers;
      within += of_method[part].within;
    }
    return {name, static_cast<double>(within) / std::max(answers, 1)};
  }

  BenchReport& report_;
  Control control_;
  std::array<std::array<Tally, parts.size()>, methods.size()> tallies_;
};

} // namespace

std::optional<Answer> true_mechanics(const Scene& scene, const Control& control) {
  const Scene fine = refined(scene);
  fem_ref::Options options;
  options.degree = 2;
  const bool is_quick = fem_ref::estimate(fine, options).seconds <= most_reference_seconds;
  Answer answer = answer_by(is_quick ? fine : scene, "fem_q2", control);
  if (!is_converged(answer.status))
    return std::nullopt;
  if (is_quick)
    bring_to_coarse(scene, fine, answer);
  return answer;
}

std::vector<BenchCheck> mechanics_estimate_checks(const BenchOptions& options, const Control& control,
                                                  BenchReport& report) {
  MechanicsEstimates estimates(report);
  const std::vector<DrawnScene> scenes = draw(options.quick ? n_quick : n_scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (!goes_on(control, static_cast<double>(i) / static_cast<double>(scenes.size()),
                 "estimates of force and stress, " + scenes[i].name))
      break;
    estimates.ask(scenes[i]);
  }
  return estimates.conclude();
}

} // namespace maille::lab
