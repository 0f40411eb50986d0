#pragma once
/// All methods by name, from deform and fem_ref, in one function; and the most accurate finite-element answer
/// within given memory and time.
///
/// Methods caches set-up for further scenes of the same body: the mesh and factor of finite elements, and the
/// ElasticBody of `coupled`. Answers differ by less than the tolerance from those of a new object.

#include "maille/deform/solve.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/answer.hpp"

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

/// Names of all methods: those of deform, then fem_q1 and fem_q2, then calculix, which requires that program
/// to be installed.
std::vector<std::string> all_methods();
bool is_method(std::string_view name);

/// Solves scenes by method name. Finite elements cache their mesh and factor or hierarchy while body,
/// materials and prescribed components stay the same, as in the load steps of a series. `coupled` does the
/// same if it is given a cached body.
class Methods {
public:
  /// @param recover_stress  see fem_ref::Options
  explicit Methods(fem_ref::LinearSolver solver = fem_ref::LinearSolver::automatic,
                   bool recover_stress = false);
  ~Methods();
  /// From now on `coupled` solves with that cached body, which must outlive this.
  void keep(deform::ElasticBody& body) { body_ = &body; }
  Methods(const Methods&) = delete;
  Methods& operator=(const Methods&) = delete;

  /// @pre is_method(name)
  Answer answer(const Scene& scene, std::string_view name, const Control& control = {});
  /// True if all ranks must solve together, with distributed work (docs/cluster.md); else only the first rank
  /// solves.
  bool is_for_all_ranks(const Scene& scene, std::string_view name) const;
  /// Linear solver of finite elements.
  fem_ref::LinearSolver solver() const { return solver_; }

private:
  fem_ref::LinearSolver solver_;
  deform::ElasticBody* body_ = nullptr;
  std::array<std::unique_ptr<fem_ref::Solver>, 2> of_degree_;
};

/// Solves one scene by a temporary Methods, without caching.
Answer answer_by(const Scene& scene, std::string_view name, const Control& control);

/// Default reference for `methods`: fem_q2 if it is among them, else fem_q1.
std::string default_reference(const std::vector<std::string>& methods);

struct BestReference {
  /// Method "best", at the nodes of the scene; without reactions if the mesh is finer than the scene's.
  Answer answer;
  /// Difference from the answer on the next coarser solved mesh. Each halving, and the step from linear to
  /// quadratic, at least halves the error (order 1 in the worst singular corner), so the remaining error is
  /// at most this difference: an upper estimate, not a bound. Nothing if only one mesh was affordable.
  std::optional<ErrorNorms> estimated_error;
  std::string coarser; ///< the coarser mesh, in words
};

/// Solves the scene by linear elements, quadratic ones, and quadratic ones on cells halved once, twice, three
/// times: the finest of these with a forecast of at most `seconds` and 60 % of the free memory, and the next
/// coarser one.
/// @return status refused if even linear elements exceed these budgets
BestReference best_reference(const Scene& scene, double seconds, const Control& control, Methods& methods);

} // namespace maille::studies
