/// Questions to the method of a deformable object, and its answers.

#include "world/deformable_object.hpp"

#include "elastic/elastic_methods.hpp"
#include "elastic/kept_answers.hpp"
#include "feasible/bounds/clipping.hpp"
#include "feasible/limits.hpp"
#include "lattice/tolerances.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

Answer drag_from(const Scene& question, const LinkLimits& limits, const Displacement& state,
                 const Control& control) {
  return drag_limits(question, limits, state, control);
}

} // namespace

/// A prescribed component and its origin. Of several for one component the first in this order is used.
struct DeformableObject::Entry {
  enum class Whose { hold, pin, handle, asked_pin, grip };
  Prescribed what;
  Whose whose;
  std::size_t pin = 0;
};

void DeformableObject::add_pin_entries(std::vector<Entry>& entries, std::size_t i, bool is_move) const {
  const Pin& pin = pins_[i];
  for (int b = 0; b < scene_->dimension(); ++b)
    if (lattice_.is_turned() || b == pin.axis)
      entries.push_back({{lattice_.node(pin.voxel), b, pin.at[b], !is_move && !pin.is_asked},
                         pin.is_asked ? Entry::Whose::asked_pin : Entry::Whose::pin,
                         i});
    else if (walls_grip_ && !is_move && !pin.is_asked)
      entries.push_back({{lattice_.node(pin.voxel), b, pin.at[b], false}, Entry::Whose::grip, i});
}

/// All prescribed values, by component, then by node.
std::vector<DeformableObject::Entry> DeformableObject::entries(bool pins_are_moves) const {
  std::vector<Entry> all;
  for (const Prescribed& p : scene_->prescribed)
    all.push_back({p, Entry::Whose::hold});
  for (const auto& [node, handle] : handles_)
    for (int b = 0; b < scene_->dimension(); ++b)
      all.push_back({{node, b, handle.at[b], !handle.is_driven}, Entry::Whose::handle});
  for (std::size_t i = 0; i < pins_.size(); ++i)
    add_pin_entries(all, i, pins_are_moves);
  const auto key = [](const Entry& e) { return std::pair(e.what.component, e.what.node); };
  std::ranges::stable_sort(all, {}, [&](const Entry& e) { return std::pair(key(e), e.whose); });
  const auto same = std::ranges::unique(all, {}, key);
  all.erase(same.begin(), same.end());
  return all;
}

Scene DeformableObject::question() const {
  Scene question = *scene_;
  question.prescribed.clear();
  for (const Entry& entry : entries(false))
    question.prescribed.push_back(entry.what);
  return question;
}

Answer DeformableObject::ask(Scene& question, const Control& control) {
  if (method_ == "coupled") {
    Answer answer = kept_->answer(question, control);
    if (has_displacement(answer.status))
      return answer;
  }
  if (method_ == "limits")
    return (by_limits_ != nullptr ? by_limits_ : drag_from)(question, limits_, state_, control);
  Answer answer = solve_relaxed(question, control);
  if (has_displacement(answer.status))
    leave_where_it_is(question, answer.displacement);
  else if (limits_bind_)
    return drag_from(question, limits_, state_, control);
  return answer;
}

/// Along an axis without prescribed components, every position is a solution; picks the one nearest to the
/// present state.
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
  // Sets prescribed values bit-identically, so that nodes at a face stay on their side.
  for (const Entry& entry : list) {
    double& value = answer.displacement(entry.what.component, entry.what.node);
    if (std::abs(value - entry.what.value) < tolerance * lattice_.cell_size()[entry.what.component])
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
      handles_.at(entry.what.node).force[entry.what.component] = reaction[i];
    else if (entry.whose != Entry::Whose::hold)
      on_pins[entry.pin][entry.what.component] = reaction[i];
  }
  for (std::size_t i = 0; i < pins_.size(); ++i) {
    const Eigen::Vector3d force =
        lattice_.is_turned() ? Eigen::Vector3d(lattice_.pose().rotation * on_pins[i]) : on_pins[i];
    pins_[i].pressure = -force[pins_[i].axis] * pins_[i].direction;
    pins_[i].grip = {on_pins[i][0], on_pins[i][1], on_pins[i][2]};
    pins_[i].grip[pins_[i].axis] = 0;
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
  return clip(*question_, limits_).n_cut == 0;
}

} // namespace maille::deform
