#pragma once
/// Uncalibrated forecast of error and cost for a scene: probe results for every method on every lattice.
/// python/maille/_choose.py calibrates it by a table of trades and makes the choice.

#include "trade/probes.hpp"

#include <nlohmann/json_fwd.hpp>

namespace maille::studies {

nlohmann::ordered_json json(const Probes& probes);

/// One entry per method and lattice (`halvings` of the spacing): cells, spacing [m], nodes, upper bound of
/// the memory in bytes, `seconds`, and `error`, to which tolerances of lattice methods add as squares; or
/// `why_not`.
/// Cost  building the lattices
nlohmann::ordered_json prospects(Lattices& lattices, const Probes& probes, int coarsest, int finest);

} // namespace maille::studies
