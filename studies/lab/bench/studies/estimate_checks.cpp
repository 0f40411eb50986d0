#include "bench/studies/studies.hpp"

#include "compare/methods.hpp"
#include "maille/deform/estimated_error.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "median.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <random>
#include <string_view>

namespace maille::lab {

namespace {

constexpr std::uint32_t seed = 20261121;
constexpr int n_scenes = 42, n_quick = 6;
constexpr double factor = 2;
constexpr std::array<std::string_view, 4> methods{"limits", "relaxed", "sweep", "coupled"};

/// Distributions of the library differ from one to the next; this one does not.
class Lot {
public:
  explicit Lot(std::uint32_t of) : random_(of) {}
  double between(double from, double to) {
    return from + (to - from) * static_cast<double>(random_()) / 4294967296.0;
  }
  int whole(int from, int to) {
    return from + static_cast<int>(random_() % static_cast<unsigned>(to - from + 1));
  }

private:
  std::mt19937 random_;
};

struct Size {
  int x, y, z;
};

std::string material(Lot& lot) {
  constexpr std::array<std::string_view, 5> tissues{"muscle/vastus_lateralis", "muscle/soleus",
                                                    "muscle/gastrocnemius", "fat/subcutaneous",
                                                    "muscle/strongly_anisotropic"};
  constexpr std::array<double, 4> poisson{0, 0.3, 0.45, 0.49};
  if (const int i = lot.whole(0, 9); i < 5)
    return fmt::format("\"{}\"", tissues[static_cast<std::size_t>(i)]);
  return fmt::format("{{ youngs_modulus = \"10 kPa\", poisson_ratio = {} }}",
                     poisson[static_cast<std::size_t>(lot.whole(0, 3))]);
}

/// Cells of 1 mm. On boxes two in three can be halved along every axis, as those of a study usually can.
Size draw_size(Lot& lot, bool is_box) {
  const bool is_even = is_box && lot.whole(0, 2) > 0;
  const auto cells = [&](int from, int to) {
    return is_even ? 2 * lot.whole((from + 1) / 2, to / 2) : lot.whole(from, to);
  };
  return {cells(8, 14), cells(8, 10), cells(8, 10)};
}

/// Holds one end and does something to the other end, or to a patch above.
std::string conditions(Lot& lot, std::string_view action, const Size& size) {
  const double length = 1e-3 * size.x, part = lot.between(0.01, 0.1);
  if (action == "pull")
    return fmt::format("[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [{:.6g}, 0, 0]\n",
                       part * length);
  if (action == "bend")
    return fmt::format("[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [0, 0, {:.6g}]\n",
                       part * length);
  const double depth = part * 1e-3 * size.z;
  const int patch_x = 2 * (size.x / 8), patch_y = 2 * (size.y / 8), middle_x = 2 * (size.x / 4),
            middle_y = 2 * (size.y / 4);
  return fmt::format("[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = {{ box = [[{:.6g}, {:.6g}, {:.6g}], "
                     "[{:.6g}, {:.6g}, {:.6g}]] }}\n"
                     "by = [0, 0, {:.6g}]\n",
                     1e-3 * (middle_x - patch_x), 1e-3 * (middle_y - patch_y), 0.75e-3 * size.z,
                     1e-3 * (middle_x + patch_x), 1e-3 * (middle_y + patch_y), 1e-3 * size.z, -depth);
}

DrawnScene draw_scene(Lot& lot, int number) {
  constexpr std::array<std::string_view, 3> shapes{"box", "ellipsoid", "muscle"},
      actions{"pull", "bend", "poke"};
  const std::string_view shape = shapes[static_cast<std::size_t>(number % 3)],
                         action = actions[static_cast<std::size_t>(number / 3 % 3)];
  const Size size = draw_size(lot, shape == "box");
  const std::string matter = material(lot);
  const double angle = lot.between(0, 40);
  DrawnScene drawn;
  drawn.name =
      fmt::format("{}: {} {} x {} x {}, {}, {}", number, shape, size.x, size.y, size.z, action, matter);
  drawn.text = fmt::format("units = \"m, rad\"\n[specimen]\nshape = \"{}\"\ncells = [{}, {}, {}]\nspacing = "
                           "\"1 mm\"\nmaterial = {}\n"
                           "fibre = {{ angle = \"{:.4g} deg\", plane = \"xz\" }}\n",
                           shape, size.x, size.y, size.z, matter, angle);
  if (shape == "muscle") // tendons of other matter
    drawn.text += "tendon = { material = \"tendon/tibialis_anterior\", fraction = 0.15 }\n";
  drawn.text += conditions(lot, action, size);
  return drawn;
}

/// Quadratic elements; on boxes, where they are quick, on cells of half the side.
std::optional<Displacement> truth_of(const Scene& scene, const Control& control) {
  const bool is_box = scene.specimen.shape == "box";
  const Scene fine = is_box ? refined(scene) : scene;
  Answer answer = answer_by(fine, "fem_q2", control);
  if (!is_converged(answer.status))
    return std::nullopt;
  return is_box ? at_coarse_nodes(scene, fine, answer.displacement) : std::move(answer.displacement);
}

/// What was found out about one method.
struct Tally {
  int answers = 0, estimated = 0, within = 0;
  std::vector<double> ratios, costs; ///< estimated over true; seconds over those of `coupled`
};

class EstimateCheck {
public:
  explicit EstimateCheck(BenchReport& report) : report_(report) { control_.threads = 1; }
  void ask(const DrawnScene& drawn);
  void conclude();

private:
  void judge(const DrawnScene& drawn, const Scene& scene, std::size_t method, const Answer& answer,
             const Displacement& truth, double coupled_seconds);

  BenchReport& report_;
  Control control_;
  std::array<Tally, methods.size()> tallies_;
};

void EstimateCheck::judge(const DrawnScene& drawn, const Scene& scene, std::size_t method,
                          const Answer& answer, const Displacement& truth, double coupled_seconds) {
  const double true_error = compare(scene, answer.displacement, truth).relative_l2;
  const deform::ErrorEstimation found = deform::estimate_error(scene, answer.displacement, control_);
  Tally& tally = tallies_[method];
  ++tally.answers;
  nlohmann::ordered_json row{{"scene", drawn.name}, {"method", methods[method]}, {"true_error", true_error}};
  if (found.estimate) {
    const double ratio = found.estimate->norms.relative_l2 / true_error;
    ++tally.estimated;
    tally.within += ratio >= 1 / factor && ratio <= factor ? 1 : 0;
    tally.ratios.push_back(ratio);
    tally.costs.push_back(found.estimate->seconds / coupled_seconds);
    row["estimated_error"] = found.estimate->norms.relative_l2;
    row["ratio"] = ratio;
    row["cycles"] = found.estimate->cycles;
    row["seconds_over_coupled"] = found.estimate->seconds / coupled_seconds;
    row["other_lattice"] = deform::to_string(found.estimate->lattice);
  } else {
    report_.notes.push_back(
        fmt::format("{}, {}: no estimate: {}", drawn.name, methods[method], found.reason));
  }
  report_.rows.push_back(std::move(row));
}

void EstimateCheck::ask(const DrawnScene& drawn) {
  const Scene scene = parse_scene(drawn.text, "drawn.toml");
  const auto truth = truth_of(scene, control_);
  if (!truth) {
    report_.notes.push_back(drawn.name + ": finite elements have no answer; not counted");
    return;
  }
  const Answer coupled = answer_by(scene, "coupled", control_);
  for (std::size_t i = 0; i < methods.size(); ++i) {
    const Answer answer = methods[i] == "coupled" ? coupled : answer_by(scene, methods[i], control_);
    if (has_displacement(answer.status))
      judge(drawn, scene, i, answer, *truth, coupled.seconds.total());
    else
      report_.notes.push_back(fmt::format("{}, {}: {}", drawn.name, methods[i], answer.message));
  }
}

void EstimateCheck::conclude() {
  int answers = 0, within = 0;
  for (std::size_t i = 0; i < methods.size(); ++i) {
    const Tally& tally = tallies_[i];
    answers += tally.answers;
    within += tally.within;
    const auto [least, most] = std::ranges::minmax_element(tally.ratios);
    report_.rows.push_back({{"method", methods[i]},
                            {"answers", tally.answers},
                            {"estimated", tally.estimated},
                            {"within a factor of 2", tally.within},
                            {"least ratio", tally.ratios.empty() ? 0 : *least},
                            {"median ratio", upper_median(tally.ratios)},
                            {"largest ratio", tally.ratios.empty() ? 0 : *most},
                            {"seconds over coupled", upper_median(tally.costs)}});
  }
  report_.checks.push_back({"estimate_reliability", answers > 0 ? static_cast<double>(within) / answers : 0});
}

} // namespace

std::vector<DrawnScene> draw_scenes(int n, std::uint32_t of_seed) {
  Lot lot(of_seed);
  std::vector<DrawnScene> scenes;
  for (int i = 0; i < n; ++i)
    scenes.push_back(draw_scene(lot, i));
  return scenes;
}

void check_estimates(const BenchOptions& options, const Control& control, BenchReport& report) {
  EstimateCheck check(report);
  const std::vector<DrawnScene> scenes = draw_scenes(options.quick ? n_quick : n_scenes, seed);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (!goes_on(control, static_cast<double>(i) / static_cast<double>(scenes.size()),
                 "estimates, " + scenes[i].name))
      break;
    check.ask(scenes[i]);
  }
  check.conclude();
}

} // namespace maille::lab
