#pragma once
/// The operator of `coupled`, whichever way it is stored.

#include "maille/scene/answer.hpp"

namespace maille::deform {

class CoupledSystem {
public:
  virtual ~CoupledSystem() = default;
  /// forces = K u, everywhere [N]; dense, [component][node].
  virtual void apply(const Displacement& u, Displacement& forces) = 0;
};

} // namespace maille::deform
