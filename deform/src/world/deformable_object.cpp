#include "world/deformable_object.hpp"

#include "maille/deform/propagate/admission.hpp"
#include "maille/deform/propagate/limits.hpp"
#include "maille/deform/relax/coupled.hpp"
#include "maille/deform/relax/relaxed.hpp"
#include "propagate/envelope.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace maille::deform {

namespace {

/// A scale of taut limits that lets every link be as long as it likes: what relaxes elastically stands in for them.
constexpr double never_taut = 1e30;

/// As near as this to where it is pinned to, a node is there [cells].
constexpr double reached = 1e-6;
/// By so much an answer may miss prescribed values; where limits bind, values that were cut back are not to be overruled [cells].
constexpr double missed = 1e-7, missed_within_limits = 1e-10;
/// Of the force that would stretch a cell by as much as a node has moved.
constexpr double lost_by_algebra = 1e-5;

std::unique_ptr<Scene> checked_scene(const WorldObject& object, const WorldScene& world) {
  const auto fail = [&](const char* what) {
    throw std::invalid_argument("World: object `" + object.name + "` " + what);
  };
  const Scene& scene = object.scene;
  if (scene.has_loads())
    fail("carries loads or contracts: a frame of the world knows holds and handles");
  if (!std::ranges::all_of(scene.prescribed, [](const Prescribed& p) { return p.held && p.value == 0; }))
    fail("has moves of its own: drives move it");
  if (world.method == "limits" && scene.limits.from == LimitSource::taut)
    fail(
        "moves by its limits, and taut ones need a move to be scaled by: give limits or take the material's");
  auto copy = std::make_unique<Scene>(scene);
  if (copy->limits.from == LimitSource::taut)
    copy->limits.taut_scale = never_taut;
  return copy;
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

Index3 wall_of(const DeformableObject& body, const Pin& pin) {
  Index3 wall = body.cells().cell(pin.voxel);
  wall[static_cast<std::size_t>(pin.axis)] += pin.direction;
  return wall;
}

/// A prescribed component and whose it is. Of several for one component the first in this order counts.
struct DeformableObject::Entry {
  enum class Whose { hold, pin, handle, asked_pin, grip };
  Prescribed what;
  Whose whose;
  std::size_t pin = 0;
};

DeformableObject::DeformableObject(const WorldObject& object, const Pose& pose, const WorldScene& world,
                                   VoxelId first)
    : scene_(checked_scene(object, world)), question_(std::make_unique<Scene>(*scene_)),
      method_(world.method), stiffness_(largest_stiffness(*scene_)),
      limits_bind_(scene_->limits.from != LimitSource::taut), limits_(*question_),
      lattice_(scene_->specimen, pose, world.spacing), cells_(first, lattice_.n_voxels()),
      state_(scene_->specimen.grid) {}

void DeformableObject::add_pin(const Pin& pin) {
  const auto same = std::ranges::find_if(
      pins_, [&](const Pin& other) { return other.voxel == pin.voxel && other.axis == pin.axis; });
  if (same != pins_.end())
    *same = pin;
  else
    pins_.push_back(pin);
}

void DeformableObject::add_pin_entries(std::vector<Entry>& entries, std::size_t i, bool is_move) const {
  const Pin& pin = pins_[i];
  for (int b = 0; b < scene_->dimension(); ++b)
    if (lattice_.is_turned() || b == pin.axis)
      entries.push_back(
          {{lattice_.node(pin.voxel), b, pin.at[static_cast<std::size_t>(b)], !is_move && !pin.is_asked},
           pin.is_asked ? Entry::Whose::asked_pin : Entry::Whose::pin,
           i});
    else if (walls_grip_ && !is_move && !pin.is_asked)
      entries.push_back(
          {{lattice_.node(pin.voxel), b, pin.at[static_cast<std::size_t>(b)], false}, Entry::Whose::grip, i});
}

/// Everything that is prescribed, by component, then by node.
std::vector<DeformableObject::Entry> DeformableObject::entries(bool pins_are_moves) const {
  std::vector<Entry> all;
  for (const Prescribed& p : scene_->prescribed)
    all.push_back({p, Entry::Whose::hold});
  for (const auto& [node, handle] : handles_)
    for (int b = 0; b < scene_->dimension(); ++b)
      all.push_back(
          {{node, b, handle.at[static_cast<std::size_t>(b)], !handle.is_driven}, Entry::Whose::handle});
  for (std::size_t i = 0; i < pins_.size(); ++i)
    add_pin_entries(all, i, pins_are_moves);
  const auto key = [](const Entry& e) { return std::pair(e.what.component, e.what.node); };
  std::ranges::stable_sort(all, {}, [&](const Entry& e) { return std::pair(key(e), e.whose); });
  const auto same = std::ranges::unique(all, {}, key);
  all.erase(same.begin(), same.end());
  return all;
}

Answer DeformableObject::ask(Scene& question, const Control& control) const {
  if (method_ == "coupled") {
    Answer answer = solve_coupled(question, control);
    if (has_displacement(answer.status))
      return answer;
  }
  if (method_ == "limits")
    return drag_limits(question, limits_, state_, control);
  Answer answer = solve_relaxed(question, control);
  if (has_displacement(answer.status))
    leave_where_it_is(question, answer.displacement);
  else if (limits_bind_)
    return drag_limits(question, limits_, state_, control);
  return answer;
}

/// Of all places along an axis that a body comes to rest at where nothing is prescribed, the one nearest to where it is.
void DeformableObject::leave_where_it_is(const Scene& question, Displacement& answer) const {
  for (int component = 0; component < scene_->dimension(); ++component) {
    if (std::ranges::any_of(question.prescribed,
                            [component](const Prescribed& p) { return p.component == component; }))
      continue;
    double mean = 0;
    for (std::int32_t voxel = 0; voxel < lattice_.n_voxels(); ++voxel)
      mean += state_(component, lattice_.node(voxel)) / lattice_.n_voxels();
    for (std::int32_t voxel = 0; voxel < lattice_.n_voxels(); ++voxel)
      answer(component, lattice_.node(voxel)) = mean;
  }
}

Answer DeformableObject::answer(const Control& control) {
  const std::vector<Entry> list = entries(false);
  question_->prescribed.clear();
  for (const Entry& entry : list)
    question_->prescribed.push_back(entry.what);
  Answer answer = ask(*question_, control);
  if (!has_displacement(answer.status))
    return answer;
  // To the bit where they are to be, so that what touches a face stays on its side.
  for (const Entry& entry : list) {
    double& value = answer.displacement(entry.what.component, entry.what.node);
    if (std::abs(value - entry.what.value) <
        (limits_bind_ ? missed_within_limits : missed) *
            lattice_.cell_size()[static_cast<std::size_t>(entry.what.component)])
      value = entry.what.value;
  }
  keep_forces(list, answer.reaction);
  return answer;
}

void DeformableObject::keep_forces(const std::vector<Entry>& entries, const std::vector<double>& reaction) {
  std::vector<Eigen::Vector3d> on_pins(pins_.size(), Eigen::Vector3d::Zero());
  for (auto& [node, handle] : handles_)
    handle.force = {};
  for (std::size_t i = 0; i < entries.size() && i < reaction.size(); ++i) {
    const Entry& entry = entries[i];
    if (entry.whose == Entry::Whose::handle)
      handles_.at(entry.what.node).force[static_cast<std::size_t>(entry.what.component)] = reaction[i];
    else if (entry.whose != Entry::Whose::hold)
      on_pins[entry.pin][entry.what.component] = reaction[i];
  }
  for (std::size_t i = 0; i < pins_.size(); ++i) {
    const Eigen::Vector3d force =
        lattice_.is_turned() ? Eigen::Vector3d(lattice_.pose().rotation * on_pins[i]) : on_pins[i];
    pins_[i].pressure = -force[pins_[i].axis] * pins_[i].direction;
    pins_[i].grip = {on_pins[i][0], on_pins[i][1], on_pins[i][2]};
    pins_[i].grip[static_cast<std::size_t>(pins_[i].axis)] = 0;
  }
}

void DeformableObject::keep_reached_pins() {
  std::erase_if(pins_, [this](Pin& pin) {
    const Vec3 here = displacement_of(state_, lattice_.node(pin.voxel));
    for (int b = 0; b < scene_->dimension(); ++b) {
      const auto component = static_cast<std::size_t>(b);
      if ((lattice_.is_turned() || b == pin.axis) &&
          std::abs(here[component] - pin.at[component]) > reached * lattice_.cell_size()[component])
        return true;
    }
    for (std::size_t b = 0; b < 3; ++b)
      if (lattice_.is_turned() || static_cast<int>(b) == pin.axis)
        pin.at[b] = here[b]; // to the bit
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
      const std::vector<double> least = direction < 0 ? upper_envelope(*scene_, limits_, component, ends)
                                                      : lower_envelope(*scene_, limits_, component, ends);
      for (Pin& pin : pins_)
        if (is_meant(pin))
          pin.at[b] = least[static_cast<std::size_t>(lattice_.node(pin.voxel))];
    }
}

bool DeformableObject::can_be_met() const {
  if (!limits_bind_)
    return true;
  question_->prescribed.clear();
  for (const Entry& entry : entries(true))
    if (entry.whose != Entry::Whose::asked_pin && (entry.whose != Entry::Whose::handle || entry.what.held))
      question_->prescribed.push_back(entry.what);
  for (Prescribed& p : question_->prescribed)
    p.held = p.value == 0 && p.held;
  return admit(*question_, limits_).n_cut == 0;
}

bool DeformableObject::can_go(const OccupancyMap& map, const Displacement& to) const {
  for (std::int32_t voxel = 0; voxel < lattice_.n_voxels(); ++voxel) {
    const Index3 cell = cell_at(lattice_.place(voxel, to));
    if (cell != cells_.cell(voxel) && cells_.is_blocked(map, cell))
      return false;
  }
  return true;
}

double DeformableObject::go_towards(OccupancyMap& map, const Displacement& to, double part) {
  Displacement next(scene_->specimen.grid);
  for (double less = 1e-12; part > 0; less *= 4) {
    for (std::size_t b = 0; b < next.component.size(); ++b)
      for (std::size_t i = 0; i < next.component[b].size(); ++i) {
        const double from = state_.component[b][i], end = to.component[b][i];
        next.component[b][i] = part == 1 ? end : from + part * (end - from);
      }
    if (can_go(map, next))
      break;
    part = std::max(0.0, part - less);
  }
  if (!(part > 0))
    return 0;
  state_ = std::move(next);
  for (std::int32_t voxel = 0; voxel < lattice_.n_voxels(); ++voxel)
    cells_.move(map, voxel, cell_at(lattice_.place(voxel, state_)));
  return part;
}

void DeformableObject::settle_handles() {
  for (auto& [node, handle] : handles_) {
    handle.at = displacement_of(state_, node);
    handle.is_driven = false;
  }
}

double DeformableObject::largest_violation() const {
  return limits_bind_ ? maille::largest_violation(*scene_, limits_, state_) : 0;
}

double DeformableObject::force_noise() const {
  double furthest = 0;
  for (const auto& component : state_.component)
    for (const double value : component)
      furthest = std::max(furthest, std::abs(value));
  for (const Pin& pin : pins_)
    furthest = std::max(furthest, std::abs(pin.at[static_cast<std::size_t>(pin.axis)]));
  return lost_by_algebra * stiffness_ * furthest;
}

bool DeformableObject::is_closed() const {
  const auto d = static_cast<std::size_t>(scene_->dimension());
  const auto fits = [&](const LinkLimits::Slack& slack) {
    for (std::size_t a = 0; a < d; ++a)
      for (std::size_t b = 0; b < d; ++b) {
        const double rest = a == b ? scene_->specimen.grid.spacing()[a] : 0;
        const double most = std::max(rest + slack.high[a][b], -rest - slack.low[a][b]);
        if (most > lattice_.cell_size()[b] * (1 + 1e-12))
          return false;
      }
    return true;
  };
  return limits_bind_ && !lattice_.is_turned() && std::ranges::all_of(limits_.kinds(), fits);
}

std::int64_t DeformableObject::bytes() const {
  std::int64_t sum = lattice_.bytes() + cells_.bytes() + limits_.bytes();
  for (const auto& component : state_.component)
    sum += static_cast<std::int64_t>(component.capacity() * sizeof(double));
  return sum + static_cast<std::int64_t>(pins_.capacity() * sizeof(Pin) +
                                         handles_.size() * (sizeof(Handle) + 5 * sizeof(void*)));
}

} // namespace maille::deform
