#pragma once
/// What every method promises about every answer, asked of one answer or of one scene.

#include "maille/scene/answer.hpp"

#include <string>
#include <string_view>

namespace maille::lab {

/// True for a method that keeps every link of that scene within its limits, whenever and however it ends.
bool promises_limits(const Scene& scene, std::string_view method);

/// The largest excess of a link over its limits [m], and how much of it rounding may be [m]: that of sums of
/// as many links as the body has along its edges, in float64, and three quanta of the wavefront (see
/// TiledBody), 2^-29 of the range of displacements.
struct Excess {
  double largest = 0, allowed = 0;
};
Excess excess(const Scene& scene, const LinkLimits& limits, const Displacement& displacement);

/// What of its promises an answer breaks, in words; empty where it keeps them:
/// numbers are finite (displacement, residual, reactions, energy); an answer without displacement says why;
/// what is held is at rest and what is moved is where it was asked, to the bit, where the method is done;
/// links are within their limits (promises_limits()).
std::string broken_promise(const Scene& scene, std::string_view method, const Answer& answer);

/// Asks every method of the lattice and returns the first promise that is broken, or nothing: those above;
/// `limits` equals shortest paths; any number of threads gives the same bits; a sweep never raises its
/// energy; every method can be stopped at any time.
/// @param thorough also asks what costs more: threads of the relaxers, energies of sweeps, stops
std::string broken_promise(const Scene& scene, bool thorough);

/// The same for the random scene of a seed: seed, smallest scene that breaks a promise, and which promise;
/// empty if all hold. Every eighth seed is checked thoroughly.
std::string broken_promise_of_seed(std::uint64_t seed);

/// The same for the random world of a seed, and what is played in it (world_promises.hpp). Every fourth seed
/// is looked at thoroughly: two threads must give the bits of one.
std::string broken_promise_of_world_seed(std::uint64_t seed);

} // namespace maille::lab
