#include "world/balance/surface_engine.hpp"

#include "lattice/tolerances.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace maille::deform {

namespace {

/// Largest motion of a round that ends an intermediate balance [cells]. With 1e-4 folded muscles change
/// sides; smaller values take more rounds.
constexpr double nearly_still_over_cell = 1e-5;
/// Lag of an object behind its drive from which it counts as stopped by a rigid object [cells]; behind soft
/// objects the lag is 1e-4.
constexpr double blocked_from = 0.01;

} // namespace

SurfaceEngine::SurfaceEngine(std::unique_ptr<WorldObjects> of) : Engine(std::move(of)), balance_(world()) {}

FrameResult SurfaceEngine::advance(std::span<const Drive> drives, const FrameBudget& budget) {
  FrameRun frame(*this, drives, budget);
  if (world().scene.dynamics && !(frame.duration > 0))
    throw std::invalid_argument("World: a frame lasts longer than 0 s");
  for (const Drive& drive : drives)
    if (world().scene.dynamics && drive.lead)
      throw std::invalid_argument("Drive: a hand that leads by a spring, in a world without dynamics");
  SurfaceFrame surfaces(frame, balance_);
  move(surfaces);
  return std::move(frame.result);
}

/// Quasi-static: drives move by steps, each followed by a balance.
void SurfaceFrame::move_in_balance() {
  take_handles();
  balance_.hold(frame_.clock.control.threads);
  for (int object = 0; object < world_.n_objects(); ++object)
    if (!world_.is_body(object) && balance_.object(object).rigid.distance_to_target(
                                       balance_.object(object).pose) > blocked_from * balance_.cell())
      balance_.object(object).rigid.target = balance_.object(object).pose; // its spring has been removed
  for (const Drive& drive : frame_.drives)
    if (drive.lead)
      balance_.object(drive.object).rigid.set_stiffness(drive.lead->stiffness);
  const int n = n_steps();
  const int last = std::min(n, frame_.most_steps() * std::max(1, n / frame_.n_steps()));
  if (frame_.seconds) // reserves the time that hand_back() took last time
    *frame_.seconds -= balance_.seconds_to_hand_back();
  const bool was_apart = !balance_.crossing();
  Balance::State before = balance_.state();
  bool has_settled = settle(frame_.drives.empty()); // with the new handles
  int step = 0;
  has_settled = !(was_apart && restore_if_overlapping(before, 0, n)) && has_settled;
  for (; step < last && !frame_.drives.empty() && frame_.rollback_reason.empty() && frame_.clock.has_budget();
       ++step) {
    before = balance_.state();
    drive(step, n);
    const bool is_last = step == last - 1;
    has_settled = settle(is_last);
    if (retract_blocked_drives(step, n))
      has_settled = settle(is_last);
    if (was_apart && restore_if_overlapping(before, step, n))
      break;
    find_blocked(n);
  }
  has_settled = has_settled && (step == n || frame_.drives.empty() || !frame_.rollback_reason.empty());
  if (!blocked_.empty() && frame_.rollback_reason.empty() && frame_.clock.has_budget())
    has_settled = settle();
  if (const auto crossing = balance_.crossing(); crossing && frame_.rollback_reason.empty()) {
    frame_.rollback_reason = fmt::format("objects `{}` and `{}` overlap", world_.name(crossing->first),
                                         world_.name(crossing->second));
    has_settled = false;
  }
  for (WorldObjects::Member& member : world_.members)
    member.is_unsettled = !has_settled;
  balance_.hand_back();
  report(has_settled);
}

void SurfaceFrame::take_handles() {
  for (const Drive& drive : frame_.drives)
    for (const std::int64_t node : drive.nodes) {
      DeformableObject& body = world_.body(drive.object);
      auto [handle, is_new] = body.handles().try_emplace(node);
      if (is_new)
        handle->second.at = body.displacement().at(node);
    }
}

/// If objects overlap across edges, restores the state before the step. @return the two objects
std::optional<std::pair<int, int>> SurfaceFrame::restore_if_overlapping(const Balance::State& before,
                                                                        int step, int n) {
  const auto crossing = balance_.crossing();
  if (!crossing)
    return std::nullopt;
  balance_.restore(before);
  for (std::size_t i = 0; i < frame_.drives.size(); ++i)
    if (world_.is_body(frame_.drives[i].object))
      put_handles(i, static_cast<double>(step) / n);
  balance_.prescribe();
  frame_.rollback_reason = fmt::format("objects `{}` and `{}` would overlap: the frame ended before that",
                                       world_.name(crossing->first), world_.name(crossing->second));
  return crossing;
}

int SurfaceFrame::n_steps() const {
  const double longest = *std::ranges::max_element(world_.scene.spacing);
  return std::min(frame_.n_steps(), 20'000'000) *
         static_cast<int>(std::ceil(longest / (step_over_cell * balance_.cell()) - 1e-9));
}

void SurfaceFrame::drive(int step, int n) {
  const double end = (step + 1.0) / n;
  for (std::size_t i = 0; i < frame_.drives.size(); ++i) {
    const Drive& drive = frame_.drives[i];
    std::optional<Pose>& target = balance_.object(drive.object).rigid.target;
    if (drive.lead && !world_.is_body(drive.object))
      target = drive.motion.moved(drive.lead->hand, end);
    else if (blocked_.contains(i))
      continue;
    else if (world_.is_body(drive.object))
      put_handles(i, end);
    else
      target = part_of(drive.motion, static_cast<double>(step) / n, end).moved(*target, 1);
  }
  balance_.prescribe();
}

/// Moves the handles of a drive to their places after a part of its motion.
void SurfaceFrame::put_handles(std::size_t i, double part) {
  const Drive& drive = frame_.drives[i];
  DeformableObject& body = world_.body(drive.object);
  const RigidMotion motion = part_of(drive.motion, 0, part);
  for (std::size_t k = 0; k < drive.nodes.size(); ++k) {
    body.handles()[drive.nodes[k]].at = body.lattice().displacement_at(
        body.lattice().voxel(drive.nodes[k]), moved_point(motion, frame_.nodes_before[i][k]));
  }
}

/// @param is_last false: without friction, an intermediate state needs only a loose tolerance. With friction
///        the state depends on its history, so that every state is converged.
/// @return true if the last round moved every body by less than the tolerance
bool SurfaceFrame::settle(bool is_last) {
  const bool is_on_the_way = !is_last && world_.scene.friction == 0;
  const double still = (is_on_the_way ? nearly_still_over_cell : negligible) * balance_.cell();
  balance_.begin();
  bool has_settled = false;
  for (int round = 0; round < iteration_cap && !has_settled && frame_.clock.has_budget(); ++round) {
    frame_.clock.count_round();
    const bool is_still = balance_.round() < still;
    has_settled = is_still && (is_on_the_way || balance_.gone() < still); // and touches are up to date
    if (is_still && !is_on_the_way)
      balance_.catch_up();
  }
  if (!is_on_the_way)
    balance_.catch_up();
  return has_settled;
}

/// True if an object is inside another one: only a drive can cause that.
bool SurfaceFrame::is_forced_in(int object) const {
  return std::ranges::any_of(balance_.touches(), [&](const Touch& touch) {
    return (touch.object == object || touch.other == object) && touch.object != touch.other &&
           touch.gap < -blocked_from * balance_.cell();
  });
}

/// Moves drives back by a step, and blocks them, if they have forced nodes into another object. @return true
/// if there is such a drive
bool SurfaceFrame::retract_blocked_drives(int step, int n) {
  bool is_any = false;
  for (std::size_t i = 0; i < frame_.drives.size(); ++i)
    if (world_.is_body(frame_.drives[i].object) && !blocked_.contains(i) &&
        is_forced_in(frame_.drives[i].object)) {
      put_handles(i, static_cast<double>(step) / n);
      blocked_.insert(i);
      is_any = true;
    }
  if (is_any)
    balance_.prescribe();
  return is_any;
}

/// Stops drives whose object lags behind because a rigid object is in the way. A drive that slides continues
/// along the obstacle.
void SurfaceFrame::find_blocked(int n) {
  for (std::size_t i = 0; i < frame_.drives.size(); ++i) {
    if (world_.is_body(frame_.drives[i].object) || frame_.drives[i].lead || blocked_.contains(i))
      continue;
    SurfaceObject& one = balance_.object(frame_.drives[i].object);
    if (one.rigid.distance_to_target(one.pose) > blocked_from * balance_.cell()) {
      one.rigid.target = one.pose;
      if (!frame_.drives[i].slides)
        blocked_.insert(i);
    }
    if (!blocked_.contains(i))
      frame_.done[i] += 1.0 / n;
  }
}

void SurfaceFrame::report(bool has_settled) {
  if (!world_.scene.dynamics) {
    const Balance::Left left = has_settled ? Balance::Left() : balance_.left();
    frame_.result.motion_left = left.motion;
    frame_.result.force_left = left.force;
  }
  double largest = 0;
  for (const Touch& touch : balance_.pressing())
    largest = std::max(largest, touch.force);
  for (const Touch& touch : balance_.pressing()) {
    if (!(touch.force > tolerance * largest))
      continue;
    const SurfaceObject& one = balance_.object(touch.object);
    WorldContact contact;
    contact.object = touch.object;
    contact.voxel = one.voxel(touch.node);
    contact.other = touch.other;
    set_axis(contact, touch.normal);
    contact.force = touch.force * touch.normal + touch.rubbing;
    contact.at = one.at[touch.node];
    if (touch.other >= 0) {
      const auto heaviest = std::ranges::max_element(touch.weights) - touch.weights.begin();
      contact.other_voxel = balance_.object(touch.other).voxel(touch.nodes[heaviest]);
      WorldContact back = contact;
      std::swap(back.object, back.other);
      std::swap(back.voxel, back.other_voxel);
      back.direction = -back.direction;
      back.force = -back.force;
      frame_.result.contacts.push_back(back);
    }
    frame_.result.contacts.push_back(contact);
  }
  std::ranges::stable_sort(frame_.result.contacts, {}, [](const WorldContact& contact) {
    return std::tuple(contact.object, contact.other, contact.voxel);
  });
  for (int object = 0; object < world_.n_objects(); ++object)
    if (world_.is_body(object))
      for (auto& [node, handle] : world_.body(object).handles())
        handle.force = balance_.pull_at(object, node);
  frame_.report_drives();
  for (std::size_t i = 0; i < frame_.drives.size(); ++i) {
    if (frame_.drives[i].lead) {
      frame_.report_lead(i);
      continue;
    }
    for (const WorldContact& contact : frame_.result.contacts)
      if (contact.object == frame_.drives[i].object && !world_.is_body(contact.object))
        frame_.result.drives[i].force -= contact.force;
  }
  for (DeformableObject& body : world_.bodies)
    body.settle_handles();
  frame_.report_end(has_settled, "contacts came and went without end: the frame ended on the way",
                    "the frame ended before all had settled");
}

} // namespace maille::deform
