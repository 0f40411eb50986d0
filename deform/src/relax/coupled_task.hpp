#pragma once
/// What the ways to the elastic state of `coupled` are asked, and the state itself.

#include "maille/scene/answer.hpp"
#include "method.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace maille::deform {

struct CoupledTask {
  const Scene& scene;
  const Control& control;
  const std::vector<Prescribed>& prescribed; ///< the scene's, cut back where limits ask for it
  ThreadTeam& team;
  const Clock& clock;
  std::function<bool()> must_stop;
  const LinkLimits* limits = nullptr; ///< null: none bind
  /// Where to begin, on the scene's grid; prescribed components are put in their places. Null: the way's own start.
  const Displacement* start = nullptr;
};

/// How a round of conjugate gradients ended: as good as was asked, or as rounding lets it be; with a residual that must be found anew; by the
/// caller; or with an error that does not fall and is no rounding.
enum class CoupledRound { finished, used_up, stopped, stalled };

/// Each fills in displacement, iterations, residual, strain energy, setup time, bytes and algorithm, and the reactions if it
/// came to the end. @return false if it was stopped, or gave up
using CoupledWay = bool(const CoupledTask& task, Answer& answer);

/// Any body in 1D, 2D and 3D: conjugate gradients around the separable model's multigrid. In 3D the tests' oracle.
CoupledWay solve_coupled_body;
/// A box of one material in 3D: conjugate gradients around the operator's own multigrid. @pre is_uniform_box(scene)
CoupledWay solve_coupled_box;

/// Any body in 3D: conjugate gradients around the operator's own multigrid, on which loosely joined pieces stay apart.
CoupledWay solve_coupled_matter;

/// The quickest of them that can take the scene.
CoupledWay& coupled_way(const Scene& scene);
/// How many of the threads that a caller allows are worth waking for a scene.
int coupled_threads(const Scene& scene, const Control& control);
/// Why full elasticity has no answer to the scene; empty if it has.
std::string reason_to_refuse_coupled(const Scene& scene);

/// True if every cell of a 3D grid holds the same matter, turned the same way.
bool is_uniform_box(const Scene& scene);

/// How far conjugate gradients are from the answer, from the energies that their last steps brought.
class CoupledError {
public:
  void add(double gain) { gains_.push_back(gain); }
  /// In the energy norm, of the state some steps ago over `energy` of the answer; 1 before there are enough.
  /// Source  Strakos and Tichy 2002, equation 4.4
  double relative_to(double energy) const {
    if (gains_.size() < delay)
      return 1;
    double recent = 0;
    for (std::size_t i = gains_.size() - delay; i < gains_.size(); ++i)
      recent += gains_[i];
    return std::sqrt(recent / std::max(energy, std::sqrt(std::numeric_limits<double>::min())));
  }
  /// Of the present state, if the energies go on falling at the slower of their last two rates; twice that, to be safe. For
  /// preconditioners so good that waiting some steps for certainty would cost as much as the answer.
  double extrapolated_relative_to(double energy) const {
    if (gains_.size() < delay)
      return 1;
    const double* const last = &gains_.back();
    const double rate = std::max({last[0] / last[-1], last[-1] / last[-2], least_rate});
    if (rate >= 1)
      return 1;
    return 2 * std::sqrt(last[0] * rate / (1 - rate) /
                         std::max(energy, std::sqrt(std::numeric_limits<double>::min())));
  }
  bool is_empty() const { return gains_.empty(); }

private:
  /// Steps after which the energy that they brought says how far the state was from the answer.
  static constexpr std::size_t delay = 3;
  static constexpr double least_rate = 0.02; ///< less is luck
  std::vector<double> gains_;
};

constexpr int most_coupled_iterations = 5000;

/// Whether what is left of the error is no more than rounding leaves, where it no longer falls. If it is more, a preconditioner in float32 has
/// met matter whose moduli it cannot tell from nothing. @param left r . B r; @param energy of the state, or of its first error, whichever is
/// more; both in the same unit
inline bool is_left_by_rounding(double left, double energy) {
  constexpr double told_from_rounding = 1e-6; ///< in the energy norm
  return std::abs(left) <= told_from_rounding * told_from_rounding * energy;
}

} // namespace maille::deform
