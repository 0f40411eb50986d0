#pragma once
/// What every world promises after every frame, asked of one play.

#include "checks/random_world.hpp"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace maille::lab {

/// How a play went.
struct PlayOutcome {
  std::string broken; ///< the first promise that is broken, with its frame; the play ends there
  std::int64_t done = 0, clamped = 0, cut_short = 0; ///< frames; cut_short: budget_reached or interrupted
  std::int64_t rounds = 0, contacts = 0, handed_on = 0;
  double violation = 0; ///< the largest of limits that bind, in lengths of links
};

/// What of its promises a world breaks after a frame, in words; empty where it keeps them:
/// the frame ended done, clamped, budget_reached or interrupted, with a reason unless done; numbers are
/// finite; no matter is in other matter or outside, by geometry (World::n_penetrations; of surfaces where the
/// frame has settled); what is rigid has kept its form; limits that bind are obeyed to 1e-9. Where cells keep
/// objects apart: no cell is of two objects. Where surfaces do: every force has its opposite, and in a frame
/// that has settled, without dynamics, forces and moments on what is free add up to nothing, to 1e-3 of the
/// largest force.
/// @param is_in_hand by object
std::string broken_promise(const deform::World& world, const deform::FrameResult& result,
                           const std::vector<bool>& is_in_hand);

/// What one question promises beside that, in words; empty where it is kept.
using LookAtFrame = std::function<std::string(const deform::World&, const deform::FrameResult&)>;

/// Plays it by one thread and looks after every frame. Where rigid objects alone have dynamics, no frame may
/// add energy before the first one with a hand in it.
/// @param look is asked too after each frame; what it returns is broken
PlayOutcome played(const WorldPlay& play, const LookAtFrame& look = {},
                   const std::function<bool()>& should_stop = {});

/// The same; thoroughly: two threads must give the same bits as one. Exceptions that come out are broken
/// promises.
std::string broken_promise(const WorldPlay& play, bool thorough);

} // namespace maille::lab
