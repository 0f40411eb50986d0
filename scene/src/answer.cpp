#include "maille/scene/answer.hpp"

#include <algorithm>

namespace maille {

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

bool is_settled(Status status) {
  return status == Status::done || status == Status::clamped;
}

Displacement::Displacement(const Grid& grid)
    : component(static_cast<std::size_t>(grid.dimension()),
                std::vector<double>(static_cast<std::size_t>(grid.n_nodes()), 0.0)) {}

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
      const LinkBounds link = limits.bounds(at, axis);
      if (!link.exists)
        continue;
      for (int b = 0; b < grid.dimension(); ++b) {
        const double difference = displacement(b, node + grid.stride(axis)) - displacement(b, node);
        const double excess = std::max(link.low[static_cast<std::size_t>(b)] - difference,
                                       difference - link.high[static_cast<std::size_t>(b)]);
        largest = std::max(largest, excess / grid.spacing()[a]);
      }
    }
  return largest;
}

} // namespace maille
