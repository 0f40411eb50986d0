#include "cli/commands.hpp"
#include "cli/inputs.hpp"

#include "compare/methods.hpp"
#include "export/whole_file.hpp"
#include "fit/fit.hpp"
#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <random>

namespace maille::studies {

namespace {

/// The scenes of a family: those to fit to come first.
struct Family {
  std::vector<std::filesystem::path> fitted, held_out;
};

/// A pseudo-random part of the scenes, the same in every run: neighbours on a command line are alike.
Family draw_lots(std::vector<std::filesystem::path> scenes, double fraction) {
  const auto n = static_cast<double>(scenes.size());
  const auto out = static_cast<std::size_t>(std::clamp(std::round(fraction * n), 1.0, n - 1));
  std::vector<std::size_t> order(scenes.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    order[i] = i;
  std::mt19937 lot(1); // its numbers are the same everywhere, those of std::shuffle are not
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[lot() % i]);
  std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(out));
  std::sort(order.begin() + static_cast<std::ptrdiff_t>(out), order.end());
  Family family;
  for (std::size_t i = 0; i < order.size(); ++i)
    (i < out ? family.held_out : family.fitted).push_back(scenes[order[i]]);
  return family;
}

Family family_of(const FitOptions& options) {
  auto all = options.scenes;
  all.insert(all.end(), options.tests.begin(), options.tests.end());
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (std::filesystem::weakly_canonical(all[i]) == std::filesystem::weakly_canonical(all[j]))
        throw UsageError(fmt::format("{}: expected every scene once, found it twice", all[i].string()));
  if (!options.tests.empty()) {
    if (options.holdout)
      throw UsageError("--holdout and --test: expected one of them, found both");
    return {options.scenes, options.tests};
  }
  if (options.holdout.value_or(0) == 0)
    return {options.scenes, {}};
  if (options.scenes.size() < 2)
    throw UsageError(
        "SCENE: expected at least two scenes with --holdout, one to fit to and one to measure on, found one");
  return draw_lots(options.scenes, *options.holdout);
}

[[noreturn]] void wrong(const Scene& scene, const std::string& expected, const std::string& found) {
  throw UsageError(fmt::format("{}: expected {}, found {}", scene.name, expected, found));
}

/// What a fit can do nothing with.
void check_scene(const Scene& scene, const Scene& first, const FitOptions& options) {
  if (scene.dimension() != first.dimension())
    wrong(scene, fmt::format("the dimension of {}, {}", first.name, first.dimension()),
          fmt::format("{}", scene.dimension()));
  if (scene.has_loads() && options.method == "limits")
    wrong(scene, "moves alone: limits carry no loads", "a load");
  if (scene.contracts())
    wrong(scene, "fibres that do not pull: relaxed carries no contraction", "a contraction");
}

/// A name means the same matter in all scenes, and what is measured on was fitted.
void check_materials(const std::vector<Scene>& fitted, const std::vector<Scene>& held_out) {
  std::map<std::string, const Material*> known;
  const auto check = [&](const Scene& scene, bool is_fitted) {
    for (const Material& material : scene.materials) {
      const auto same = known.find(material.name);
      if (same == known.end() && !is_fitted)
        wrong(scene, "materials that scenes to fit to have, too", material.name);
      if (same == known.end())
        known.emplace(material.name, &material);
      else if (stiffness(same->second->elasticity) != stiffness(material.elasticity))
        wrong(scene,
              fmt::format("the constants that {} has in the other scenes, or another name", material.name),
              "others");
    }
  };
  for (const Scene& scene : fitted)
    check(scene, true);
  for (const Scene& scene : held_out)
    check(scene, false);
}

/// The reference's answer, once a scene.
class References {
public:
  References(const FitOptions& options, const Control& control)
      : options_(options), control_(control), methods_(check_fem_solver(options.fem_solver)) {}

  /// @throws std::runtime_error where the reference has no answer
  FitCase operator()(const Scene& scene) {
    Control control = control_;
    if (control.progress)
      control.progress = [this, &scene](double part, std::string_view what) {
        control_.progress(part, fmt::format("{} of {}: {}", options_.reference, scene.name, what));
      };
    Answer answer = options_.reference == "best"
                        ? best_reference(scene, options_.reference_seconds, control, methods_).answer
                        : methods_.answer(scene, options_.reference, control);
    if (!is_converged(answer.status))
      throw std::runtime_error(fmt::format("{}: the reference {} ended {}{}{}", scene.name,
                                           options_.reference, to_string(answer.status),
                                           answer.message.empty() ? "" : ": ", answer.message));
    FitCase one{scene, std::move(answer.displacement)};
    if (compare(scene, Displacement(scene.specimen.grid), one.reference).rms == 0)
      throw UsageError(
          fmt::format("{}: expected a scene in which nodes are free and move, found none", scene.name));
    return one;
  }

private:
  const FitOptions& options_;
  const Control& control_;
  Methods methods_;
};

std::vector<Scene> read_all(const std::vector<std::filesystem::path>& files) {
  std::vector<Scene> scenes;
  for (const auto& file : files)
    scenes.push_back(read_scene(file));
  return scenes;
}

/// What stands in the place of the fitted material must be one, too: any scene ends in .toml.
void check_is_fitted_or_new(const std::optional<std::string>& file) {
  if (!file || !std::filesystem::is_regular_file(*file))
    return;
  std::ifstream stream(*file);
  std::string line;
  bool is_empty = true, is_fitted = false; // of several materials, each says so below its name
  while (!is_fitted && std::getline(stream, line)) {
    is_empty = false;
    is_fitted = line.starts_with("# Made by maille fit");
  }
  if (!is_empty && !is_fitted)
    throw UsageError(fmt::format("--out {}: expected a new file, or one that fit has written, "
                                 "found another",
                                 *file));
}

void check_options(const FitOptions& options) {
  if (options.method != "limits" && options.method != "relaxed")
    throw UsageError(fmt::format("--method: expected limits or relaxed, found \"{}\"", options.method));
  if (options.reference != "best" && !is_method(options.reference))
    throw UsageError(fmt::format("--reference: expected best or one of {}, found \"{}\"",
                                 fmt::join(all_methods(), ", "), options.reference));
  if (options.holdout && !(*options.holdout >= 0 && *options.holdout < 1))
    throw UsageError(fmt::format("--holdout: expected a part from 0 to below 1, found {}", *options.holdout));
  if (options.out && !options.out->ends_with(".toml"))
    throw UsageError(fmt::format("--out: expected a name that ends in .toml, found \"{}\"", *options.out));
  prepare_file("--out", options.out);
  check_is_fitted_or_new(options.out);
  prepare_file("--json", options.json);
}

FitReport fit_family(const std::vector<Scene>& fitted, const std::vector<Scene>& held_out,
                     const FitOptions& options, const Control& control) {
  References references(options, control);
  std::vector<FitCase> cases, others;
  for (const Scene& scene : fitted)
    cases.push_back(references(scene));
  for (const Scene& scene : held_out)
    others.push_back(references(scene));
  FitReport report;
  report.method = options.method;
  report.reference = options.reference;
  report.fit = fit(cases, {options.method, options.trials}, control);
  Control quiet; // measured in any case, also after Ctrl-C
  quiet.threads = control.threads;
  for (std::size_t i = 0; i < cases.size(); ++i)
    report.fitted.push_back(fit_row(
        cases[i], report.fit.fitted[i],
        report.fit.alone.empty() ? std::nullopt : std::optional(report.fit.alone[i]), options.method, quiet));
  for (const FitCase& one : others)
    report.held_out.push_back(fit_row(one, fit_error(one, report.fit.materials, options.method, quiet),
                                      std::nullopt, options.method, quiet));
  report.reasons = reasons_for(report, cases);
  if (cases.size() < 3)
    report.reasons.push_back(fmt::format(
        "fitted to {} scene{}: that few say little about any other; three or more, with pulls, bends "
        "and pokes among them, are a family",
        cases.size(), cases.size() == 1 ? "" : "s"));
  if (others.empty())
    report.reasons.push_back(
        "no scene was kept from the fit: how it does on others is not known (--test SCENE, --holdout PART)");
  return report;
}

} // namespace

int fit_command(const FitOptions& asked) {
  if (!asked.measured.empty())
    return identify_command(asked);
  FitOptions options = asked;
  if (options.method.empty())
    options.method = "limits";
  keep_inputs(options.scenes);
  keep_inputs(options.tests);
  check_options(options);
  const Family family = family_of(options);
  const auto fitted = read_all(family.fitted), held_out = read_all(family.held_out);
  for (const Scene& scene : fitted)
    check_scene(scene, fitted.front(), options);
  for (const Scene& scene : held_out)
    check_scene(scene, fitted.front(), options);
  check_materials(fitted, held_out);
  const Control control = terminal_control(options.threads);
  const FitReport report = fit_family(fitted, held_out, options, control);
  end_progress();
  const bool quiet = options.json == "-";
  if (!quiet)
    deliver(table(report), std::nullopt);
  if (options.json)
    deliver(json_text(json(report)), options.json);
  if (options.out) {
    write_whole(*options.out, material_file(report.fit, notes(report)));
    if (!quiet)
      fmt::print("wrote {}\n", *options.out);
  }
  return report.fit.status == Status::done ? exit_done : exit_run_failed;
}

} // namespace maille::studies
