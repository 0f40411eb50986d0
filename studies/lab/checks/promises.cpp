#include "checks/promises.hpp"

#include "checks/random_scene.hpp"
#include "feasible/bounds/clipping.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/block_frames.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace maille::lab {

namespace {

constexpr double quantum = 0x1p-29; ///< of the wavefront, over the range of displacements

/// Calls visit(node, axis, intervals) for every link.
template<class Visit>
void for_each_link(const Scene& scene, const LinkLimits& limits, const Visit& visit) {
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    for (int axis = 0; axis < grid.dimension(); ++axis) {
      const Index3 at = grid.node_at(node);
      const auto a = static_cast<std::size_t>(axis);
      if (at[a] + 1 >= grid.nodes()[a])
        continue;
      if (const auto link = limits.intervals(at, axis))
        visit(node, axis, *link);
    }
}

double largest_of(const Displacement& u) {
  double largest = 0;
  for (const double value : u.values())
    largest = std::max(largest, std::abs(value));
  return largest;
}

/// The largest difference between two nodes, of any component.
double range_of(const Displacement& u) {
  double range = 0;
  for (std::size_t b = 0; b < u.n_components(); ++b) {
    const auto [least, most] = std::ranges::minmax(u.component(b));
    range = std::max(range, most - least);
  }
  return range;
}

/// Length of the body's diagonal [m]: what a turn can carry a node by, about.
double size_of(const Grid& grid) {
  double square = 0;
  for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimension()); ++a)
    square += std::pow(grid.spacing()[a] * grid.cells()[a], 2);
  return std::sqrt(square);
}

bool all_finite(const Displacement& u) {
  return std::ranges::all_of(u.values(), [](double value) { return std::isfinite(value); });
}

/// What is not where it was asked; empty if all is.
std::string misplaced(const Scene& scene, const Answer& answer) {
  for (const Prescribed& p : scene.prescribed) {
    const double value = answer.displacement(p.component, p.node);
    if (p.held && value != 0)
      return fmt::format("node {} is held along {} and displaced by {} m", p.node, "xyz"[p.component], value);
    if (!p.held && answer.status == Status::done && value != p.value)
      return fmt::format("node {} was to go {} m along {} and went {} m, and nothing was said of that",
                         p.node, p.value, "xyz"[p.component], value);
  }
  return {};
}

std::string not_a_number(const Answer& answer) {
  if (!all_finite(answer.displacement))
    return "a displacement is not finite";
  if (!std::isfinite(answer.residual) || answer.residual < 0)
    return fmt::format("the residual is {}", answer.residual);
  for (const double force : answer.reaction)
    if (!std::isfinite(force))
      return fmt::format("a reaction is {}", force);
  if (answer.strain_energy && !std::isfinite(*answer.strain_energy))
    return fmt::format("the strain energy is {}", *answer.strain_energy);
  return {};
}

/// The first cell of matter whose mean deformation gradient turns it inside out; -1 without one.
std::int64_t inverted_cell(const Scene& scene, const Displacement& u) {
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (scene.specimen.is_matter(cell) &&
        !((Eigen::Matrix3d::Identity() + displacement_gradient(grid, u, grid.cell_at(cell))).determinant() >
          0))
      return cell;
  return -1;
}

} // namespace

bool promises_limits(const Scene& scene, std::string_view method) {
  if (method == "limits" || method == "dijkstra")
    return true;
  if (method == "relaxed")
    return scene.limits_bind_relaxed() || scene.relaxation.mode == RelaxationMode::deformable;
  if (method == "sweep")
    return scene.relaxation.mode == RelaxationMode::elastic;
  return method == "coupled" && scene.limits_bind_coupled();
}

Excess excess(const Scene& scene, const LinkLimits& limits, const Displacement& in_world) {
  const Frame frame = object_frame(scene);
  Displacement turned_back;
  if (frame.is_turned)
    to_object(scene, frame, turned_back = in_world);
  const Displacement& u = frame.is_turned ? turned_back : in_world;
  const Grid& grid = scene.specimen.grid;
  Excess excess;
  for_each_link(scene, limits, [&](std::int64_t node, int axis, const LinkIntervals<double>& link) {
    for (int b = 0; b < grid.dimension(); ++b) {
      const double difference = u(b, node + grid.stride(axis)) - u(b, node);
      const auto c = static_cast<std::size_t>(b);
      excess.largest = std::max({excess.largest, link.low[c] - difference, difference - link.high[c]});
    }
  });
  const double turned = frame.is_turned ? largest_of(in_world) + size_of(grid) : 0;
  excess.allowed = deform::rounding_tolerance(grid, largest_of(u) + turned) +
                   4 * quantum * std::max(range_of(u), scene.largest_prescribed()) +
                   8 * std::numeric_limits<double>::denorm_min();
  return excess;
}

std::string broken_promise(const Scene& scene, std::string_view method, const Answer& answer) {
  if (!has_displacement(answer.status))
    return answer.message.empty() ? fmt::format("{} without a reason", to_string(answer.status)) : "";
  if (std::string what = not_a_number(answer); !what.empty())
    return what;
  if (answer.status == Status::clamped && answer.message.empty())
    return "a request was cut back, and nothing says which";
  if (is_converged(answer.status))
    if (std::string what = misplaced(scene, answer); !what.empty())
      return what;
  if (method == "coupled" && in_blocks(scene) && answer.status == Status::done)
    if (const std::int64_t cell = inverted_cell(scene, answer.displacement); cell >= 0)
      return fmt::format("cell {} is turned inside out", cell);
  if (method == "coupled" && in_blocks(scene) && promises_limits(scene, method)) {
    // Links are measured in the mean frame of their cells. The bound covers the rounding of this second
    // measurement.
    constexpr double allowed = 1e-8;
    const double found = largest_violation_in_blocks(scene, LinkLimits(scene), answer.displacement);
    if (found > allowed)
      return fmt::format("a link is {:.3g} of its length outside its limits in the frame of its cells",
                         found);
    return {};
  }
  if (promises_limits(scene, method)) {
    const Excess found = excess(scene, LinkLimits(scene), answer.displacement);
    if (found.largest > found.allowed)
      return fmt::format("a link is {:.3g} m outside its limits, rounding may be {:.3g} m", found.largest,
                         found.allowed);
  }
  return {};
}

namespace {

/// Half the sum of squared differences over all links: what a sweep's rule lowers.
double energy_of_sweep(const Scene& scene, const LinkLimits& limits, const Displacement& u) {
  double sum = 0;
  for_each_link(scene, limits, [&](std::int64_t node, int axis, const LinkIntervals<double>&) {
    for (int b = 0; b < scene.dimension(); ++b)
      sum += 0.5 * std::pow(u(b, node + scene.specimen.grid.stride(axis)) - u(b, node), 2);
  });
  return sum;
}

std::string rising_energy(const Scene& scene) {
  if (scene.relaxation.mode != RelaxationMode::elastic || scene.has_loads())
    return {};
  const LinkLimits limits(scene);
  Scene cut = scene;
  double before = std::numeric_limits<double>::infinity();
  for (const std::int64_t sweeps : {1, 2, 3, 5, 8, 13}) {
    cut.relaxation.sweeps = sweeps;
    const Answer answer = deform::solve(cut, "sweep");
    Displacement u = answer.displacement;
    to_object(scene, object_frame(scene), u);
    const double energy = energy_of_sweep(scene, limits, u);
    const double largest = largest_of(u);
    const double rounding = 1e-12 * std::max(energy, largest * largest);
    if (energy > before + rounding)
      return fmt::format("sweep: energy rises from {} to {} by sweep {}", before, energy, sweeps);
    before = energy;
  }
  return {};
}

/// `limits` against shortest paths: as far as sums in float64 and the wavefront's quanta go.
std::string differs_from_paths(const Scene& scene, const Answer& limits, const Answer& paths) {
  if (!has_displacement(limits.status))
    return "limits refuses what shortest paths answer: " + limits.message;
  double largest = 0;
  for (std::size_t i = 0; i < paths.displacement.values().size(); ++i)
    largest = std::max(largest, std::abs(limits.displacement.values()[i] - paths.displacement.values()[i]));
  const Grid& grid = scene.specimen.grid;
  const double range = std::max(range_of(paths.displacement), scene.largest_prescribed());
  const double allowed =
      deform::rounding_tolerance(grid, 4 * (largest_of(paths.displacement) + size_of(grid))) +
      (static_cast<double>(grid.n_nodes()) + 2) * quantum * range;
  return largest > allowed ? fmt::format("limits is {:.3g} m from shortest paths, rounding may be {:.3g} m",
                                         largest, allowed)
                           : "";
}

/// A hard question (contrast and limits of no width at a tolerance of 1e-6) may take a method thousands of
/// iterations; the promises hold wherever it is stopped, and looks are counted where seconds would not
/// repeat.
constexpr int looks_at_the_clock = 100;

Answer solve_for_a_while(const Scene& scene, std::string_view method, int threads,
                         int looks = looks_at_the_clock) {
  Control control;
  control.threads = threads;
  control.stop_requested = [&looks] { return --looks < 0; };
  return deform::solve(scene, method, control);
}

std::string depends_on_threads(const Scene& scene, std::string_view method, const Answer& alone) {
  const Answer together = solve_for_a_while(scene, method, 3);
  const bool is_same = together.status == alone.status && together.displacement == alone.displacement;
  return is_same ? "" : fmt::format("{}: three threads give other bits than one", method);
}

/// Where the object lies in the world is a matter of files alone. Its direction is not: the axes of
/// orthotropic matter are defined in the world.
std::string depends_on_placement(const Scene& scene, std::string_view method, const Answer& placed) {
  if (scene.specimen.placement.is_identity())
    return {};
  Scene other = scene;
  other.specimen.placement.origin = {};
  const Answer answer = solve_for_a_while(other, method, 1);
  const bool is_same = answer.status == placed.status && answer.displacement == placed.displacement;
  return is_same ? "" : fmt::format("{}: the image's place changes the answer", method);
}

/// Stopped after a few looks at the clock.
std::string cannot_be_stopped(const Scene& scene, std::string_view method, int looks) {
  const Answer answer = solve_for_a_while(scene, method, 1, looks);
  const std::string what = broken_promise(scene, method, answer);
  return what.empty() ? "" : fmt::format("{}, stopped: {}", method, what);
}

} // namespace

std::string broken_promise(const Scene& scene, bool thorough) {
  Answer limits;
  for (const std::string_view method : deform::methods()) {
    const Answer answer = solve_for_a_while(scene, method, 1);
    if (std::string what = broken_promise(scene, method, answer); !what.empty())
      return fmt::format("{}: {}", method, what);
    if (method == "limits")
      limits = answer;
    if (method == "dijkstra" && has_displacement(answer.status))
      if (std::string what = differs_from_paths(scene, limits, answer); !what.empty())
        return what;
    if (!thorough)
      continue;
    for (const std::string& what :
         {depends_on_threads(scene, method, answer), depends_on_placement(scene, method, answer),
          cannot_be_stopped(scene, method, 0), cannot_be_stopped(scene, method, 3)})
      if (!what.empty())
        return what;
  }
  return thorough ? rising_energy(scene) : "";
}

std::string broken_promise_of_seed(std::uint64_t seed) {
  const bool thorough = seed % 8 == 0;
  Choices choices(seed);
  const Scene scene = random_scene(choices);
  const std::string first = broken_promise(scene, thorough);
  if (first.empty())
    return {};
  const auto fails = [&](const std::vector<std::uint32_t>& given) {
    Choices again(given);
    return !broken_promise(random_scene(again), thorough).empty();
  };
  Choices smallest(shrunk(choices.made(), fails));
  const Scene small = random_scene(smallest);
  return fmt::format("seed {}: {}\nmade smaller: {}\n{}", seed, first, broken_promise(small, thorough),
                     in_words(small));
}

} // namespace maille::lab
