/// A frame of a world whose objects meet with their surfaces.

#include "lattice/tolerances.hpp"
#include "world/balance/balance.hpp"
#include "world/world_frame.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>
#include <utility>

namespace maille::deform {

namespace {

/// Largest motion of a round that ends a balance on the way [cells]. With 1e-4 folded muscles change sides;
/// with less, frames take more rounds.
constexpr double nearly_still_over_cell = 1e-5;
/// Lag of an object behind its hand from which it counts as stopped by something rigid [cells]; behind soft
/// objects the lag is 1e-4.
constexpr double blocked_from = 0.01;

/// Distance of an object from its hand's goal [m].
double behind(const BalancedObject& one) {
  if (!one.target)
    return 0;
  const Eigen::AngleAxisd turn(one.target->rotation * one.pose.rotation.transpose());
  return (one.target->position - one.pose.position).norm() + std::abs(turn.angle()) * one.radius;
}

} // namespace

void WorldFrame::take_handles() {
  for (const Drive& drive : drives_)
    for (const std::int64_t node : drive.nodes) {
      DeformableObject& body = parts_.body(drive.object);
      auto [handle, is_new] = body.handles().try_emplace(node);
      if (is_new)
        handle->second.at = body.displacement().at(node);
    }
}

FrameResult WorldFrame::run_balanced() {
  Balance& balance = *parts_.balance;
  take_handles();
  balance.hold(clock_.control.threads);
  for (int object = 0; object < parts_.n_objects(); ++object)
    if (!parts_.is_body(object) && behind(balance.object(object)) > blocked_from * balance.cell())
      balance.object(object).target = balance.object(object).pose; // a spring that led it is gone
  for (const Drive& drive : drives_)
    if (drive.lead)
      balance.object(drive.object).stiffness = drive.lead->stiffness;
  const int n = n_balanced_steps();
  const Index3& cells = parts_.scene.cells; // a longer way leads out of the world
  const int last = std::min(n, 8 * (cells[0] + cells[1] + cells[2]) * std::max(1, n / n_steps()));
  if (const auto left = clock_.seconds_left) // of which the end takes as much as it did last time
    clock_.seconds_left = [left, end = balance.seconds_to_hand_back()] {
      std::optional<double> seconds = left();
      if (seconds)
        *seconds -= end;
      return seconds;
    };
  const bool was_apart = !balance.crossing();
  Balance::State before = balance.state();
  bool has_settled = settle_balanced(drives_.empty()); // with what has changed hands
  int step = 0;
  has_settled = !(was_apart && goes_back(before, 0, n)) && has_settled;
  for (; step < last && !drives_.empty() && crossed_.empty() && clock_.may_go_on(); ++step) {
    before = balance.state();
    drive_balanced(step, n);
    const bool is_last = step == last - 1;
    has_settled = settle_balanced(is_last);
    if (take_back(step, n))
      has_settled = settle_balanced(is_last);
    if (was_apart && goes_back(before, step, n))
      break;
    find_blocked(n);
  }
  has_settled = has_settled && (step == n || drives_.empty() || !crossed_.empty());
  if (!blocked_.empty() && crossed_.empty() && clock_.may_go_on())
    has_settled = settle_balanced();
  if (const auto crossing = balance.crossing(); crossing && crossed_.empty()) {
    crossed_ = fmt::format("objects `{}` and `{}` overlap", name(crossing->first), name(crossing->second));
    has_settled = false;
  }
  for (WorldParts::Member& member : parts_.members)
    member.is_unsettled = !has_settled;
  balance.hand_back();
  report_balanced(has_settled);
  return std::move(result_);
}

/// Out of what has gone through edges, to what was before the step. @return the objects
std::optional<std::pair<int, int>> WorldFrame::goes_back(const Balance::State& before, int step, int n) {
  const auto crossing = parts_.balance->crossing();
  if (!crossing)
    return std::nullopt;
  parts_.balance->restore(before);
  for (std::size_t i = 0; i < drives_.size(); ++i)
    if (parts_.is_body(drives_[i].object))
      put_handles(i, static_cast<double>(step) / n);
  parts_.balance->prescribe();
  crossed_ = fmt::format("objects `{}` and `{}` would overlap: the frame ended before that",
                         name(crossing->first), name(crossing->second));
  return crossing;
}

int WorldFrame::n_balanced_steps() const {
  const double longest = *std::ranges::max_element(parts_.scene.spacing);
  return std::min(n_steps(), 20'000'000) *
         static_cast<int>(std::ceil(longest / (step_over_cell * parts_.balance->cell()) - 1e-9));
}

void WorldFrame::drive_balanced(int step, int n) {
  const double end = (step + 1.0) / n;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const Drive& drive = drives_[i];
    if (parts_.is_body(drive.object) && blocked_.contains(static_cast<int>(i)))
      continue;
    if (!parts_.is_body(drive.object)) {
      BalancedObject& one = parts_.balance->object(drive.object);
      if (drive.lead)
        one.target = drive.motion.moved(drive.lead->hand, end);
      else if (!blocked_.contains(static_cast<int>(i)))
        one.target = part_of(drive.motion, static_cast<double>(step) / n, end).moved(*one.target, 1);
      continue;
    }
    put_handles(i, end);
  }
  parts_.balance->prescribe();
}

/// Nodes that a drive has where it wants them after a part of its motion.
void WorldFrame::put_handles(std::size_t i, double part) {
  const Drive& drive = drives_[i];
  DeformableObject& body = parts_.body(drive.object);
  const RigidMotion motion = part_of(drive.motion, 0, part);
  for (std::size_t k = 0; k < drive.nodes.size(); ++k) {
    const Pose there = motion.moved({Eigen::Matrix3d::Identity(), nodes_before_[i][k]}, 1);
    body.handles()[drive.nodes[k]].at =
        body.lattice().displacement_at(body.lattice().voxel(drive.nodes[k]), there.position);
  }
}

/// @param is_last a state on the way needs no more than to be on the way of the one after it, where nothing
///        rubs: friction remembers
/// @return whether nothing moves any more
bool WorldFrame::settle_balanced(bool is_last) {
  Balance& balance = *parts_.balance;
  const bool is_on_the_way = !is_last && parts_.scene.friction == 0;
  const double still = (is_on_the_way ? nearly_still_over_cell : negligible) * balance.cell();
  balance.begin();
  bool has_settled = false;
  for (int round = 0; round < iteration_cap && !has_settled && clock_.may_go_on(); ++round) {
    ++clock_.rounds;
    if (clock_.rounds_left)
      --*clock_.rounds_left;
    const bool is_still = balance.round() < still;
    has_settled = is_still && (is_on_the_way || balance.gone() < still); // all that may touch was looked at
    if (is_still && !is_on_the_way)
      balance.catch_up();
  }
  if (!is_on_the_way)
    balance.catch_up();
  return has_settled;
}

/// True if a body is inside a rigid object: only a hand can have brought it there.
bool WorldFrame::is_forced_in(int object) const {
  return std::ranges::any_of(parts_.balance->touches(), [&](const Touch& touch) {
    return (touch.object == object || touch.other == object) && touch.object != touch.other &&
           touch.gap < -blocked_from * parts_.balance->cell();
  });
}

/// Hands that have forced nodes into something that does not give way go back by a step, and no further.
/// @return whether there are any
bool WorldFrame::take_back(int step, int n) {
  bool is_any = false;
  for (std::size_t i = 0; i < drives_.size(); ++i)
    if (parts_.is_body(drives_[i].object) && !blocked_.contains(static_cast<int>(i)) &&
        is_forced_in(drives_[i].object)) {
      put_handles(i, static_cast<double>(step) / n);
      blocked_.insert(static_cast<int>(i));
      is_any = true;
    }
  if (is_any)
    parts_.balance->prescribe();
  return is_any;
}

/// A driven object that lags behind its hand is stopped by something rigid: the hand stops there, or, if it
/// slides, continues along the obstacle.
void WorldFrame::find_blocked(int n) {
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    if (parts_.is_body(drives_[i].object) || drives_[i].lead || blocked_.contains(static_cast<int>(i)))
      continue;
    BalancedObject& one = parts_.balance->object(drives_[i].object);
    if (behind(one) > blocked_from * parts_.balance->cell()) {
      one.target = one.pose;
      if (!drives_[i].slides)
        blocked_.insert(static_cast<int>(i));
    }
    if (!blocked_.contains(static_cast<int>(i)))
      rigid_done_[i] += 1.0 / n;
  }
}

void WorldFrame::report_balanced(bool has_settled) {
  const Balance& balance = *parts_.balance;
  if (parts_.soft_dynamics == nullptr) {
    const Balance::Left left = has_settled ? Balance::Left() : balance.left();
    result_.motion_left = left.motion;
    result_.force_left = left.force;
  }
  double largest = 0;
  for (const Touch& touch : balance.pressing())
    largest = std::max(largest, touch.force);
  for (const Touch& touch : balance.pressing()) {
    if (!(touch.force > tolerance * largest))
      continue;
    const BalancedObject& one = parts_.balance->object(touch.object);
    const auto voxel_of = [&](int object, std::int32_t node) -> std::int64_t {
      const BalancedObject& whose = parts_.balance->object(object);
      return whose.is_body() ? whose.skin.node(node)
                             : whose.voxel[static_cast<std::size_t>(whose.skin.cell_at(node))];
    };
    WorldContact contact;
    contact.object = touch.object;
    contact.voxel = voxel_of(touch.object, touch.node);
    contact.other = touch.other;
    set_axis(contact, touch.normal);
    contact.force = touch.force * touch.normal + touch.rubbing;
    contact.at = one.at[static_cast<std::size_t>(touch.node)];
    if (touch.other >= 0) {
      const auto heaviest = std::ranges::max_element(touch.weights) - touch.weights.begin();
      contact.other_voxel = voxel_of(touch.other, touch.nodes[static_cast<std::size_t>(heaviest)]);
      WorldContact back = contact;
      std::swap(back.object, back.other);
      std::swap(back.voxel, back.other_voxel);
      back.direction = -back.direction;
      back.force = -back.force;
      result_.contacts.push_back(back);
    }
    result_.contacts.push_back(contact);
  }
  std::ranges::stable_sort(result_.contacts, {}, [](const WorldContact& contact) {
    return std::tuple(contact.object, contact.other, contact.voxel);
  });
  for (int object = 0; object < parts_.n_objects(); ++object)
    if (parts_.is_body(object))
      for (auto& [node, handle] : parts_.body(object).handles())
        handle.force = balance.pull_at(object, node);
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    report_drive(i);
    if (drives_[i].lead) {
      report_lead(i);
      continue;
    }
    for (const WorldContact& contact : result_.contacts)
      if (contact.object == drives_[i].object && !parts_.is_body(contact.object))
        result_.drives[i].force -= contact.force;
  }
  for (DeformableObject& body : parts_.bodies)
    body.settle_handles();
  report_end(has_settled, "contacts came and went without end: the frame ended on the way",
             "the frame ended before all had settled");
}

} // namespace maille::deform
