#pragma once
/// The operator of bodies with tied nodes, for conjugate gradients and limits.
///
/// K is that of the bodies; ties are constraints, eliminated by TiedNodes. The preconditioner treats single
/// bodies, each held by springs where it is tied, and brings their answers together: a Neumann-Neumann method
/// whose coarse space is in the springs. Single bodies are preconditioned by the componentwise model, which
/// knows the penalties of limits; a kind of K may have a better way as long as there are none.

#include "elastic/componentwise/componentwise_preconditioner.hpp"
#include "elastic/tied/tied_nodes.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace maille::deform {

class TiedModel : public ComponentwisePreconditioned {
public:
  /// @param task outlives it
  /// @param moduli of the links that precondition, and that limits penalise
  /// @param diagonal of K [N/m]
  /// @param springs to the ground that hold single bodies, ascending by node
  TiedModel(const CoupledTask& task, CellModuli moduli, const Displacement& diagonal,
            List<NodalSpring> springs)
      : ComponentwisePreconditioned(task, std::move(moduli), all_components(task.scene), std::move(springs)),
        fixed_(task.scene.specimen, task.prescribed), ties_(task.scene.tied, fixed_, diagonal),
        shared_(task.scene.specimen.grid) {}

  void precondition(const Displacement& residual, Displacement& correction) final {
    shared_ = residual;
    ties_.share(shared_);
    std::ranges::fill(correction.values(), 0.0);
    precondition_bodies(shared_, correction);
    ties_.bring_together(correction);
  }

  const TiedNodes& ties() const { return ties_; }
  const FixedMask& fixed() const { return fixed_; }

protected:
  /// Preconditions the bodies without ties. @param correction 0 at first
  virtual void precondition_bodies(const Displacement& residual, Displacement& correction) {
    ComponentwisePreconditioned::precondition(residual, correction);
  }

private:
  FixedMask fixed_;
  TiedNodes ties_;
  Displacement shared_;
};

/// Settings for a K whose links are not the penalised ones.
struct SearchScale {
  double stiffer = 1; ///< factor on the penalties
  double sharper = 1; ///< of the tolerance, which is divided by it
};

/// Minimises the energy within limits (see ConstrainedMinimum), starting at u, then projects to the nearest
/// feasible state, in which ties may open by as much as the residual of the answer. Adds to iterations, and
/// states in the message of the answer where borders stay open.
/// @param loads    [component][node], empty: none [N]; @param scale of the search
/// @param knows_forces  reactions are wanted: those of the least energy
/// @return  whether every tie is closed to the scene's tolerance of the largest displacement
/// Checked by  tests/deform/elastic/tied/tied_limits_test.cpp
bool keep_within_limits(TiedModel& model, const Loads& loads, const SearchScale& scale, bool knows_forces,
                        Displacement& u, Answer& answer);

/// Reactions of all prescribed components. @param forces K u - loads plus forces of limits; changed
std::vector<double> reactions_of_tied(const TiedModel& model, Displacement& forces);

/// field -= loads; empty: none.
void subtract_loads(const Loads& loads, Displacement& field);

} // namespace maille::deform
