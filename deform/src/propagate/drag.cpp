#include "maille/deform/propagate/drag.hpp"

#include "propagate/drag_engine.hpp"

#include <algorithm>
#include <vector>

namespace maille::deform {

struct Drag::Parts {
  const Scene& scene;
  const LinkLimits& limits;
  int threads;
  std::unique_ptr<DragEngine> engine;
  std::vector<DragHandle> handles;

  DragHandle& handle(std::int64_t node);
  Step move();
};

/// The handle at a node, made if it is new.
DragHandle& Drag::Parts::handle(std::int64_t node) {
  const auto known = std::ranges::find(handles, node, &DragHandle::node);
  if (known != handles.end())
    return *known;
  DragHandle fresh;
  fresh.node = node;
  fresh.at = scene.specimen.grid.node_at(node);
  for (int b = 0; b < scene.dimension(); ++b)
    fresh.value[static_cast<std::size_t>(b)] = engine->displacement(b, node);
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
  for (DragHandle& moving : handles)
    if (moving.is_moving)
      for (auto b = static_cast<std::size_t>(scene.dimension()); b < 3; ++b)
        moving.target[b] = moving.value[b];
  step.visited = engine->move(handles);
  for (DragHandle& moving : handles)
    if (moving.is_moving)
      moving.value = moving.target;
  return step;
}

Drag::Drag(const Scene& scene, const LinkLimits& limits, int threads)
    : parts_(std::make_unique<Parts>(scene, limits, std::max(1, threads),
                                     limits.is_homogeneous()
                                         ? make_homogeneous_drag(scene, limits, std::max(1, threads))
                                         : make_tiled_drag(scene, limits, std::max(1, threads)),
                                     std::vector<DragHandle>{})) {}
Drag::Drag(Drag&&) noexcept = default;
Drag& Drag::operator=(Drag&&) noexcept = default;
Drag::~Drag() = default;

Drag::Step Drag::move_to(std::int64_t node, const Vec3& displacement) {
  DragHandle& handle = parts_->handle(node);
  handle.target = displacement;
  handle.is_moving = true;
  Step step = parts_->move();
  handle.is_moving = false;
  step.displacement = handle.value;
  for (std::size_t b = 0; b < static_cast<std::size_t>(parts_->scene.dimension()); ++b)
    step.is_cut = step.is_cut || handle.value[b] != displacement[b];
  return step;
}

Drag::Step Drag::move_to(std::span<const Move> moves, std::span<Vec3> admitted) {
  for (const Move& move : moves) {
    DragHandle& handle = parts_->handle(move.node);
    handle.target = move.displacement;
    handle.is_moving = true;
  }
  Step step = parts_->move();
  for (std::size_t i = 0; i < moves.size(); ++i) {
    DragHandle& handle = parts_->handle(moves[i].node);
    handle.is_moving = false;
    step.displacement = handle.value;
    for (std::size_t b = 0; b < static_cast<std::size_t>(parts_->scene.dimension()); ++b)
      step.is_cut = step.is_cut || handle.value[b] != moves[i].displacement[b];
    if (!admitted.empty())
      admitted[i] = handle.value;
  }
  return step;
}

void Drag::release(std::int64_t node) {
  std::erase_if(parts_->handles, [&](const DragHandle& handle) { return handle.node == node; });
}

double Drag::displacement(int component, std::int64_t node) const {
  return parts_->engine->displacement(component, node);
}

Displacement Drag::displacement() const {
  Displacement state(parts_->scene.specimen.grid);
  parts_->engine->copy_to(state);
  return state;
}

Drag::Residue Drag::residue() const {
  return parts_->engine->residue();
}

const std::string& Drag::algorithm() const {
  return parts_->engine->algorithm();
}

Footprint Drag::footprint(const Scene& scene, const LinkLimits& limits) {
  Footprint footprint =
      limits.is_homogeneous() ? footprint_of_homogeneous_drag(scene) : footprint_of_tiled_drag(scene, limits);
  footprint.back().bytes += static_cast<std::int64_t>(sizeof(Parts));
  return footprint;
}

std::int64_t Drag::bytes() const {
  return static_cast<std::int64_t>(sizeof(Parts) + parts_->handles.capacity() * sizeof(DragHandle)) +
         parts_->engine->bytes();
}

} // namespace maille::deform
