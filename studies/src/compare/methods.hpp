#pragma once
/// All methods by name, of deform and of fem_ref, behind one function; and the finest finite-element answer
/// that fits into memory.
///
/// Methods keeps what serves the next scene of the same body: the mesh and factor of finite elements, and
/// the ElasticBody of `coupled`. Answers differ by less than the tolerance from those of a new object.

#include "maille/deform/solve.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/answer.hpp"

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

/// Every method's name: those of deform first, then fem_q1 and fem_q2, then calculix, which
/// needs that program to be installed.
std::vector<std::string> all_methods();
bool is_method(std::string_view name);

/// Answers scenes by name. Finite elements keep their mesh and factor or hierarchy from scene to scene, for
/// as long as body, materials and prescribed components stay the same: the load steps of a series are one
/// body. So does `coupled` where it is given a body to keep.
class Methods {
public:
  /// @param recover_stress  see fem_ref::Options
  explicit Methods(fem_ref::LinearSolver solver = fem_ref::LinearSolver::automatic,
                   bool recover_stress = false);
  ~Methods();
  /// From now on `coupled` answers by that body, which must outlive this.
  void keep(deform::ElasticBody& body) { body_ = &body; }
  Methods(const Methods&) = delete;
  Methods& operator=(const Methods&) = delete;

  /// @pre is_method(name)
  Answer answer(const Scene& scene, std::string_view name, const Control& control = {});
  /// Whether all ranks are to ask for it together: what they share (docs/cluster.md). Else the first alone.
  bool is_for_all_ranks(const Scene& scene, std::string_view name) const;
  /// How finite elements solve.
  fem_ref::LinearSolver solver() const { return solver_; }

private:
  fem_ref::LinearSolver solver_;
  deform::ElasticBody* body_ = nullptr;
  std::array<std::unique_ptr<fem_ref::Solver>, 2> of_degree_;
};

/// The same, once.
Answer answer_by(const Scene& scene, std::string_view name, const Control& control);

/// The reference that `methods` imply: fem_q2 if they name it, else fem_q1.
std::string default_reference(const std::vector<std::string>& methods);

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
