#pragma once
/// Estimated error of an answer against elasticity, without finite elements.

#include "maille/mechanics/recovery.hpp"
#include "maille/scene/answer.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace maille::deform {

/// The other lattice that the discretisation error is estimated from.
enum class OtherLattice {
  none,    ///< not estimated: the model error dominates, or memory did not suffice
  coarser, ///< of twice the spacing
  finer    ///< of half the spacing
};
/// `none`, `coarser`, `finer` as written in JSON.
std::string_view to_string(OtherLattice lattice);

/// An estimate of `answer - truth`. The truth is linear elasticity of the scene's cells, without limits, the
/// limit of finite elements under refinement.
struct EstimatedError {
  Displacement error; ///< at every node of the grid, along its axes [m]
  ErrorNorms norms;   ///< of `error`, defined as for a true error
  /// Estimated errors of force, strain energy, strain and stress, measured as by compare_mechanics(); each is
  /// unset if the answer lacks it. Force and energy include the discretisation error if it comes from the
  /// finer lattice.
  MechanicsErrors mechanics;
  OtherLattice lattice = OtherLattice::none;
  std::int64_t cycles = 0; ///< of multigrid, over all lattices
  double seconds = 0;
  std::int64_t bytes = 0; ///< peak memory without the scene
};

/// An estimate, or the reason why it is missing.
struct ErrorEstimation {
  std::optional<EstimatedError> estimate;
  std::string reason; ///< empty if there is an estimate
};

/// Estimates the error of a displacement from any method of the lattice: the model and solver error (a
/// correction by multigrid, to 5 %), and the discretisation error, from half the spacing if the first part is
/// below `small_model_error` and memory suffices, else from twice the spacing. Overestimates rather than
/// underestimates. Elasticity is that in the object's frame. Not for displacements of finite elements.
///
/// @param displacement on the scene's grid [m]
/// @return a reason if elasticity has no answer (see solve_coupled), if the scene has blocks, if it was
///         stopped, or if memory does not suffice
/// Cost        about ten times that of the answer for `coupled`; for other methods about that of `coupled`
/// Memory      that of `coupled`, plus four displacements; eight times that with the finer lattice
/// Repeatable  same bits for any number of threads
/// Source      docs/theory.md, section 3 (Error estimate); Brandt 1977; Richardson 1911
/// Checked by  tests/deform/elastic/estimated_error_test.cpp; `studies/lab/run studies`
ErrorEstimation estimate_error(const Scene& scene, const Displacement& displacement,
                               const Control& control = {});
/// The same for a whole answer of a lattice method, with EstimatedError::mechanics.
/// Cost  one more pass over the cells
ErrorEstimation estimate_error(const Scene& scene, const Answer& answer, const Control& control = {});

/// Relative model error above which the discretisation error of useful lattices is negligible.
inline constexpr double small_model_error = 0.1;

} // namespace maille::deform
