#pragma once
/// Cheap answers of a scene on coarser lattices, and what they predict of dearer ones (choose/choose.hpp).

#include "trade/quantity.hpp"
#include "trade/trade.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// What cheap answers say about a scene.
struct Probes {
  int halvings = -1; ///< of the finer of the two lattices; the other has twice its spacing
  /// Relative L2 difference of `coupled`, as if limits did not bind, between the two lattices, at the finer
  /// one's nodes
  double difference = 0;
  struct OfMethod {
    double model_error = 0; ///< relative L2 distance from that answer of `coupled` on the same lattice
    double seconds = 0;     ///< median of the runs
    std::string why_not;    ///< not empty: the method has no answer
  };
  std::map<std::string, OfMethod, std::less<>> of; ///< limits, relaxed, coupled
  /// In what the scene is unlike those of the table, in words. Then `growth` is known: by what the difference
  /// grew over the one between the finer lattice and the next finer, or nothing can be said.
  std::vector<std::string> unlike;
  std::optional<double> growth;
  /// Then too, per lattice (halvings) that holds the body: the relative L2 distance of `coupled` there from
  /// that on the finer lattice, at the scene's own nodes. The staircase of a body from an image is another on
  /// a coarser lattice, which no order of convergence tells.
  std::map<int, double> distance;
  std::map<int, std::string> lost; ///< lattices (halvings) that no longer hold the body, and why
  std::int64_t nodes = 0;          ///< of matter, on the finer lattice
  double seconds = 0;              ///< wall-clock of all probes
  std::string why_not;             ///< not empty: nothing can be said about this scene
  std::string quantity; ///< other than the displacement, whose `difference` and `distance` they then are
};

/// Solves the scene by limits, relaxed and coupled on one lattice, and by coupled on one of twice the
/// spacing: the coarsest pair, from twice and four times the scene's own spacing on, that still resolves the
/// body (every layer at least two cells thick, no material lost). If the scene is unlike those of the table,
/// the next finer lattice is solved too and replaces the first.
/// Cost  about three times `coupled` on the finest lattice; answers of less than some milliseconds are timed
///       up to five times
/// @param judge_kind false: the scene is taken to be like those of the table, which are its owner's
Probes probe(Lattices& lattices, const Control& control, bool judge_kind = true);

/// @param at    the scene on the lattice of `way`, for finite elements; may be null for others
/// @param nodes of matter there
/// @return error and seconds without calibration; nothing of methods that were not probed. Errors:
///         discretisation falls with the spacing, to the model's error and the tolerance it adds as squares.
///         Seconds: proportional to nodes; finite elements: fem_ref::estimate
RawPrediction predict_raw(const Probes& probes, const Way& way, const Scene* at, std::int64_t nodes);

/// Answers by `coupled` on three lattices that hold the body, each of half the spacing of the one before: the
/// coarsest that approach each other, of four times to a quarter of the scene's spacing, of which the last
/// three hold the very same body. Numbers have to move on in one direction, and an order of more than 2 is
/// not believed. `growth` and `distance` are those of the quantity, nothing is said about other methods.
/// Cost  about twice `coupled` on the finest of them, of a million cells at most
/// @pre !quantity.is_displacement()
Probes probe_quantity(Lattices& lattices, const Quantity& quantity, const Control& control);

} // namespace maille::studies
