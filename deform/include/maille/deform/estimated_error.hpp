#pragma once
/// How far an answer is from elasticity, and where, without finite elements.

#include "maille/mechanics/recovery.hpp"
#include "maille/scene/answer.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace maille::deform {

/// From which other lattice the error of the lattice itself was told.
enum class OtherLattice {
  none,    ///< it was not: the model's error is that much larger, or there was no memory
  coarser, ///< of twice the spacing
  finer    ///< of half the spacing
};
/// `none`, `coarser`, `finer` as written in JSON.
std::string_view to_string(OtherLattice lattice);

/// An estimate of `answer - truth`, the truth being linear elasticity of the scene's cells, without limits,
/// as finite elements of any fineness answer it.
struct EstimatedError {
  Displacement error; ///< at every node of the grid, along its axes [m]
  ErrorNorms norms;   ///< of it, as of a true one
  /// Estimated errors of force, strain energy, strain and stress, measured as by compare_mechanics; each
  /// unset where the answer has no such figure. Force and energy include the lattice's part if the finer
  /// lattice gave it.
  MechanicsErrors mechanics;
  OtherLattice lattice = OtherLattice::none;
  std::int64_t cycles = 0; ///< of multigrid, over all lattices
  double seconds = 0;
  std::int64_t bytes = 0; ///< held at the peak, beside the scene's own
};

/// An estimate, or the reason why it is missing.
struct ErrorEstimation {
  std::optional<EstimatedError> estimate;
  std::string reason; ///< empty where there is one
};

/// Estimates the error of a displacement from any method of the lattice: of the model and the algebra (a
/// correction by multigrid, to 5 %), and of the lattice, from half the spacing where the first part is below
/// `small_model_error` and there is memory, else from twice the spacing. Rather above the truth than below.
/// Elasticity is meant in the object's frame. Not for displacements of finite elements.
///
/// @param displacement on the scene's grid [m]
/// @return a reason where elasticity has no answer (see solve_coupled), where the scene asks for blocks,
///         where it was stopped, or where there is no memory for what it needs
/// Cost        of answers of `coupled` about ten times theirs; of others about that of `coupled`
/// Memory      that of `coupled`, and four displacements; eight times that with the finer lattice
/// Repeatable  same bits for any number of threads
/// Source      docs/theory.md, section 3 (Error estimate); Brandt 1977; Richardson 1911
/// Checked by  tests/deform/elastic/estimated_error_test.cpp; `studies/lab/run studies`
ErrorEstimation estimate_error(const Scene& scene, const Displacement& displacement,
                               const Control& control = {});
/// The same of a whole answer of a lattice method, with EstimatedError::mechanics.
/// Cost  a walk through the cells more
ErrorEstimation estimate_error(const Scene& scene, const Answer& answer, const Control& control = {});

/// A model's error of this part of the displacement hides that of any lattice that is worth using.
inline constexpr double small_model_error = 0.1;

} // namespace maille::deform
