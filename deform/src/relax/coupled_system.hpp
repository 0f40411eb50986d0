#pragma once
/// The operator of `coupled`, whichever way it is stored.

#include "maille/scene/answer.hpp"
#include "relax/stiffened_link.hpp"

#include <cstdint>
#include <functional>
#include <vector>

namespace maille::deform {

class CoupledSystem {
public:
  virtual ~CoupledSystem() = default;
  /// forces = K u, everywhere [N]; dense, [component][node].
  virtual void apply(const Displacement& u, Displacement& forces) = 0;

  /// Whether it has a multigrid of its own, which can be told of links that are stiffer than the matter is.
  virtual bool has_multigrid() const { return false; }
  /// Held for directions, beside the operator and its multigrid.
  virtual std::int64_t bytes() const { return 0; }
  /// The multigrid's operator is K and these from now on. @pre has_multigrid()
  virtual void stiffen(const std::vector<StiffenedLink>&) {}
  struct Direction {
    int iterations = 0;
    bool has_image = false;
  };
  /// direction = about the solution of (K + stiffened links) direction = residual, 0 where components are prescribed: conjugate gradients
  /// around the multigrid in float32, until the residual in its norm is `reduction` of what it was. If it is to be one iteration, then
  /// one cycle alone.
  /// @param most  iterations
  /// @param image = K direction where components are free and 0 elsewhere, to float32, if the system has it at hand; null: not wanted
  /// @pre has_multigrid() and residual is 0 where components are prescribed
  virtual Direction find_direction(const Displacement&, int, double, const std::function<bool()>&,
                                   Displacement&, Displacement*) {
    return {};
  }
};

} // namespace maille::deform
