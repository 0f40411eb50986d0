#pragma once
/// What is known of a scene before a way to answer it is chosen: what probes say about every method on every
/// lattice, without calibration. The choice, calibrated by a table of trades, is made in
/// python/maille/_choose.py.

#include "trade/probes.hpp"

#include <nlohmann/json_fwd.hpp>

namespace maille::studies {

nlohmann::ordered_json json(const Probes& probes);

/// One entry a method and lattice (`halvings` of the spacing): cells, spacing [m], nodes, bytes that it needs
/// at most, `seconds`, and `error`, to which tolerances of lattice methods add as squares; or `why_not`.
/// Cost  that of building the lattices
nlohmann::ordered_json prospects(Lattices& lattices, const Probes& probes, int coarsest, int finest);

} // namespace maille::studies
