#include "maille/deform/drag.hpp"

#include "feasible/feasible_set.hpp"
#include "feasible/forecast.hpp"
#include "lattice/tolerances.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace maille::deform {

struct Drag::Parts {
  const Scene& scene;
  const LinkLimits& limits;
  int threads;
  Arena arena{};
  std::unique_ptr<DragEngine> engine{};
  List<DragHandle> handles{};
  bool may_turn = false;
  Frame frame;
  std::vector<Vec3> rest, places; ///< of the handles, for fitting the frame

  DragHandle& handle(std::int64_t node);
  void ask(std::int64_t node, const Vec3& displacement);
  Step move();
  bool turn_frame();
  void turn();
  /// Place of a handle in the world frame: the requested one to the bit, unless it was clipped.
  Vec3 clipped(const DragHandle& handle, const Vec3& asked) const;
  Vec3 position(const DragHandle& handle) const { return scene.specimen.position(handle.at); }
};

/// Marks a handle as moving. Its target is in the world's frame until turn().
void Drag::Parts::ask(std::int64_t node, const Vec3& displacement) {
  DragHandle& moving = handle(node);
  moving.target = displacement;
  moving.is_moving = true;
}

/// Rotates the frame with the common rotation of the handles, and the body with it; the centre of the handles
/// keeps its place. @return true if it rotated
bool Drag::Parts::turn_frame() {
  if (!may_turn || handles.size() < 2)
    return false;
  rest.clear();
  places.clear();
  Eigen::Vector3d at_rest = Eigen::Vector3d::Zero(), place = at_rest, within = at_rest;
  for (const DragHandle& handle : handles) {
    const Vec3 x = position(handle), u = handle.is_moving ? handle.target : frame.in_world(x, handle.value);
    rest.push_back(x);
    places.push_back(u);
    at_rest += Eigen::Map<const Eigen::Vector3d>(x.data());
    place += Eigen::Map<const Eigen::Vector3d>(x.data()) + Eigen::Map<const Eigen::Vector3d>(u.data());
    within += Eigen::Map<const Eigen::Vector3d>(handle.value.data());
  }
  const Eigen::Matrix3d rotation = fit_frame(scene.dimension(), rest, places).rotation;
  if ((rotation - frame.rotation).norm() <= rounding)
    return false;
  const auto n = static_cast<double>(handles.size());
  frame.is_turned = true;
  frame.rotation = rotation;
  Eigen::Map<Eigen::Vector3d>(frame.from.data()) = at_rest / n;
  Eigen::Map<Eigen::Vector3d>(frame.to.data()) = place / n - rotation * within / n;
  return true;
}

/// Transforms the targets into the frame. After a rotation, handles that rest in the world move in the frame.
void Drag::Parts::turn() {
  const bool has_turned = turn_frame();
  for (std::size_t i = 0; i < handles.size(); ++i) {
    DragHandle& handle = handles[i];
    if (has_turned && !handle.is_moving) {
      handle.target = places[i];
      handle.is_moving = true;
    }
    if (handle.is_moving)
      handle.target = frame.in_object(position(handle), handle.target);
  }
}

Vec3 Drag::Parts::clipped(const DragHandle& handle, const Vec3& asked) const {
  return handle.value == handle.wanted ? asked : frame.in_world(position(handle), handle.value);
}

/// The handle at a node, created if necessary.
DragHandle& Drag::Parts::handle(std::int64_t node) {
  const auto known = std::ranges::find(handles, node, &DragHandle::node);
  if (known != handles.end())
    return *known;
  DragHandle fresh;
  fresh.node = node;
  fresh.at = scene.specimen.grid.node_at(node);
  for (int b = 0; b < scene.dimension(); ++b)
    fresh.value[b] = engine->displacement(b, node);
  if (!engine->take(fresh)) {
    Displacement state(scene.specimen.grid);
    engine->copy_to(state);
    engine.reset(); // first: both states at once might be more than there is memory for
    engine = make_tiled_drag(scene, limits, threads, &state);
    engine->take(fresh);
  }
  return handles.emplace_back(fresh);
}

/// Moves the handles that are marked, and unmarks them.
Drag::Step Drag::Parts::move() {
  Step step;
  turn();
  for (DragHandle& moving : handles)
    if (moving.is_moving) {
      for (auto b = static_cast<std::size_t>(scene.dimension()); b < 3; ++b)
        moving.target[b] = moving.value[b];
      moving.wanted = moving.target;
    }
  step.visited = engine->move(handles);
  for (DragHandle& moving : handles)
    if (moving.is_moving) {
      moving.value = moving.target;
      moving.is_moving = false;
      step.is_cut = step.is_cut || moving.value != moving.wanted;
    }
  return step;
}

Drag::Drag(const Scene& scene, const LinkLimits& limits, int threads, FrameRule rule)
    : parts_(std::make_unique<Parts>(scene, limits, std::max(1, threads))) {
  const Arena::Open open(parts_->arena);
  parts_->engine = FeasibleSet(scene, limits, threads).drag();
  parts_->may_turn =
      rule == FrameRule::follows_handles && std::ranges::none_of(scene.prescribed, &Prescribed::held);
}
Drag::Drag(Drag&&) noexcept = default;
Drag& Drag::operator=(Drag&&) noexcept = default;
Drag::~Drag() = default;

Drag::Step Drag::move_to(std::int64_t node, const Vec3& displacement) {
  Step step;
  const Move move{node, displacement};
  step = move_to(std::span(&move, 1), std::span(&step.displacement, 1));
  return step;
}

Drag::Step Drag::move_to(std::span<const Move> moves, std::span<Vec3> clipped) {
  const Arena::Open open(parts_->arena);
  for (const Move& move : moves)
    parts_->ask(move.node, move.displacement);
  Step step = parts_->move();
  for (std::size_t i = 0; i < moves.size(); ++i) {
    step.displacement = parts_->clipped(parts_->handle(moves[i].node), moves[i].displacement);
    if (!clipped.empty())
      clipped[i] = step.displacement;
  }
  return step;
}

void Drag::release(std::int64_t node) {
  std::erase_if(parts_->handles, [&](const DragHandle& handle) { return handle.node == node; });
}

double Drag::displacement(int component, std::int64_t node) const {
  const double within = parts_->engine->displacement(component, node);
  if (!parts_->frame.is_turned)
    return within;
  Vec3 w{};
  for (int b = 0; b < parts_->scene.dimension(); ++b)
    w[b] = b == component ? within : parts_->engine->displacement(b, node);
  const Specimen& body = parts_->scene.specimen;
  return parts_->frame.in_world(body.position(body.grid.node_at(node)), w)[component];
}

Displacement Drag::displacement() const {
  Displacement state(parts_->scene.specimen.grid);
  copy_to(state);
  return state;
}

void Drag::copy_to(Displacement& state) const {
  if (parts_->frame.is_turned)
    std::ranges::fill(state.values(), 0); // what is turned below is all of it
  parts_->engine->copy_to(state);
  to_world(parts_->scene, parts_->frame, state);
}

Drag::Residue Drag::residue() const {
  if (!parts_->frame.is_turned)
    return parts_->engine->residue();
  Residue residue;
  const Displacement state = displacement();
  for (int b = 0; b < parts_->scene.dimension(); ++b)
    for (std::int64_t node = 0; node < parts_->scene.specimen.grid.n_nodes(); ++node)
      if (const double u = std::abs(state(b, node)); u > residue.largest)
        residue = {u, node, b};
  return residue;
}

const Frame& Drag::frame() const {
  return parts_->frame;
}

const std::string& Drag::algorithm() const {
  return parts_->engine->algorithm();
}

std::int64_t Drag::bytes() const {
  return parts_->arena.present();
}

Footprint Drag::footprint(const Scene& scene, const LinkLimits& limits) {
  return forecast_of_drag(scene, limits);
}

} // namespace maille::deform
