#include "world/deformable_object.hpp"

#include "control/method.hpp"
#include "elastic/kept_answers.hpp"
#include "feasible/bounds/bound_source.hpp"
#include "lattice/tolerances.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Scale of taut limits at which no limit is active: the elastic relaxation replaces them.
constexpr double never_taut = std::numeric_limits<float>::max();

/// Solver error in forces, in units of the force that would stretch a cell by the node's displacement.
constexpr double lost_by_algebra = 1e-5;

/// True for `relaxed` with limits in place of elasticity.
bool is_dead_zone(const Scene& scene) {
  return scene.relaxation.mode == RelaxationMode::deformable && scene.limit_source() != LimitSource::taut;
}

double largest_stiffness(const Scene& scene) {
  const Vec3& spacing = scene.specimen.grid.spacing();
  const double least = *std::min_element(spacing.begin(), spacing.begin() + scene.dimension());
  double largest = 0;
  for (const Material& material : scene.materials)
    largest = std::max(largest, maille::stiffness(material.elasticity).diagonal().maxCoeff());
  return largest * std::pow(least, scene.dimension() - 2);
}

} // namespace

std::unique_ptr<Scene> checked_scene(const WorldObject& object, const WorldScene& world) {
  const auto fail = [&](const char* what) {
    throw std::invalid_argument("World: object `" + object.name + "` " + what);
  };
  const Scene& scene = object.scene;
  if (scene.has_loads())
    fail("carries loads or contracts: a frame of the world knows holds and handles");
  if (!std::ranges::all_of(scene.prescribed, [](const Prescribed& p) { return p.held && p.value == 0; }))
    fail("has moves of its own: drives move it");
  const bool is_within_limits = world.method == "limits";
  if (is_within_limits && scene.limit_source() == LimitSource::taut && !scene.limits.taut_scale)
    fail(
        "moves by its limits, and taut ones need a move to be scaled by: give limits or take the material's");
  auto copy = std::make_unique<Scene>(scene);
  if (copy->limit_source() == LimitSource::taut && !is_within_limits)
    copy->limits.taut_scale = never_taut;
  return copy;
}

Index3 wall_of(const DeformableObject& body, const Pin& pin) {
  if (pin.wall)
    return *pin.wall;
  Index3 wall = body.cells().cell(pin.voxel);
  wall[pin.axis] += pin.direction;
  return wall;
}

DeformableObject::DeformableObject(const WorldObject& object, const Pose& pose, const WorldScene& world,
                                   VoxelId first)
    : scene_(checked_scene(object, world)), question_(std::make_unique<Scene>(*scene_)),
      method_(world.method), stiffness_(largest_stiffness(*scene_)),
      limits_bind_(method_ == "limits" || scene_->limits_bind_coupled() || is_dead_zone(*scene_)),
      limits_(*question_), lattice_(scene_->specimen, pose, world.spacing),
      matter_(scene_->specimen, lattice_),
      self_contact_(scene_->specimen, lattice_, matter_, limits_bind_ ? &limits_ : nullptr),
      cells_(first, lattice_.n_voxels(), matter_.n_cells()), state_(scene_->specimen.grid),
      kept_(std::make_unique<KeptAnswers>(Keeping::hierarchy)) {}

DeformableObject::DeformableObject(DeformableObject&&) noexcept = default;
DeformableObject::~DeformableObject() = default;

/// Limits point to the specimen of the copy's own question_.
DeformableObject::DeformableObject(const DeformableObject& other)
    : scene_(std::make_unique<Scene>(*other.scene_)), question_(std::make_unique<Scene>(*other.question_)),
      method_(other.method_), stiffness_(other.stiffness_), limits_bind_(other.limits_bind_),
      walls_grip_(other.walls_grip_), by_limits_(other.by_limits_), limits_(*question_),
      lattice_(other.lattice_), matter_(other.matter_), self_contact_(other.self_contact_),
      cells_(other.cells_), state_(other.state_), kept_(std::make_unique<KeptAnswers>(Keeping::hierarchy)),
      handles_(other.handles_), pins_(other.pins_) {}

void DeformableObject::add_pin(const Pin& pin) {
  const auto same = std::ranges::find_if(
      pins_, [&](const Pin& other) { return other.voxel == pin.voxel && other.axis == pin.axis; });
  if (same != pins_.end())
    *same = pin;
  else
    pins_.push_back(pin);
}

void DeformableObject::keep_reached_pins() {
  std::erase_if(pins_, [this](Pin& pin) {
    const Vec3 here = state_.at(lattice_.node(pin.voxel));
    for (int b = 0; b < scene_->dimension(); ++b) {
      const auto component = static_cast<std::size_t>(b);
      if ((lattice_.is_turned() || b == pin.axis) &&
          std::abs(here[component] - pin.at[component]) > negligible * lattice_.cell_size()[component])
        return true;
    }
    for (std::size_t b = 0; b < 3; ++b)
      if (lattice_.is_turned() || static_cast<int>(b) == pin.axis)
        pin.at[b] = here[b]; // bit-identical
    return false;
  });
}

void DeformableObject::reconcile_requests() {
  if (!limits_bind_ || lattice_.is_turned())
    return;
  for (int component = 0; component < scene_->dimension(); ++component)
    for (const int direction : {-1, 1}) { // of the movement, away from the wall
      std::vector<PathEnd> ends;
      const auto b = static_cast<std::size_t>(component);
      const auto is_meant = [&](const Pin& pin) {
        return pin.is_asked && pin.axis == component && pin.direction == -direction;
      };
      for (const Pin& pin : pins_)
        if (is_meant(pin))
          ends.push_back({lattice_.node(pin.voxel), pin.at[b]});
      if (ends.size() < 2)
        continue;
      const List<double> least = direction < 0 ? upper_envelope(*scene_, limits_, component, ends)
                                               : lower_envelope(*scene_, limits_, component, ends);
      for (Pin& pin : pins_)
        if (is_meant(pin))
          pin.at[b] = least[lattice_.node(pin.voxel)];
    }
}

bool DeformableObject::can_go(const OccupancyMap& map, const Displacement& to) const {
  for (std::int32_t voxel = 0; voxel < lattice_.n_voxels(); ++voxel) {
    const Index3 cell = cell_at(lattice_.place(voxel, to));
    if (cell != cells_.cell(voxel) && cells_.is_blocked(map, cell))
      return false;
  }
  for (std::int32_t point = 0; point < matter_.n_points(); ++point) {
    const Index3 cell = cell_at(matter_.place(point, lattice_, to));
    if (cells_.is_blocked(map, cell) && cell != cell_at(matter_.place(point, lattice_, state_)))
      return false;
  }
  return true;
}

std::vector<DeformableObject::Carrier> DeformableObject::carriers(const OccupancyMap& map, const Index3& cell,
                                                                  int axis) const {
  std::vector<Carrier> list;
  const VoxelId id = map.occupant(cell);
  if (!cells_.is_own(id))
    return list;
  const auto a = static_cast<std::size_t>(axis);
  for (const std::int32_t voxel : cells_.voxels_in(map, cell))
    list.push_back({voxel, lattice_.place(voxel, state_)[a], false});
  if (!cells_.is_node(id))
    collect_corners(cell, cells_.voxel(id) - lattice_.n_voxels(), axis, list);
  return list;
}

void DeformableObject::collect_corners(const Index3& cell, std::int32_t number, int axis,
                                       std::vector<Carrier>& list) const {
  const auto a = static_cast<std::size_t>(axis);
  const auto collect = [&](const BodyMatter::Point& point) {
    const InCells place = matter_.place(point, lattice_, state_);
    if (cell_at(place) != cell)
      return;
    for (std::size_t i = 0; i < 4; ++i)
      if (point.weight[i] > 0)
        list.push_back({point.node[i], place[a], true});
  };
  const auto [begin, end] = matter_.points_of(number);
  for (std::int32_t point = begin; point < end; ++point)
    collect(matter_.point(point));
  for (const BodyMatter::Point& point : matter_.points_of_stretched(number, lattice_, state_))
    collect(point);
  if (list.empty()) // interior cell: its middle is inside the matter
    for (const std::int32_t node : matter_.corners(number))
      list.push_back({node, cell[a] + 0.5, true});
}

double DeformableObject::go_towards(OccupancyMap& map, const Displacement& to, double part) {
  Displacement next(scene_->specimen.grid);
  for (double less = 1e-12; part > 0; less *= 4) {
    for (std::size_t i = 0; i < next.values().size(); ++i) {
      const double from = state_.values()[i], end = to.values()[i];
      next.values()[i] = part == 1 ? end : from + part * (end - from);
    }
    if (can_go(map, next))
      break;
    part = std::max(0.0, part - less);
  }
  if (!(part > 0))
    return 0;
  state_ = std::move(next);
  matter_.take(map);
  for (std::int32_t voxel = 0; voxel < lattice_.n_voxels(); ++voxel)
    cells_.move(map, voxel, cell_at(lattice_.place(voxel, state_)));
  put_matter(map);
  return part;
}

void DeformableObject::put_into(OccupancyMap& map) {
  cells_ = NodeCells(cells_.first(), lattice_.n_voxels(), matter_.n_cells());
  const std::vector<InCells> places = lattice_.places(state_);
  for (std::int32_t voxel = 0; voxel < lattice_.n_voxels(); ++voxel)
    if (const Index3 cell = cell_at(places[voxel]); !cells_.is_blocked(map, cell))
      cells_.put(map, voxel, cell);
  matter_.forget();
  matter_.put(map, cells_.first(), places);
}

void DeformableObject::settle_handles() {
  for (auto& [node, handle] : handles_) {
    handle.at = state_.at(node);
    handle.is_driven = false;
  }
}

double DeformableObject::largest_violation() const {
  return limits_bind_ ? maille::largest_violation(*scene_, limits_, state_) : 0;
}

double DeformableObject::force_noise() const {
  double furthest = largest_entry(state_);
  for (const Pin& pin : pins_)
    furthest = std::max(furthest, std::abs(pin.at[pin.axis]));
  return lost_by_algebra * stiffness_ * furthest;
}

std::int64_t DeformableObject::bytes() const {
  return kept_->bytes() + lattice_.bytes() + matter_.bytes() + self_contact_.bytes() + cells_.bytes() +
         limits_.bytes() + static_cast<std::int64_t>(state_.values().size_bytes()) +
         static_cast<std::int64_t>(pins_.capacity() * sizeof(Pin) +
                                   handles_.size() * (sizeof(Handle) + 5 * sizeof(void*)));
}

} // namespace maille::deform
