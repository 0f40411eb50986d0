#pragma once
/// Active links of one component: those that ever exceeded their limits, with multipliers and penalty forces.
///
/// Notation: w the link's weight in the componentwise model [N/m], rho the penalty factor [1], y the
/// multiplier [m] (a displacement, scaled by rho w to a force), v = D u + y, z = v clamped to the link's
/// range. The set only grows during a solve; a link inside its range with y = 0 exerts no force. `gap`
/// measures the violation, `descent` the distance from the minimum for the present multipliers.

#include "elastic/krylov/elastic_operator.hpp"
#include "elastic/krylov/kept_body.hpp"
#include "elastic/links/interval_field.hpp"
#include "elastic/model/cell_moduli.hpp"
#include "elastic/model/fixed_mask.hpp"
#include "maille/scene/answer.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::deform {

/// Penalty over the links' own stiffness [1]: a higher one gives better multipliers, and costs iterations.
/// Measured on boxes and a calf: 10 and 200 take up to twice as long.
inline constexpr double penalty_factor = 50;
/// Rebuild the preconditioner when this share of the active links has changed.
inline constexpr double enough_changes = 0.01;

/// Convergence of an augmented Lagrangian: distance from the minimum for its multipliers (descent, the
/// residual times its preconditioned correction) and from the limits (gap, the sum of w (D u - z)^2), both
/// squared [J].
struct Nearness {
  double descent = 0, gap = 0;

  /// Weights of both squares in the squared error, measured against long runs.
  static constexpr double part_of_descent = 0.25, part_of_gap = 36;
  /// In the energy norm, over that of the state, whose square is given.
  double error(double energy) const {
    return std::sqrt((part_of_descent * std::max(descent, 0.0) + part_of_gap * gap) / energy);
  }
  /// True if better multipliers help more than better displacements. `descent` includes the penalties, which
  /// weigh the gap by `rho`; hence the factor.
  bool asks_for_multipliers() const {
    constexpr double enough_descent = 100;
    return !(descent > enough_descent * gap);
  }
};

/// Every link l that was ever outside its range has a multiplier y and exerts the force
///
///   rho w (v - z),  v = D u + y,  z = v within the range,
/// w its weight in the componentwise model: the slope of rho w / 2 (v - z)^2, the method of multipliers. The
/// update of the multiplier is y = v - z. All other links have y = 0 and are inside their ranges; they cost
/// nothing. Few links are active, as a rule.
///
/// Same results for any number of threads.
class ActiveLinks {
public:
  /// All must outlive this. @param fixed nodes without matter too @param place of the component among those
  /// of `fixed`
  ActiveLinks(const Scene& scene, const CellModuli& moduli, const LinkLimits& limits, int component,
              const FixedMask& fixed, std::size_t place, double rho);

  /// Adds links that are outside their ranges by more than `rounding` [m].
  void add_violated(std::span<const double> u, double rounding, ThreadTeam& team);

  /// Adds links with multipliers from those of the same body on every second node.
  void begin_with(const ActiveLinks& coarse);

  /// Adds links with the multipliers of an earlier answer; those of other components are ignored.
  void begin_with(const List<KeptMultiplier>& multipliers);
  /// Adds what begin_with() of a later question takes.
  void keep_multipliers(List<KeptMultiplier>& multipliers) const;

  /// The slope and the curvature, along a direction and at a step along it, of the sum of rho w / 2
  /// (v - z)^2.
  struct Slope {
    double first = 0, second = 0;
  };
  /// @param along a direction, per node
  void set_direction(std::span<const double> along) {
    for (Link& link : links_)
      link.change = along[link.far] - along[link.near];
  }
  Slope slope_at(double step) const;

  /// Recomputes v and adds the change of the forces on free nodes to `residual` [N].
  void update_forces(std::span<const double> u, std::span<double> residual);
  /// y = v - z. The caller updates the forces after it.
  void update_multipliers();

  /// Adds rho w of the links outside their ranges to a list.
  void set_penalties(List<PenaltyLink>& penalties);
  /// Number of links that became active or inactive since penalties were last set.
  std::size_t n_changed() const;
  std::size_t n_outside() const;

  /// Sum of w (D u - z)^2 [J].
  double gap() const;
  /// Adds, at every node, the force that a fixed component exerts against the limits [N].
  void add_forces(std::span<double> forces) const;
  std::size_t size() const { return links_.size(); }

private:
  struct Link {
    std::size_t near = 0, far = 0;
    int axis = 0;
    bool was_outside = false; ///< when penalties were last set
    double weight = 0, low = 0, high = 0;
    double y = 0, v = 0, force = 0;
    double change = 0; ///< of v along the direction, per step
    double excess(double value) const { return value < low ? value - low : value > high ? value - high : 0; }
  };
  void spread(const Link& coarse, const Grid& coarse_grid, std::vector<double>& y,
              std::vector<std::size_t>& reached) const;
  bool is_fixed(std::size_t node) const { return fixed_(place_, node); }
  Link link_at(int axis, std::size_t node) const;
  void find_in_plane(int z, const double* u, double rounding, List<Link>& found) const;

  const Scene& scene_;
  const CellModuli& moduli_;
  const FixedMask& fixed_;
  std::size_t place_;
  int component_;
  double rho_;
  IntervalField ranges_;
  List<std::uint8_t> is_known_; ///< per node: bit a for the link along a
  List<Link> links_;
};

} // namespace maille::deform
