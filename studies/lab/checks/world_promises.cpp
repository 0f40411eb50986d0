#include "checks/world_promises.hpp"

#include "checks/promises.hpp"
#include "maille/deform/world/trajectory_drives.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <span>
#include <utility>

namespace maille::lab {

namespace {

using deform::FrameResult;
using deform::World;
using Eigen::Vector3d;

constexpr double in_balance = 1e-3; ///< of the largest force
constexpr double rounding = 1e-9;
constexpr double no_gain = 1e-6; ///< of the energy

bool is_body(const World& world, int object) {
  return world.kind(object) == ObjectKind::deformable;
}

std::string not_a_number(const World& world, const FrameResult& result) {
  for (int object = 0; object < world.n_objects(); ++object) {
    if (!is_body(world, object) &&
        !(world.pose(object).position.allFinite() && world.pose(object).rotation.allFinite()))
      return fmt::format("object {} is nowhere", object);
    if (is_body(world, object) &&
        !std::ranges::all_of(world.displacement(object).values(), [](double u) { return std::isfinite(u); }))
      return fmt::format("a displacement of object {} is not finite", object);
    const deform::ObjectMotion motion = world.motion(object);
    if (!motion.velocity.allFinite() || !motion.spin.allFinite() || !motion.centre.allFinite())
      return fmt::format("the motion of object {} is not finite", object);
  }
  for (const deform::DriveResult& drive : result.drives)
    if (!std::isfinite(drive.fraction) || !drive.force.allFinite())
      return "what became of a drive is not finite";
  for (const deform::WorldContact& contact : result.contacts)
    if (!contact.force.allFinite() || (contact.at && !contact.at->allFinite()))
      return fmt::format("a force on object {} is not finite", contact.object);
  for (const deform::HandOver& hand_over : result.handed_on)
    if (!std::isfinite(hand_over.asked) || !std::isfinite(hand_over.moved))
      return "a movement that was handed on is not finite";
  return {};
}

std::string wrong_end(const FrameResult& result) {
  if (!has_displacement(result.status))
    return fmt::format("the frame ended {}", to_string(result.status));
  return result.status != Status::done && result.message.empty()
             ? fmt::format("{} without a reason", to_string(result.status))
             : "";
}

std::string overlap(const World& world, const FrameResult& result) {
  if (world.scene().contact == ContactLaw::surfaces && !is_converged(result.status))
    return {}; // on the way to a balance
  if (const std::int64_t n = world.n_penetrations(); n > 0)
    return fmt::format("{} cells of matter are in other matter, or outside", n);
  if (world.scene().contact == ContactLaw::surfaces)
    return {};
  const std::int64_t n = world.n_shared_cells();
  return n > 0 ? fmt::format("{} voxels are in cells of other objects", n) : "";
}

std::string lost_form(const World& world) {
  for (int object = 0; object < world.n_objects(); ++object)
    if (const Eigen::Matrix3d& rotation = world.pose(object).rotation;
        (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm() > rounding)
      return fmt::format("object {} is no longer turned, but deformed", object);
  return {};
}

/// A point about which moments are taken, and half of the object's size [m].
std::pair<Vector3d, double> middle_and_size(const World& world, int object) {
  const Specimen& body = world.scene().objects[static_cast<std::size_t>(object)].scene.specimen;
  const Vector3d half = deform::middle_of(body);
  if (!is_body(world, object))
    return {world.pose(object).position + world.pose(object).rotation * half, half.norm()};
  Vector3d sum = Vector3d::Zero();
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    if (body.is_node(body.grid.node_at(node)))
      sum += world.position(object, node);
  return {sum / static_cast<double>(body.n_matter_nodes()), half.norm()};
}

/// Forces below this are what weak springs and tolerances leave [N].
double least_force(const World& world) {
  double stiffest = 0;
  for (const WorldObject& object : world.scene().objects)
    for (const Material& material : object.scene.materials)
      stiffest = std::max(stiffest, material.elasticity.youngs_modulus[0]);
  const double size = world.cell_size()[0];
  return 1e-6 * std::max(size, stiffest * std::pow(size, world.scene().dimension - 1));
}

std::string out_of_balance(const World& world, const FrameResult& result,
                           const std::vector<bool>& is_in_hand) {
  double largest = 0;
  for (const deform::WorldContact& contact : result.contacts)
    largest = std::max(largest, contact.force.norm());
  if (!(largest > least_force(world)))
    return {};
  for (int one = 0; one < world.n_objects(); ++one) {
    Vector3d force = Vector3d::Zero(), moment = force;
    std::vector<Vector3d> between(static_cast<std::size_t>(one), Vector3d::Zero());
    const auto [middle, size] = middle_and_size(world, one);
    for (const deform::WorldContact& contact : result.contacts) {
      if (contact.object == one) {
        force += contact.force;
        moment += (contact.at.value_or(middle) - middle).cross(contact.force);
      }
      const auto [low, high] = std::minmax(contact.object, contact.other);
      if (high == one && low >= 0 && low != one)
        between[static_cast<std::size_t>(low)] += contact.force;
    }
    for (const Vector3d& sum : between)
      if (!(sum.norm() <= in_balance * largest))
        return fmt::format("action and reaction on object {} differ by {:.2g} of the largest force", one,
                           sum.norm() / largest);
    const WorldObject& object = world.scene().objects[static_cast<std::size_t>(one)];
    const bool is_free = object.kind != ObjectKind::fixed && object.scene.prescribed.empty() &&
                         !is_in_hand[static_cast<std::size_t>(one)];
    if (!is_free || world.scene().dynamics || !is_converged(result.status))
      continue;
    const double off = std::max(force.norm(), moment.norm() / size) / largest;
    if (!(off <= in_balance))
      return fmt::format("object {} is free, and what acts on it adds up to {:.2g} of the largest force", one,
                         off);
  }
  return {};
}

/// Every number that a frame leaves.
void add_to_trace(const World& world, const FrameResult& result, std::vector<double>& trace) {
  trace.push_back(static_cast<double>(result.status));
  trace.push_back(static_cast<double>(result.rounds));
  trace.push_back(static_cast<double>(result.contacts.size()));
  for (int object = 0; object < world.n_objects(); ++object) {
    if (is_body(world, object)) {
      const auto values = world.displacement(object).values();
      trace.insert(trace.end(), values.begin(), values.end());
    }
    const deform::Pose& pose = world.pose(object);
    trace.insert(trace.end(), pose.position.data(), pose.position.data() + 3);
    trace.insert(trace.end(), pose.rotation.data(), pose.rotation.data() + 9);
  }
  for (const deform::WorldContact& contact : result.contacts)
    trace.insert(trace.end(), contact.force.data(), contact.force.data() + 3);
}

/// Calls look(world, frame, result, is_in_hand) after each frame until it returns false.
template<class Look>
void play_frames(const WorldPlay& play, int threads, const std::function<bool()>& should_stop,
                 const Look& look) {
  World world(play.scene);
  std::vector<bool> is_in_hand(play.scene.objects.size(), false);
  for (const PlayFrame& frame : play.frames) {
    for (const int object : frame.released) {
      world.release(object);
      is_in_hand[static_cast<std::size_t>(object)] = false;
    }
    std::vector<deform::Drive> drives = frame.drives;
    for (deform::Drive& drive : drives) {
      is_in_hand[static_cast<std::size_t>(drive.object)] = true;
      if (!is_body(world, drive.object))
        drive.motion.about += world.pose(drive.object).position;
      if (drive.lead)
        drive.lead->hand = world.pose(drive.object);
    }
    deform::FrameBudget budget;
    budget.rounds = frame.rounds;
    budget.threads = threads;
    budget.frame_seconds = play.frame_seconds;
    budget.stop_requested = should_stop;
    const double energy = world.energy();
    const FrameResult result = world.advance(drives, budget);
    if (!look(world, result, is_in_hand, energy) || (should_stop && should_stop()))
      break;
  }
}

bool is_rigid(const WorldScene& scene) {
  return std::ranges::none_of(
      scene.objects, [](const WorldObject& object) { return object.kind == ObjectKind::deformable; });
}

std::string risen(double before, double after) {
  return after - before > no_gain * std::max(std::abs(before), std::abs(after))
             ? fmt::format("energy has risen from {} to {} J", before, after)
             : "";
}

} // namespace

std::string broken_promise(const World& world, const FrameResult& result,
                           const std::vector<bool>& is_in_hand) {
  std::string what = wrong_end(result);
  if (what.empty())
    what = not_a_number(world, result);
  if (what.empty())
    what = overlap(world, result);
  if (what.empty())
    what = lost_form(world);
  if (const double violation = world.largest_violation(); what.empty() && !(violation <= rounding))
    what = fmt::format("a link is {:.3g} of its length outside its limits", violation);
  if (what.empty() && world.scene().contact == ContactLaw::surfaces)
    what = out_of_balance(world, result, is_in_hand);
  return what;
}

PlayOutcome played(const WorldPlay& play, const LookAtFrame& look, const std::function<bool()>& should_stop) {
  PlayOutcome outcome;
  int n = 0;
  bool keeps_energy = play.scene.dynamics && is_rigid(play.scene);
  play_frames(
      play, 1, should_stop,
      [&](const World& world, const FrameResult& result, const std::vector<bool>& is_in_hand, double energy) {
        const PlayFrame& frame = play.frames[static_cast<std::size_t>(n++)];
        outcome.done += result.status == Status::done;
        outcome.clamped += result.status == Status::clamped;
        outcome.cut_short += !is_converged(result.status);
        outcome.rounds += result.rounds;
        outcome.contacts += static_cast<std::int64_t>(result.contacts.size());
        outcome.handed_on += static_cast<std::int64_t>(result.handed_on.size());
        outcome.violation = std::max(outcome.violation, world.largest_violation());
        std::string what = broken_promise(world, result, is_in_hand);
        keeps_energy = keeps_energy && frame.drives.empty(); // what a hand lets go of has some
        if (what.empty() && keeps_energy)
          what = risen(energy, world.energy());
        if (what.empty() && look)
          what = look(world, result);
        if (!what.empty())
          outcome.broken = fmt::format("frame {}: {}", n, what);
        return what.empty();
      });
  return outcome;
}

std::string broken_promise(const WorldPlay& play, bool thorough) {
  try {
    std::vector<double> alone, together;
    const auto trace_of = [&](int threads, std::vector<double>& trace) {
      play_frames(play, threads, {},
                  [&](const World& world, const FrameResult& result, const std::vector<bool>&, double) {
                    add_to_trace(world, result, trace);
                    return true;
                  });
    };
    std::string broken = played(play).broken;
    if (!broken.empty() || !thorough)
      return broken;
    trace_of(1, alone);
    trace_of(2, together);
    return alone == together ? "" : "two threads give other bits than one";
  } catch (const std::exception& error) {
    return fmt::format("an exception came out: {}", error.what());
  }
}

std::string broken_promise_of_world_seed(std::uint64_t seed) {
  const bool thorough = seed % 4 == 0;
  Choices choices(seed);
  const WorldPlay play = random_world(choices);
  const std::string first = broken_promise(play, thorough);
  if (first.empty())
    return {};
  const auto fails = [&](const std::vector<std::uint32_t>& given) {
    Choices again(given);
    return !broken_promise(random_world(again), thorough).empty();
  };
  constexpr int trials = 100; // a play takes longer than a scene
  Choices smallest(shrunk(choices.made(), fails, trials));
  const WorldPlay small = random_world(smallest);
  return fmt::format("seed {}: {}\nmade smaller: {}\n{}", seed, first, broken_promise(small, thorough),
                     in_words(small));
}

} // namespace maille::lab
