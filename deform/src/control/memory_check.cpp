#include "control/method.hpp"

#include "maille/base/arena.hpp"
#include "maille/scene/link_limits.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace maille::deform {

namespace {

std::int64_t most_ends(const Scene& scene) {
  std::int64_t most = 0;
  for (int b = 0; b < scene.dimension(); ++b)
    most = std::max(most, std::int64_t{std::ranges::count(scene.prescribed, b, &Prescribed::component)});
  return most;
}

} // namespace

std::int64_t bytes_of_prescribed(const Scene& scene) {
  return 8 * std::ssize(scene.prescribed) * std::int64_t{sizeof(Prescribed)}; // with their clipping
}

std::string reason_of_full_arena(std::string_view method, const Control& control) {
  return fmt::format("{} needs more memory than the {} that are available", method,
                     bytes_in_words(static_cast<double>(control.bytes_budget.value_or(0))));
}

std::string reason_of_memory(std::string_view method, std::int64_t needed, const Control& control) {
  const std::int64_t available = control.bytes_budget ? *control.bytes_budget : available_memory();
  if (needed <= available)
    return {};
  return fmt::format("{} needs about {}, {} are available", method,
                     bytes_in_words(static_cast<double>(needed)),
                     bytes_in_words(static_cast<double>(available)));
}

std::int64_t bytes_of_shortest_paths(const Grid& grid, std::int64_t n_ends) {
  // Entries of the queue, which grows by doubling. Measured on boxes, sheets, chains and the named bodies
  // (footprint_test.cpp): 0 to 0.22 a node from one end, 2.0 to 3.6 a node where every node is an end.
  constexpr std::int64_t entry = sizeof(std::pair<double, std::int64_t>);
  return grid.n_nodes() * std::int64_t{sizeof(double)} + (grid.n_nodes() / 4 + 4 * n_ends) * entry;
}

std::int64_t bytes_of_two_envelopes(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  return grid.n_nodes() * std::int64_t{sizeof(double)} + bytes_of_shortest_paths(grid, most_ends(scene));
}

std::int64_t bytes_of_answer(const Scene& scene) {
  return scene.dimension() * scene.specimen.grid.n_nodes() * std::int64_t{sizeof(double)};
}

std::int64_t bytes_at_least(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  const bool searches = scene.limit_source() == LimitSource::taut && !scene.limits.taut_scale;
  const std::int64_t answer = bytes_of_answer(scene);
  // The search is over before the answer is made. 16 KiB are for what does not grow.
  return 16384 + LinkLimits::bytes_at_most(scene) +
         std::max(answer, searches ? bytes_of_shortest_paths(grid, most_ends(scene)) : 0);
}

std::int64_t bytes_for_dijkstra(const Scene& scene) {
  return bytes_at_least(scene) + bytes_of_two_envelopes(scene) + bytes_of_prescribed(scene);
}

} // namespace maille::deform
