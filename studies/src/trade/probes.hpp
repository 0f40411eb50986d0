#pragma once
/// Probes: cheap answers on coarser lattices, and forecasts for expensive ones (choose/choose.hpp).

#include "trade/quantity.hpp"
#include "trade/trade.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// Results of the probes of a scene.
struct Probes {
  int halvings = -1; ///< of the finer lattice; the other one has twice its spacing
  /// Relative L2 difference of `coupled`, without binding limits, between the two lattices, at the nodes of
  /// the finer one
  double difference = 0;
  struct OfMethod {
    double model_error = 0; ///< relative L2 distance from `coupled` on the same lattice
    double seconds = 0;     ///< median of the runs
    std::string why_not;    ///< not empty: reason of a missing answer
  };
  std::map<std::string, OfMethod, std::less<>> of; ///< limits, relaxed, coupled
  /// Properties in which the scene differs from those of the table, in words. If there are any, `growth` is
  /// set: the difference of the next coarser pair of lattices over `difference`; without it, no forecast is
  /// possible.
  std::vector<std::string> unlike;
  std::optional<double> growth;
  /// Also set then, per valid lattice (halvings): relative L2 distance of `coupled` there from that on the
  /// finer lattice, at the scene's nodes. A body from an image has another staircase on a coarser lattice,
  /// which no order of convergence describes.
  std::map<int, double> distance;
  std::map<int, std::string> lost; ///< reasons, by lattice (halvings) that no longer represents the body
  std::int64_t nodes = 0;          ///< of the body, on the finer lattice
  double seconds = 0;              ///< wall-clock of all probes
  std::string why_not;             ///< not empty: reason that no forecast is possible
  std::string quantity;            ///< quantity of `difference` and `distance`; empty: the displacement
};

/// Solves the scene by limits, relaxed and coupled on one lattice, and by coupled on one of twice the
/// spacing: the coarsest pair, starting at two and four times the scene's spacing, that still resolves the
/// body (every layer at least two cells thick, no material lost). If the scene differs from those of the
/// table, the next finer lattice is solved too and replaces the first.
/// Cost  about three times `coupled` on the finest lattice; solves shorter than a few milliseconds are timed
///       up to five times
/// @param judge_kind false: assume that the scene resembles those of the table, which is the caller's own
Probes probe(Lattices& lattices, const Control& control, bool judge_kind = true);

/// @param at    the scene on the lattice of `way`, for finite elements; may be null for others
/// @param nodes of the body there
/// @return uncalibrated error and seconds; nothing for methods without probes. Errors: the discretisation
///         error falls with the spacing; the error of the model and the tolerance add as squares. Seconds:
///         proportional to nodes; finite elements: fem_ref::estimate
RawPrediction predict_raw(const Probes& probes, const Way& way, const Scene* at, std::int64_t nodes);

/// Solves by `coupled` on three valid lattices, each of half the previous spacing: the coarsest ones with
/// converging values, from four times to a quarter of the scene's spacing; the last three have exactly the
/// same body. Values must change monotonically, and the order is capped at 2. `growth` and `distance` refer
/// to the quantity; other methods get no forecast.
/// Cost  about twice `coupled` on the finest of them, which has a million cells at most
/// @pre !quantity.is_displacement()
Probes probe_quantity(Lattices& lattices, const Quantity& quantity, const Control& control);

} // namespace maille::studies
