#pragma once
/// The operator of `coupled`, whichever way it is stored.

#include "maille/scene/answer.hpp"
#include "relax/stiffened_link.hpp"

#include <vector>

namespace maille::deform {

class CoupledSystem {
public:
  virtual ~CoupledSystem() = default;
  /// forces = K u, everywhere [N]; dense, [component][node].
  virtual void apply(const Displacement& u, Displacement& forces) = 0;

  /// Whether it has a multigrid of its own, which can be told of links that are stiffer than the matter is.
  virtual bool has_multigrid() const { return false; }
  /// The multigrid's operator is K and these from now on. @pre has_multigrid()
  virtual void stiffen(const std::vector<StiffenedLink>&) {}
  /// correction = one cycle for (K + stiffened links) correction = residual, 0 where components are prescribed.
  /// @pre has_multigrid() and residual is 0 there. @return residual . correction [J]
  virtual double precondition(const Displacement&, Displacement&) { return 0; }
};

} // namespace maille::deform
