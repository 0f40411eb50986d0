// `maille fit`: checks, computes the references, then continues as maille-fit (python/maille/_fit.py).
#include "cli/commands.hpp"
#include "cli/inputs.hpp"

#include "compare/methods.hpp"
#include "maille/deform/solve.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/warp/displacement_field.hpp"
#include "maille/studies/version.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <random>
#include <sys/mman.h>
#include <unistd.h>

namespace maille::studies {

namespace {

/// A family of scenes: the fitted ones come first.
struct Family {
  std::vector<std::filesystem::path> fitted, held_out;
};

/// Pseudo-random split of the scenes, equal in every run: neighbours on a command line are similar.
Family draw_lots(std::vector<std::filesystem::path> scenes, double fraction) {
  const auto n = static_cast<double>(scenes.size());
  const auto out = static_cast<std::size_t>(std::clamp(std::round(fraction * n), 1.0, n - 1));
  std::vector<std::size_t> order(scenes.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    order[i] = i;
  std::mt19937 lot(1); // portable numbers; std::shuffle differs between libraries
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
      if (std::error_code none; std::filesystem::equivalent(all[i], all[j], none))
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

/// Answers of the reference, computed once per scene.
class References {
public:
  References(const FitOptions& options, const Control& control)
      : options_(options), control_(control), methods_(check_fem_solver(options.fem_solver)) {}

  /// @throws std::runtime_error if the reference has no answer
  Displacement operator()(const Scene& scene) {
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
    return std::move(answer.displacement);
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
  prepare_file("--out", options.out, {}, ".toml");
  prepare_file("--json", options.json);
}

/// Displacements of the reference, by component, in memory that survives exec.
/// @return the file of that memory
std::string kept_reference(const Displacement& reference) {
  const int memory = memfd_create("reference", 0);
  std::FILE* const stream = fdopen(dup(memory), "wb"); // closing it leaves the memory
  const auto values = reference.values();
  const bool is_whole =
      stream != nullptr && std::fwrite(values.data(), sizeof(double), values.size(), stream) == values.size();
  if (stream == nullptr || std::fclose(stream) != 0 || !is_whole)
    throw std::runtime_error(fmt::format("cannot keep a reference: {}", std::strerror(errno)));
  return fmt::format("/proc/self/fd/{}", memory);
}

/// The command with --measured, continued by python/maille/_identify.py.
int identify_command(const FitOptions& options) {
  const std::size_t n = options.scenes.size();
  if (options.measured.size() != n)
    throw UsageError(fmt::format("--measured: expected a file for each of {} scenes, separated by commas, "
                                 "found {}",
                                 n, options.measured.size()));
  const std::string method = options.method.empty() ? "coupled" : options.method;
  keep_inputs(options.scenes);
  keep_inputs(options.measured);
  check_methods({method}, "--method");
  if (!has_stress(method) || method == "calculix")
    throw UsageError("--method: expected one that knows forces, such as coupled, found \"" + method + "\"");
  auto scenes = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < n; ++i) {
    read_scene(options.scenes[i]); // finds errors, and registers the files that it names
    if (!is_image_file(options.measured[i]))
      read_text_file(options.measured[i], "a table of measured numbers");
    std::optional<std::string> out = options.out;
    if (out && n > 1)
      out = fmt::format("{}_{}.toml", std::filesystem::path(*out).replace_extension().string(), i + 1);
    prepare_file("--out", out, {}, ".toml");
    scenes.push_back({{"scene", options.scenes[i].string()},
                      {"measured", options.measured[i].string()},
                      {"out", out ? nlohmann::ordered_json(*out) : nullptr}});
  }
  prepare_file("--json", options.json);
  return become_python_program("fit",
                               {{"maille", version},
                                {"measured", scenes},
                                {"unknowns", options.unknowns},
                                {"method", method},
                                {"sigma", options.sigma ? nlohmann::ordered_json(*options.sigma) : nullptr},
                                {"threads", options.threads},
                                {"json", options.json ? nlohmann::ordered_json(*options.json) : nullptr}});
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
  if (const int code = run_python_program(
          "fit", {{"family", nlohmann::ordered_json::array({family.fitted, family.held_out})},
                  {"method", options.method}}))
    return code; // before any reference
  const Control control = terminal_control(options.threads);
  References references(options, control);
  const auto cases = [&](const std::vector<std::filesystem::path>& files, const std::vector<Scene>& scenes) {
    auto list = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < files.size(); ++i)
      list.push_back({{"scene", files[i].string()}, {"reference", kept_reference(references(scenes[i]))}});
    return list;
  };
  nlohmann::ordered_json request{{"maille", version},
                                 {"fitted", cases(family.fitted, fitted)},
                                 {"held_out", cases(family.held_out, held_out)},
                                 {"method", options.method},
                                 {"reference", options.reference},
                                 {"trials", options.trials},
                                 {"threads", options.threads},
                                 {"json", nullptr},
                                 {"out", nullptr}};
  if (options.json)
    request["json"] = *options.json;
  if (options.out)
    request["out"] = *options.out;
  end_progress();
  return become_python_program("fit", request);
}

} // namespace maille::studies
