#pragma once
/// Quantities whose error `choose` can forecast: the displacement, or a function of an answer.

#include "maille/scene/answer.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// An answer with its scene, on one of several lattices.
struct AnswerOnLattice {
  const Scene* scene;
  const Answer* answer;
};

struct Quantity {
  std::string name = "displacement"; ///< as `--of` has it
  /// Relative difference between the answers on a coarser and a finer lattice; nothing if one of them lacks
  /// the quantity. Empty function: the displacement, which the table of trades covers.
  std::function<std::optional<double>(const AnswerOnLattice& coarse, const AnswerOnLattice& fine)> difference;
  /// Values of a scalar or short quantity, to show monotone convergence; else empty.
  std::function<std::vector<double>(const Scene&, const Answer&)> numbers;
  bool is_displacement() const { return !difference; }
};

/// A quantity of one or a few numbers, from any function of a scene and its answer; an empty result means
/// that the quantity does not exist. Relative differences use Euclidean norms. This constructor suffices for
/// quantities that a scene names.
Quantity quantity_of(std::string name,
                     std::function<std::vector<double>(const Scene&, const Answer&)> numbers);

/// `displacement`, `force` (resultants of all moves together, of holds without moves), `energy` (elastic),
/// `stress` (L2 over cells, see compare_mechanics).
std::vector<Quantity> every_quantity();
/// Quantity of exactly that name.
std::optional<Quantity> quantity_named(const std::string& name);

} // namespace maille::studies
