#include "bench/bodies/body_figures.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace maille::lab {

namespace {

/// Bodies with fewer unknowns are answered on one thread, or in no time.
constexpr std::int64_t unknowns_worth_threads = 100'000;

class Checks {
public:
  Checks(const BodyFigures& figures, BenchReport& report) : figures_(figures), report_(report) {}

  void add_iterations();
  void add_costs();
  void add_finite_elements();
  void add_limits();
  void add_rest();

private:
  const AnsweredBody* body(const std::string& name) const {
    for (const auto& [of, answered] : figures_.bodies)
      if (of == name)
        return &answered;
    return nullptr;
  }
  /// The largest of what visit(body) returns, and of which body. @param visit nothing: not this one
  template<class Visit>
  std::pair<double, std::string> worst(const Visit& visit) const {
    std::pair<double, std::string> found{0, "none"};
    for (const auto& [name, answered] : figures_.bodies)
      if (const std::optional<double> value = visit(answered); value && *value > found.first)
        found = {*value, name};
    return found;
  }
  void add(const char* name, double value, std::string of = "") {
    report_.checks.push_back({name, value, std::move(of)});
  }

  const BodyFigures& figures_;
  BenchReport& report_;
};

void Checks::add_iterations() {
  const auto iterations = [](const AnsweredBody& of) { return static_cast<double>(of.coupled.iterations); };
  if (const AnsweredBody* const gyroid = body("gyroid 64")) {
    add("iterations_gyroid_64", iterations(*gyroid));
    add("iterations_gyroid_64_1e6", static_cast<double>(figures_.iterations_gyroid_1e6));
  }
  if (const AnsweredBody* const legs = body("both legs"))
    add("iterations_legs", iterations(*legs));
  add("iterations_contrast_1e4_over_1", figures_.iterations_contrast,
      "a network whose pores are filled with matter 1e4 times as soft, over the network alone");
}

void Checks::add_costs() {
  const auto [setup, slowest] = worst([](const AnsweredBody& of) -> std::optional<double> {
    return of.coupled.seconds.setup / of.coupled.seconds.solve;
  });
  add("setup_over_solve_worst", setup, slowest);
  if (const AnsweredBody* const network = body("gyroid 128"))
    add("ns_per_dof_gyroid_128_over_box_129",
        1e9 * network->coupled.seconds.total() / static_cast<double>(network->unknowns) /
            figures_.ns_per_unknown_of_box,
        fmt::format("box: {:.3g} ns", figures_.ns_per_unknown_of_box));
  const auto bytes_of = [](const AnsweredBody& of) -> std::optional<double> {
    return of.materials == 1 ? std::optional(of.own_bytes) : std::nullopt;
  };
  const auto [bytes, largest] = worst(bytes_of);
  const auto [of_alike, largest_alike] = worst([&](const AnsweredBody& of) -> std::optional<double> {
    return of.turns ? std::nullopt : bytes_of(of);
  });
  add("bytes_per_dof_worst_one_material", bytes,
      bytes == of_alike ? largest
                        : fmt::format("{}, whose cells have fibres of their own; of the others {}: {:.1f}",
                                      largest, largest_alike, of_alike));
}

void Checks::add_finite_elements() {
  const auto gain = [](const AnsweredBody& of) {
    return of.fem->seconds.total() / of.coupled.seconds.total();
  };
  if (const AnsweredBody* const legs = body("both legs"); legs != nullptr && legs->fem)
    add("fem_over_coupled_legs", gain(*legs));
  if (const AnsweredBody* const gyroid = body("gyroid 64"); gyroid != nullptr && gyroid->fem)
    add("fem_over_coupled_gyroid_64", gain(*gyroid));
}

void Checks::add_limits() {
  if (const AnsweredBody* const legs = body("both legs"); legs != nullptr && legs->limited)
    add("limits_over_elastic_legs", legs->limited->measured.seconds.total() / legs->coupled.seconds.total());
  const auto [over, of_body] = worst([](const AnsweredBody& of) -> std::optional<double> {
    if (!of.limited || !of.limited->bind || !of.fem)
      return std::nullopt;
    return of.limited->measured.seconds.total() / of.fem->seconds.total();
  });
  add("limits_over_fem_worst", over, of_body);
}

void Checks::add_rest() {
  add("default_over_wide_box_65", figures_.default_over_wide);
  if (figures_.next_frame_over_first_legs)
    add("next_frame_over_first_legs", *figures_.next_frame_over_first_legs);
  if (figures_.finger_on_calf_fps)
    add("finger_on_calf_fps", *figures_.finger_on_calf_fps,
        fmt::format("the force is within {:.2g} of the largest of frames that settle",
                    figures_.finger_on_calf_error));
  if (figures_.ranks_2_difference)
    add("ranks_2_difference", *figures_.ranks_2_difference,
        "coupled by two ranks against one process, of any node over the largest displacement");
  std::vector<double> gains;
  for (const auto& [name, answered] : figures_.bodies)
    if (answered.unknowns >= unknowns_worth_threads)
      gains.push_back(answered.coupled.seconds.total() / answered.two_threads.total());
  if (!gains.empty()) {
    const auto middle = gains.begin() + std::ssize(gains) / 2;
    std::ranges::nth_element(gains, middle);
    add("two_threads_speedup_bodies", *middle,
        fmt::format("the median of bodies of {} unknowns or more; arithmetic alone gains {:.2f}",
                    unknowns_worth_threads, figures_.two_threads_of_arithmetic));
  }
  add("one_cell_strip_error_nu45", figures_.one_cell_strip_error);
  add("peak_gib_257_bone", figures_.peak_gib_huge, "a gyroid network, a quarter solid");
}

} // namespace

void add_body_checks(const BodyFigures& figures, BenchReport& report) {
  Checks checks(figures, report);
  checks.add_iterations();
  checks.add_costs();
  checks.add_finite_elements();
  checks.add_limits();
  checks.add_rest();
}

} // namespace maille::lab
