#include "feasible/wavefront/wavefront.hpp"

#include "feasible/wavefront/wavefront_component.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::deform {

struct TiledBody::Parts {
  explicit Parts(const Scene& scene) : tiling(scene.specimen) {}
  Tiling tiling;
  std::vector<TiledComponent> components;
  std::vector<Prescribed> prescribed; ///< in the last move, as clipped
  std::array<List<Target>, 3> targets;
  std::unique_ptr<ThreadTeam> team; ///< where several threads have been asked for
  std::int64_t n_visits() const {
    std::int64_t sum = 0;
    for (const TiledComponent& component : components)
      sum += component.field().n_visits();
    return sum;
  }
};

namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// The range of what a scene prescribes for a component, rest included.
std::pair<double, double> range_to_come(const Scene& scene, int component) {
  double low = 0, high = 0;
  for (const Prescribed& p : scene.prescribed)
    if (p.component == component) {
      low = std::min(low, p.value);
      high = std::max(high, p.value);
    }
  return {low, high};
}

void copy_tile(const Tiling& tiling, const TiledComponent& component, std::int32_t tile,
               std::span<double> out) {
  const std::int32_t* const values = component.field().tile(tile);
  const std::int64_t offset = component.field().offset();
  tiling.for_each_node(tile, [&](std::int32_t, int slot, std::int64_t node) {
    out[node] = component.metres(offset + values[slot]);
  });
}

} // namespace

TiledBody::TiledBody(const Scene& scene, const LinkLimits& limits) : parts_(std::make_unique<Parts>(scene)) {
  parts_->components.reserve(index(scene.dimension()));
  for (int b = 0; b < scene.dimension(); ++b) {
    const auto [low, high] = range_to_come(scene, b);
    parts_->components.emplace_back(parts_->tiling, limits, b, low, high);
  }
}
TiledBody::TiledBody(TiledBody&&) noexcept = default;
TiledBody& TiledBody::operator=(TiledBody&&) noexcept = default;
TiledBody::~TiledBody() = default;

void TiledBody::rest() {
  parts_->prescribed.clear();
  for (TiledComponent& component : parts_->components)
    component.rest();
}

double TiledBody::set_state(const Displacement& state) {
  parts_->prescribed.clear();
  double largest = 0;
  for (std::size_t b = 0; b < parts_->components.size(); ++b)
    largest = std::max(largest, parts_->components[b].set_state(state.component(b)));
  return largest;
}

void TiledBody::copy_to(Displacement& state) const {
  for (std::size_t b = 0; b < parts_->components.size(); ++b)
    for (std::int32_t tile = 0; tile < parts_->tiling.n_tiles(); ++tile)
      copy_tile(parts_->tiling, parts_->components[b], tile, state.component(b));
  for (const Prescribed& p : parts_->prescribed)
    state(p.component, p.node) = p.value;
}

double TiledBody::displacement(int component, std::int64_t node) const {
  if (!parts_->tiling.has(node))
    return 0;
  const TiledComponent& of = parts_->components[index(component)];
  return of.metres(of.field().value(parts_->tiling.place(node)));
}

void TiledBody::raise(int component, std::span<const PathEnd> seeds) {
  parts_->prescribed.clear();
  parts_->components[index(component)].run(Way::raise, seeds);
}

void TiledBody::lower(int component, std::span<const PathEnd> seeds) {
  parts_->prescribed.clear();
  parts_->components[index(component)].run(Way::lower, seeds);
}

std::vector<Prescribed> TiledBody::move(std::span<const Prescribed> requested, int threads) {
  std::vector<Prescribed> clipped(requested.begin(), requested.end());
  move_in_place(clipped, threads);
  return clipped;
}

void TiledBody::move_in_place(std::span<Prescribed> values, int threads) {
  const int dimension = static_cast<int>(parts_->components.size()), useful = std::min(dimension, threads);
  const auto move_component = [&](int b, int) {
    List<Target>& targets = parts_->targets[index(b)];
    targets.clear();
    targets.reserve(std::ranges::count(values, b, &Prescribed::component));
    for (const Prescribed& p : values)
      if (p.component == b)
        targets.push_back({p.node, p.value, p.held});
    parts_->components[index(b)].move(targets);
    auto target = targets.begin();
    for (Prescribed& p : values)
      if (p.component == b)
        p.value = (target++)->value;
  };
  if (useful > 1) {
    if (!parts_->team || parts_->team->threads() != useful)
      parts_->team = std::make_unique<ThreadTeam>(useful);
    parts_->team->run(dimension, move_component);
  } else {
    for (int b = 0; b < dimension; ++b)
      move_component(b, 0);
  }
  parts_->prescribed.assign(values.begin(), values.end());
}

double TiledBody::quantum(int component) const {
  return parts_->components[index(component)].quantum();
}
std::int64_t TiledBody::n_tiles() const {
  return parts_->tiling.n_tiles();
}
std::int64_t TiledBody::n_visits() const {
  return parts_->n_visits();
}
} // namespace maille::deform
