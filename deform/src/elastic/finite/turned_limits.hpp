#pragma once
/// Limits at finite strain: each link is measured in the mean frame of the cells around it.

#include "elastic/finite/finite_elasticity.hpp"
#include "elastic/krylov/elastic_operator.hpp"
#include "elastic/links/interval_field.hpp"
#include "elastic/model/cell_moduli.hpp"
#include "elastic/model/fixed_mask.hpp"

#include "maille/base/arena.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace maille::deform {

/// The term of the limits in the energy, as in ActiveLinks: the sum over links and components of
///
///   rho w / 2 (v - z)^2,  v = c(u) + y,  z = v within the interval,  c(u) = R^T (h e_a + D u) - h e_a,
///
/// with R the mean rotation of the cells around. R depends on u: a link with the force f = rho w (v - z) also
/// turns those cells, by the moment -(h e_a + D u) x R f, which the derivative of the mean shares out among
/// them. So the gradient is exact, and a line search can hold by it. A link between prescribed nodes counts
/// too: free nodes turn its frame.
///
/// Same bits for any number of threads.
/// Checked by  tests/deform/elastic/turned_limits_test.cpp
class TurnedLimits {
public:
  /// All must outlive this.
  TurnedLimits(const Scene& scene, const LinkLimits& limits, ThreadTeam& team);

  /// Adds the gradient [N] to `forces`. @param elasticity last evaluated at u. @return the energy [J]
  double evaluate(const Displacement& u, const FiniteElasticity& elasticity, Displacement& forces);
  /// Adds the change of the forces of the last evaluation for a change p of the displacement, with constant
  /// frames: rho w of the links outside [N].
  void add_tangent(const Displacement& p, Displacement& forces) const;
  /// y = v - z of the last evaluation; evaluate again after it.
  void improve_multipliers();
  /// Sum of w (c - z)^2 at the last evaluation [J].
  double gap() const;
  /// True if more than a few links became active or inactive since the last list of penalties.
  bool are_penalties_out_of_date() const;
  /// rho w of the links outside, in the directions at rest.
  const List<PenaltyLink>& penalties();
  /// Links with a force.
  std::size_t n_active() const { return pulls_.size(); }

private:
  /// A link that is outside its interval, or has a multiplier.
  struct Pull {
    std::int64_t tail = 0;
    int axis = 0;
    Vec3 excess{}, weight{};
    Eigen::Matrix3d frame; ///< of the last evaluation
  };
  struct Measured {
    Eigen::Quaterniond frame;
    Eigen::Vector3d now, change; ///< head - tail [m]; c(u)
  };
  using Multipliers = std::array<List<Vec3>, 3>; ///< [axis][tail], [m]

  Measured measure(const Displacement& u, const FiniteElasticity& elasticity, std::int64_t tail,
                   int axis) const;
  void find_in_plane(int plane, const Displacement& u, const FiniteElasticity& elasticity,
                     List<Pull>& found) const;
  Vec3 weight(const Index3& tail, int axis) const;
  double pull(const Pull& link, const Displacement& u, const FiniteElasticity& elasticity,
              Displacement& forces);
  static std::uint16_t bit(int axis, std::size_t component) {
    return static_cast<std::uint16_t>(1U << (3 * static_cast<std::size_t>(axis) + component));
  }
  std::size_t d() const { return static_cast<std::size_t>(scene_.dimension()); }

  const Scene& scene_;
  ThreadTeam& team_;
  CellModuli moduli_;
  std::vector<IntervalField> intervals_; ///< by component
  FixedMask fixed_;
  Multipliers y_;
  List<Pull> pulls_;
  List<Eigen::Vector3d> moments_; ///< by cell [N m]
  List<PenaltyLink> penalties_;
  List<std::uint16_t> has_penalty_; ///< by tail: see bit()
};

/// Moves free nodes until no link breaks its limits.
///
/// Frames turn with the state and tie the components together, so there is no closed form as there is in the
/// object's frame: links that are outside are brought within one after another, forward and backward through
/// the body, half by either end (Jakobsen 2001), with frames found anew every few sweeps. Sweeps converge to
/// the intervals narrowed at either end, and so end with every link within, after finitely many. Links that
/// have no room (low = high) come to within `tolerance` of their rest length.
///
/// @param u        finite; prescribed components are in their places and stay there
/// @param narrowed by this part of an interval at either end
/// @return         the number of sweeps to where largest_violation_in_blocks is 0 but for rounding; nothing
///                 where they did not converge: as a rule because what is prescribed asks for more than the
///                 limits grant
/// Cost         a microsecond a cell each time that frames are found, some 20 ns a link and sweep
/// Checked by   tests/deform/elastic/turned_limits_test.cpp
std::optional<int> project_in_turned_frames(const Scene& scene, const LinkLimits& limits, Displacement& u,
                                            double narrowed);

} // namespace maille::deform
