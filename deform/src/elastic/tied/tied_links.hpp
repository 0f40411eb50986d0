#pragma once
/// The links of a body whose nodes are tied, in lists: what they pull with, and their limits.

#include "elastic/model/cell_moduli.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/link_limits.hpp"
#include "parallel/thread_team.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace maille::deform {

/// Per component b the energy sum over links of w / 2 (d u_b)^2, and the ranges of d u_b. Every link within
/// limits has a part z of the state, in its range, and a multiplier y, both [m]: see LeastWithinLimits.
///
/// Same bits for any number of threads: components go to different ones.
/// Memory  32 bytes a link and component; within limits 32 more
class TiedLinks {
public:
  /// @param weight of a link from a node along an axis, of a component [N/m]
  TiedLinks(const Scene& scene,
            const std::function<double(const Index3& tail, int axis, int component)>& weight);

  /// forces += factor K u, K what the links pull with.
  void add_forces(const Displacement& u, double factor, Displacement& forces, ThreadTeam& team) const;
  /// The diagonal of K [N/m].
  Displacement diagonal() const;

  void set_limits(const Scene& scene, const LinkLimits& limits);
  /// Parts are what is nearest to the state within limits, and nothing is known of multipliers.
  void begin(const Displacement& u, ThreadTeam& team);
  /// forces += factor sum of w (z - y), at the ends of links.
  void add_pull_to_parts(double factor, Displacement& forces, ThreadTeam& team) const;
  /// Primal and dual residual of a round: violation, and change; the largest of all links [m].
  struct Round {
    double apart = 0; ///< of the state from the parts
    double moved = 0; ///< of the parts
  };
  /// New parts for a state, then new multipliers. @param forward more than 1: parts are for the state so far
  /// beyond the one before
  Round take(const Displacement& u, double forward, ThreadTeam& team);
  void scale_multipliers(double factor);
  std::int64_t n_active() const; ///< links at a limit, of all components

private:
  struct Link {
    std::int64_t near = 0, far = 0;
    double weight = 0;
  };
  struct Limit {
    double low = 0, high = 0, part = 0, multiplier = 0;
  };
  std::size_t n_nodes_ = 0; ///< of the grid
  std::array<List<Link>, 3> links_;
  std::array<List<Limit>, 3> limits_; ///< of each link, where there are some
  std::array<List<std::int8_t>, 3> axes_;
};

/// Weighed as the componentwise model does.
TiedLinks links_of_matter(const Scene& scene, const CellModuli& moduli);

} // namespace maille::deform
