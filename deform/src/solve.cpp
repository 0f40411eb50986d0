#include "maille/deform/solve.hpp"

#include "control/method.hpp"
#include "elastic/elastic_methods.hpp"
#include "elastic/kept_answers.hpp"
#include "elastic/tied/tied_methods.hpp"
#include "feasible/limits.hpp"
#include "maille/base/arena.hpp"
#include "maille/deform/plan.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/plausibility.hpp"
#include "oracle/literal.hpp"
#include "oracle/sweep.hpp"
#include "sliding.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numbers>
#include <string>
#include <utility>

namespace maille::deform {

namespace {

/// A method and the functions behind it.
struct Way {
  Method method;
  Answer (*solve)(const Scene&, const Control&);
  std::int64_t (*bytes)(const Scene&); ///< that it needs at most, by what can be told without limits
  bool knows_forces;                   ///< carries loads, or says itself when not

  std::string_view name() const { return to_string(method); }
};

Answer solve_limits_of_any(const Scene& scene, const Control& control) {
  return scene.tied.ties.empty() ? solve_by_cheapest_way(scene, control) : solve_limits_tied(scene, control);
}

/// `limits` by shortest paths whatever the scene: the oracle of the ways that the dispatcher takes.
Answer solve_dijkstra(const Scene& scene, const Control& control) {
  Answer answer = solve_limits(scene, control);
  answer.method = "dijkstra";
  return answer;
}

Answer solve_coupled_once(const Scene& scene, const Control& control) {
  return solve_coupled(scene, control);
}

/// Lower bound only; plan_limits() makes the real check.
std::int64_t bytes_for_limits(const Scene& scene) {
  // Ties add a hierarchy per component, active links, and fields.
  return bytes_at_least(scene) +
         (scene.tied.ties.empty() ? 0 : 3 * scene.specimen.grid.n_nodes() * (64 + 336 + 120));
}

constexpr std::array<Way, 6> ways{{{Method::limits, solve_limits_of_any, bytes_for_limits, false},
                                   {Method::dijkstra, solve_dijkstra, bytes_for_dijkstra, false},
                                   {Method::literal, solve_literal, bytes_for_literal, false},
                                   {Method::sweep, solve_sweep, bytes_for_sweep, false},
                                   {Method::relaxed, solve_relaxed, bytes_for_relaxed, true},
                                   {Method::coupled, solve_coupled_once, bytes_for_coupled, true}}};

/// Handles all of whose components are where they were asked to be; one that was cut moves all of them in the
/// world.
std::vector<bool> handles_in_place(const Scene& within, const Displacement& answer) {
  const std::size_t d = answer.n_components(),
                    n = within.prescribed.size() / d; // by component, then by node
  std::vector<bool> is_there(n, true);
  for (std::size_t i = 0; i < within.prescribed.size(); ++i)
    if (const Prescribed& p = within.prescribed[i]; answer(p.component, p.node) != p.value)
      is_there[i % n] = false;
  return is_there;
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

/// With a budget: the arena of the method ends it where its arrays would pass what there is.
Control within_memory(Control control) {
  if (!control.bytes_budget)
    control.bytes_budget = available_memory();
  return control;
}

/// What a copy of the scene holds.
std::size_t bytes_of_copy(const Scene& scene) {
  const Specimen& body = scene.specimen;
  return body.material_id.size() + body.fibres.size() * sizeof(body.fibres[0]) +
         body.label.size() * sizeof(body.label[0]) + scene.prescribed.size() * sizeof(Prescribed) +
         scene.tractions.size() * sizeof(FaceLoad) + scene.active_stress.size() * sizeof(double);
}

/// Solves in the rotated frame and rotates the answer back.
template<class Ask>
Answer solve_turned(const Scene& scene, const Frame& frame, const Control& control, const Ask& ask) {
  const Scene within = in_object(scene, frame);
  const Charge copy(bytes_of_copy(within));
  Answer answer = ask(within, control);
  answer.algorithm += fmt::format(" in a frame turned by {:.4g} deg", frame.angle() * 180 / std::numbers::pi);
  if (!has_displacement(answer.status) || answer.displacement.empty()) // as on all ranks but the first
    return answer;
  const std::vector<bool> is_there = handles_in_place(within, answer.displacement);
  to_world(scene, frame, answer.displacement);
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    if (const Prescribed& p = scene.prescribed[i]; is_there[i % is_there.size()])
      answer.displacement(p.component, p.node) = p.value; // to the bit
  turn_forces(frame, scene.dimension(), answer.reaction);
  return answer;
}

/// @param held  of the memory that the method needs, what it has already [bytes]
std::string reason_not_to_begin(const Way& way, const Scene& scene, const Control& control,
                                std::int64_t held) {
  std::string reason = unusable_number(scene);
  if (reason.empty() && !way.knows_forces)
    reason = reason_to_refuse(scene, way.name());
  // The forecast of `coupled` looks at every cell, which is not worth it where there is more memory than any
  // scene asks for.
  const std::int64_t most = (scene.specimen.grid.n_nodes() << 14) + (256 << 20);
  if (reason.empty() &&
      (way.method != Method::coupled || !reason_of_memory(way.name(), most, control).empty()))
    reason = reason_of_memory(way.name(),
                              control.communicator != nullptr
                                  ? bytes_for_coupled(scene, control.communicator->size())
                                  : way.bytes(scene) - held,
                              control);
  if (control.communicator != nullptr) {
    const std::vector<int> are_refused = from_every_rank(*control.communicator, reason.empty() ? 0 : 1);
    if (reason.empty() && std::ranges::find(are_refused, 1) != are_refused.end())
      reason = "another rank has no memory for it";
  }
  return reason;
}

/// @param ask   the method, callable as Way::solve
template<class Ask>
Answer solve_by(const Way& way, const Scene& scene, const Control& control, std::int64_t held,
                const Ask& ask) {
  if (std::string reason = reason_not_to_begin(way, scene, control, held); !reason.empty())
    return refusal(std::string(way.name()), std::move(reason));
  // Normals of ties do not turn, and copies of a body stand beside their places.
  const bool has_frames_of_its_own =
      (way.method == Method::coupled && in_blocks(scene)) || !scene.tied.ties.empty();
  const Frame frame = has_frames_of_its_own ? Frame{} : object_frame(scene);
  if (!frame.is_turned)
    return ask(scene, control);
  return in_arena(way.name(), control, [&] { return solve_turned(scene, frame, control, ask); });
}

/// Solves a scene whose labels slide on each other: runs the method on the body cut along their borders.
Answer solve_split(const Way& way, const Scene& scene, const Control& control) {
  const std::int64_t of_cut = way.bytes(scene); // solve_by() compares what the cut body needs with the budget
  if (std::string reason = reason_not_to_begin(way, scene, control, of_cut); !reason.empty())
    return refusal(std::string(way.name()), std::move(reason));
  const auto of_split = [&](const Scene& split) { return solve_by(way, split, control, 0, way.solve); };
  if (way.method == Method::coupled)
    return solve_sliding(scene, false, of_split);
  std::string obstacle = friction_that_asks_for_forces(scene);
  if (!obstacle.empty())
    return refusal(std::string(way.name()), std::move(obstacle));
  if (auto answer = solve_sliding_by_components(scene, way.method != Method::relaxed, of_split, obstacle))
    return *std::move(answer);
  const bool takes_limits =
      way.method == Method::limits || scene.relaxation.mode == RelaxationMode::deformable;
  if (way.method == Method::limits || way.method == Method::relaxed)
    return solve_sliding(scene, takes_limits, of_split);
  return refusal(std::string(way.name()),
                 obstacle + ": limits, relaxed, coupled and finite elements take borders of any shape");
}

} // namespace

const std::vector<std::string_view>& methods() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> list;
    for (const Way& way : ways)
      list.push_back(way.name());
    return list;
  }();
  return names;
}

bool is_for_all_ranks(const Scene& scene, std::string_view method, int n_ranks) {
  return method == to_string(Method::coupled) && is_shared_by_ranks(scene, n_ranks);
}

Answer solve(const Scene& scene, std::string_view method, const Control& asked) {
  Control control = within_memory(asked);
  if (asked.communicator != nullptr && !is_for_all_ranks(scene, method, asked.communicator->size()))
    control.communicator = nullptr;
  for (const Way& way : ways)
    if (way.name() == method)
      return scene.sliding.empty() ? solve_by(way, scene, control, 0, way.solve)
                                   : solve_split(way, scene, control);
  return refusal(std::string(method), fmt::format("there is no method `{}` here; known are {}", method,
                                                  fmt::join(methods(), ", ")));
}

bool feels_limits(const Scene& scene, std::string_view method) {
  if (method == "coupled")
    return scene.limits_bind_coupled();
  if (method == "relaxed")
    return scene.limits_bind_relaxed() || scene.relaxation.mode == RelaxationMode::deformable;
  return std::ranges::find(methods(), method) != methods().end();
}

Answer solve(const Scene& scene, Method method, const Control& control) {
  return solve(scene, to_string(method), control);
}

class ElasticBody::Parts : public KeptAnswers {
public:
  using KeptAnswers::KeptAnswers;
};

ElasticBody::ElasticBody(Keeping keeping) : parts_(std::make_unique<Parts>(keeping)) {}
ElasticBody::ElasticBody(ElasticBody&&) noexcept = default;
ElasticBody& ElasticBody::operator=(ElasticBody&&) noexcept = default;
ElasticBody::~ElasticBody() = default;

Answer ElasticBody::answer(const Scene& scene, const Control& asked) {
  Control control = within_memory(asked);
  control.communicator = nullptr; // what is kept is of one process
  if (!scene.sliding.empty())
    return solve(scene, Method::coupled, control);
  const auto way = std::ranges::find(ways, Method::coupled, &Way::method);
  return solve_by(*way, scene, control, parts_->bytes_of(scene),
                  [&](const Scene& within, const Control& of) { return parts_->answer(within, of); });
}

void ElasticBody::forget() {
  parts_->forget();
}

std::int64_t ElasticBody::bytes() const {
  return parts_->bytes();
}

std::int64_t bytes_needed(const Scene& scene, std::string_view method) {
  if (method == "limits") // what is refused before there is a plan may be more than the plan of a small body
    return std::max(bytes_for_limits(scene), plan_limits(scene, LinkLimits(scene)).bytes);
  for (const Way& way : ways)
    if (way.name() == method)
      return way.bytes(scene);
  return 0;
}

std::int64_t bytes_needed(const Scene& scene, Method method) {
  return bytes_needed(scene, to_string(method));
}

} // namespace maille::deform
