#include "maille/scene/answer.hpp"

#include <algorithm>

namespace maille {

namespace {

/// In the order of the enumeration.
constexpr std::array<std::string_view, every_method.size()> names{
    "limits", "dijkstra", "literal", "sweep", "relaxed", "coupled", "fem_q1", "fem_q2", "calculix"};

} // namespace

std::string_view to_string(Status status) {
  switch (status) {
  case Status::done:
    return "done";
  case Status::clamped:
    return "clamped";
  case Status::budget_reached:
    return "budget_reached";
  case Status::interrupted:
    return "interrupted";
  case Status::refused:
    return "refused";
  case Status::failed:
    return "failed";
  }
  return "unknown";
}

bool has_displacement(Status status) {
  return status != Status::refused && status != Status::failed;
}

bool is_converged(Status status) {
  return status == Status::done || status == Status::clamped;
}

Displacement::Displacement(const Grid& grid)
    : Displacement(static_cast<std::size_t>(grid.dimension()), static_cast<std::size_t>(grid.n_nodes())) {}

Displacement::Displacement(std::size_t n_components, std::size_t n_nodes)
    : values_(n_components * n_nodes), n_components_(n_components), n_nodes_(n_nodes) {}

Vec3 Displacement::at(std::int64_t node) const {
  Vec3 u{};
  for (std::size_t b = 0; b < n_components_; ++b)
    u[b] = (*this)(b, node);
  return u;
}

Answer refusal(std::string method, std::string reason) {
  Answer answer;
  answer.method = std::move(method);
  answer.status = Status::refused;
  answer.message = std::move(reason);
  return answer;
}

double largest_violation(const Scene& scene, const LinkLimits& limits, const Displacement& in_world,
                         const Frame& frame) {
  Displacement turned_back;
  if (frame.is_turned)
    to_object(scene, frame, turned_back = in_world);
  const Displacement& displacement = frame.is_turned ? turned_back : in_world;
  const Grid& grid = scene.specimen.grid;
  double largest = 0;
  for (int axis = 0; axis < grid.dimension(); ++axis)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const Index3 at = grid.node_at(node);
      const auto a = static_cast<std::size_t>(axis);
      if (at[a] + 1 >= grid.nodes()[a])
        continue;
      const auto link = limits.intervals(at, axis);
      if (!link)
        continue;
      for (int b = 0; b < grid.dimension(); ++b) {
        const double difference = displacement(b, node + grid.stride(axis)) - displacement(b, node);
        const double excess = std::max(link->low[b] - difference, difference - link->high[b]);
        largest = std::max(largest, excess / grid.spacing()[a]);
      }
    }
  return largest;
}

std::string_view to_string(Method method) {
  return names.at(static_cast<std::size_t>(method));
}

std::optional<Method> method_from_string(std::string_view name) {
  const auto* const found = std::ranges::find(names, name);
  return found == names.end() ? std::nullopt : std::optional(every_method[found - names.begin()]);
}

bool has_stress(std::string_view method) {
  constexpr std::array<std::string_view, 4> without{"limits", "literal", "sweep", "dijkstra"};
  return std::ranges::find(without, method) == without.end();
}

} // namespace maille
