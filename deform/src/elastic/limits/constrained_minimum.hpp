#pragma once
/// The least elastic energy within the limits of the links: last step of every algorithm of `coupled`.
///
/// Minimises 1/2 u . K u - f . u subject to low <= D u <= high, where D u are the stretches of the links.
/// Augmented Lagrangian: each link l that was ever outside its range has a multiplier y_l and the term rho
/// w_l / 2 (v - z)^2, with v = D u + y and z = v clamped to the range (ActiveLinks). For fixed y the function
/// is convex and piecewise quadratic; `gap` is the sum of w (D u - z)^2, `penalties` are the stiffnesses rho
/// w of the active links.
///
/// Two algorithms. newton(): truncated Newton steps with a direction from the system's own
/// multigrid and penalties, and an exact line search (best_step). go_on_by_gradients(): conjugate gradients
/// around the componentwise preconditioner, used if the system finds no directions or Newton does not finish
/// because links keep switching. GradientSpace and GradientWatch are the callbacks of the second one only.
///
/// start_from_coarser() takes start and multipliers from the body with every second node. obey_limits() is
/// the entry: it also projects the result to the nearest feasible state.
///
/// Exact: the limits, after that projection; the line search, to 5 % of its first slope. Heuristic: the
/// penalties rho, the rules for when to improve multipliers, and the error estimate (Nearness).

#include "elastic/componentwise/componentwise_preconditioner.hpp"
#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/krylov/coupled_system.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/field_sums.hpp"
#include "elastic/limits/active_links.hpp"

#include <utility>
#include <vector>

namespace maille::deform {

/// See the top of the file. Starts at the elastic answer. A link whose limits are one number needs no special
/// case.
///
/// Same bits for any number of threads.
///
/// Source  Bertsekas 1982, Constrained Optimization and Lagrange Multiplier Methods, chapter 3; Nocedal and
///         Wright 2006, section 7.1; docs/theory.md, sections 2 and 7
/// Checked by  coupled_limits_test.cpp, relaxed_test.cpp, box_penalties_test.cpp
class ConstrainedMinimum : private GradientSpace, private GradientWatch {
public:
  /// All but `components` must outlive this. @param components that are solved for, one or all: the fields
  /// that the system is given have no others, but for the state. @param moduli whose links weigh as the
  /// penalties do. @pre task.limits
  ConstrainedMinimum(const CoupledTask& task, CoupledSystem& system, const CellModuli& moduli,
                     const std::vector<int>& components);

  /// Changes `u`, which holds the prescribed values, and adds to the answer's iterations. @return false if
  /// stopped, or given up
  bool solve(Displacement& u, Answer& answer);
  /// Begins with the multipliers of the same body on every second node.
  void take_over(const ConstrainedMinimum& coarse);
  /// Begins with those of an earlier answer for the same body.
  void begin_with(const List<KeptMultiplier>& multipliers);
  List<KeptMultiplier> multipliers() const;
  bool finds_directions() const { return system_.finds_directions(); }
  /// Estimated, over the answer: of displacements after Newton's steps, else in the energy norm.
  double error() const { return error_; }
  /// The memory of a field, once nothing is to be solved any more.
  Displacement give_away_field() { return std::move(residual_); }
  /// Adds what the limits pull with at every node [N]. @param forces of the components that are solved for
  void add_forces_of_limits(Displacement& forces) const;
  std::size_t n_active() const;

private:
  using Products = CoupledSystem::Products;
  enum class End { found, stopped, used_up };

  void begin(const Displacement& u);
  void set_penalty(double rho);
  /// Passes the active links to `knows`, if they changed since the last call. @param knows has
  /// set_penalties(list)
  template<class Knows>
  void set_penalties(Knows& knows);
  bool are_penalties_out_of_date() const;
  /// direction_ and image_ have memory from now on.
  void make_room();
  Displacement field() const;
  /// Calls visit(place in components_, node) for all that is prescribed of those.
  template<class Visit>
  void for_each_prescribed(const Visit& visit) const;
  void find_image();
  double best_step(double slope, double curvature) const;
  double slope_of_energy(double descent) const;
  double work_of_loads() const;
  double gap() const;
  void update_forces(const Displacement& u);
  /// The same for an unchanged state, in which no further link can become active.
  void update_forces_of_known(const Displacement& u);
  void improve_multipliers(const Displacement& u);
  /// Adds a step along direction_, whose image is image_, to state, residual and energy.
  void move(Displacement& u, double step);

  // constrained_newton.cpp
  bool may_keep_directions() const;
  Products find_direction(Answer& answer);
  bool take_newton_step(Displacement& u, const Products& products);
  /// @param most iterations
  End newton(Displacement& u, Answer& answer, int most);

  bool go_on_by_gradients(Displacement& u, Answer& answer);
  double precondition() override;
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;
  double overlap() const override { return overlap_; }
  bool goes_on() override;
  bool goes_on_from(double product) override;
  bool goes_on_after(double step, double product) override;

  const CoupledTask& task_;
  CoupledSystem& system_;
  std::vector<int> components_;                ///< of all fields but the state, in this order
  double penalty_;                             ///< of gradients, over the links' own stiffness
  std::vector<std::vector<bool>> is_fixed_;    ///< [place in components_][node], nodes without tissue too
  bool has_voids_ = false;                     ///< nodes without tissue
  std::vector<List<double>> loads_;            ///< likewise [N]; empty: none along that component
  std::vector<ActiveLinks> links_;             ///< per entry of components_
  ComponentwisePreconditioner preconditioner_; ///< of gradients
  List<PenaltyLink> penalties_;
  bool has_penalties_ = false;
  Displacement residual_;
  Displacement direction_, image_; ///< unless the system keeps them
  Displacement correction_;        ///< once gradients need it
  mutable FieldSums sums_;
  double rounding_ = 0; ///< links outside by less are within [m]
  double energy_ = 0;   ///< u . K u [J]
  double error_ = 1;
  double slope_ = 0, curvature_ = 0; ///< of the energy along the direction

  bool is_box_ = false;           ///< see is_uniform_box
  bool keeps_directions_ = false; ///< the system does
  int depth_ = 1;                 ///< iterations per direction
  double size_ = 0;               ///< u . u at the start [m^2]
  double length_ = 0;             ///< of the last step, 1 for a whole one
  double way_ = 0;                ///< u . K u of that, or of the whole one if that is more [J]

  Displacement* state_ = nullptr; ///< of go_on_by_gradients()
  double overlap_ = 0;            ///< of the new residual with the correction for the one before [N m]
  Answer* answer_ = nullptr;
  std::optional<bool> is_found_; ///< once gradients have ended
  double gap_ = 0;               ///< before the step
};

template<class Knows>
void ConstrainedMinimum::set_penalties(Knows& knows) {
  if (!are_penalties_out_of_date())
    return;
  penalties_.clear();
  for (ActiveLinks& links : links_)
    links.set_penalties(penalties_);
  knows.set_penalties(penalties_);
  has_penalties_ = true;
}

/// Changes `u` to the interpolated optimum of the coarser body, itself begun like this, and gives `minimum`
/// its multipliers. Which links bind, and how much, is found there at an eighth of the price. It is a start
/// only: that moves, materials and holes are known to half as many nodes costs iterations, not accuracy.
/// @param u holds the prescribed values, and keeps them
/// @return  false, and nothing is changed, if the body has an odd number of cells along an axis, or too few,
///          or if what is held of the coarser one lets it move rigidly, or if it was stopped
bool start_from_coarser(const CoupledTask& task, ConstrainedMinimum& minimum, Displacement& u);

/// Where the elastic answer breaks the limits, changes it to the least energy within them (see
/// ConstrainedMinimum), and then to the nearest feasible state, of which strain energy, residual, reactions
/// and message of the answer speak thereafter. Otherwise changes nothing.
/// @param is_converged the answer is the elastic one; if false the state only becomes feasible
/// @return    whether the answer is what was asked for
bool obey_limits(const CoupledTask& task, CoupledSystem& system, bool is_converged, Displacement& u,
                 Answer& answer);

} // namespace maille::deform
