#pragma once
/// The finest finite-element answer that can be afforded, and how good it is.

#include "maille/scene/answer.hpp"
#include "maille/studies/methods.hpp"

namespace maille::studies {

struct BestReference {
  /// Method "best"; at the scene's own nodes. Without reactions where the mesh is finer than the scene's.
  Answer answer;
  /// The difference from the next coarser of the meshes that were solved. Every halving, and the step from
  /// linear to quadratic, at least halves the error (order 1 in the worst singular corner), so what is left
  /// is no more than that difference: an upper estimate, not a bound. Nothing where only one mesh could be
  /// afforded.
  std::optional<ErrorNorms> estimated_error;
  std::string coarser; ///< the mesh that it was compared with, in words
};

/// Solves the scene by linear elements, by quadratic ones, and by quadratic ones on cells that are halved
/// once, twice, three times: the finest of these that is expected to take at most `seconds` and 60 % of the
/// memory that is free, and the next coarser one.
/// @return status refused where not even linear elements can be afforded
BestReference best_reference(const Scene& scene, double seconds, const Control& control, Methods& methods);

} // namespace maille::studies
