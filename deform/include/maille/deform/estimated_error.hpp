#pragma once
/// How far an answer is from elasticity, and where, without finite elements.

#include "maille/scene/answer.hpp"
#include "maille/scene/compare.hpp"

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

/// An estimate of `answer - truth`, the truth being linear elasticity of the scene's cells, without limits, as finite elements of
/// any fineness answer it.
struct EstimatedError {
  Displacement error; ///< at every node of the grid, along its axes [m]
  ErrorNorms norms;   ///< of it, as of a true one
  OtherLattice lattice = OtherLattice::none;
  std::int64_t cycles = 0; ///< of multigrid, over all lattices
  double seconds = 0;
  std::int64_t bytes = 0; ///< held at the peak, beside the scene's own
};

/// An estimate, or why there is none.
struct ErrorEstimation {
  std::optional<EstimatedError> estimate;
  std::string reason; ///< empty where there is one
};

/// Estimates the error of a displacement from any method of the lattice, in two parts:
///
/// *Of the model and of the algebra.* Prescribed nodes are put in their places; what then is out of balance with the lattice's
/// elasticity (see `coupled`) goes through conjugate gradients around its multigrid until a cycle's step is less than
/// 5 % of the correction. The correction is this part.
///
/// *Of the lattice.* Elasticity on the lattice is itself off, as linear finite elements are. If the first part is below
/// `small_model_error`, the same is answered on half the spacing (up to about ten times the price of `coupled`), and twice the difference is
/// this part: right for order 1, some half too much for order 2, so that it is rather above the truth than below. Where something is held
/// or moved along lines or at points only, four times: less is gained there with every halving. If the first part is not small, or there is
/// no memory for that, and the body is made of blocks of two cells, the lattice of those blocks tells it more roughly, by order 1.5.
///
/// What finite elements are off cannot be told like this: give them no displacement of theirs.
///
/// Where the body turns with its moves (object_frame), elasticity is meant in its frame.
///
/// @param displacement on the scene's grid
/// @return a reason where elasticity has no answer (see solve_coupled), where the scene asks for blocks, where it was stopped, or where there is no memory for what it needs
/// Cost        of answers of `coupled` about ten times theirs; of `limits` and `relaxed` about that of `coupled`
/// Memory      that of `coupled`, and four displacements; eight times that with the finer lattice
/// Repeatable  same bits for any number of threads
/// Source      corrections of the residual by multigrid: Brandt 1977; two lattices: Richardson 1911
/// Checked by  tests/deform/elastic/estimated_error_test.cpp, `maille bench studies` (against quadratic elements)
ErrorEstimation estimate_error(const Scene& scene, const Displacement& displacement,
                               const Control& control = {});

/// A model's error of this part of the displacement hides that of any lattice that is worth using.
inline constexpr double small_model_error = 0.1;

} // namespace maille::deform
