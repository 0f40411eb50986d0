#include "maille/deform/solve.hpp"

#include "maille/deform/propagate/dispatch.hpp"
#include "maille/deform/propagate/limits.hpp"
#include "maille/deform/propagate/literal.hpp"
#include "maille/deform/relax/relaxed.hpp"
#include "maille/deform/relax/sweep.hpp"
#include "maille/scene/frame.hpp"
#include "method.hpp"

#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numbers>

namespace maille::deform {

namespace {

struct Method {
  std::string_view name;
  Answer (*solve)(const Scene&, const Control&);
};

/// `limits` by shortest paths whatever the scene: the oracle of the ways that the dispatcher takes.
Answer solve_dijkstra(const Scene& scene, const Control& control) {
  if (std::string reason = reason_to_refuse(scene, "dijkstra"); !reason.empty())
    return refusal("dijkstra", std::move(reason));
  Answer answer = solve_limits(scene, control);
  answer.method = "dijkstra";
  return answer;
}

constexpr std::array<Method, 5> all_methods{{{"limits", solve_by_cheapest_way},
                                             {"dijkstra", solve_dijkstra},
                                             {"literal", solve_literal},
                                             {"sweep", solve_sweep},
                                             {"relaxed", solve_relaxed}}};

/// Puts nodes that are where they were asked to be there to the bit.
void place_handles(const Scene& scene, const Scene& within, const Displacement& answer,
                   Displacement& in_world) {
  const std::size_t d = in_world.component.size(),
                    n = scene.prescribed.size() / d; // by component, then by node
  for (std::size_t i = 0; i < n; ++i) {
    const std::int64_t node = scene.prescribed[i].node;
    bool is_there = true; // a component that was cut moves all of them in the world
    for (std::size_t b = 0; b < d; ++b)
      is_there = is_there && answer(static_cast<int>(b), node) == within.prescribed[b * n + i].value;
    for (std::size_t b = 0; is_there && b < d; ++b)
      in_world(static_cast<int>(b), node) = scene.prescribed[b * n + i].value;
  }
}

/// Forces on handles from the object's frame to the world's. @param reaction by component, then by node
void turn_forces(const Frame& frame, int dimension, std::vector<double>& reaction) {
  const std::size_t n = reaction.size() / static_cast<std::size_t>(dimension);
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    for (int b = 0; b < dimension; ++b)
      force[b] = reaction[static_cast<std::size_t>(b) * n + i];
    force = frame.rotation * force;
    for (int b = 0; b < dimension; ++b)
      reaction[static_cast<std::size_t>(b) * n + i] = force[b];
  }
}

/// Asks the method within the body, which the moves turn as a whole.
Answer solve_turned(const Method& method, const Scene& scene, const Frame& frame, const Control& control) {
  const Scene within = in_object(scene, frame);
  Answer answer = method.solve(within, control);
  answer.algorithm += fmt::format(" in a frame turned by {:.4g} deg", frame.angle() * 180 / std::numbers::pi);
  if (!has_displacement(answer.status))
    return answer;
  Displacement in_world = answer.displacement;
  to_world(scene, frame, in_world);
  place_handles(scene, within, answer.displacement, in_world);
  answer.displacement = std::move(in_world);
  turn_forces(frame, scene.dimension(), answer.reaction);
  return answer;
}

} // namespace

const std::vector<std::string_view>& methods() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> list;
    for (const Method& method : all_methods)
      list.push_back(method.name);
    return list;
  }();
  return names;
}

Answer solve(const Scene& scene, std::string_view method, const Control& control) {
  for (const Method& known : all_methods)
    if (known.name == method) {
      const Frame frame = object_frame(scene);
      return frame.is_turned ? solve_turned(known, scene, frame, control) : known.solve(scene, control);
    }
  return refusal(std::string(method), fmt::format("there is no method `{}` here; known are {}", method,
                                                  fmt::join(methods(), ", ")));
}

} // namespace maille::deform
