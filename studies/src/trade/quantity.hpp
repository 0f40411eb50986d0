#pragma once
/// What `choose` can promise the error of: the displacement, or what follows from an answer.

#include "maille/scene/answer.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// An answer with the scene that it is to, on one lattice of several.
struct AnswerOnLattice {
  const Scene* scene;
  const Answer* answer;
};

struct Quantity {
  std::string name = "displacement"; ///< as `--of` has it
  /// The relative difference of the answer on a coarser lattice from the one on a finer lattice; nothing
  /// where one of them has none. Empty function: the displacement, which the table of trades knows.
  std::function<std::optional<double>(const AnswerOnLattice& coarse, const AnswerOnLattice& fine)> difference;
  /// The numbers of a scalar or short quantity, to show convergence from one side; else empty.
  std::function<std::vector<double>(const Scene&, const Answer&)> numbers;
  bool is_displacement() const { return !difference; }
};

/// What comes to one or a few numbers, any function of a scene and its answer; none of them: there is no such
/// thing. Relative differences are those of Euclidean lengths. A quantity that a scene asks for by name is
/// made by this alone.
Quantity quantity_of(std::string name,
                     std::function<std::vector<double>(const Scene&, const Answer&)> numbers);

/// `displacement`, `force` (the resultants on all moves together, on holds where nothing moves), `energy`
/// (elastic), `stress` (L2 over cells, see compare_mechanics).
std::vector<Quantity> every_quantity();
/// The one of that name, to the letter.
std::optional<Quantity> quantity_named(const std::string& name);

} // namespace maille::studies
