#pragma once
/// The multigrid of the body at rest, for a body that has turned in parts.

#include "elastic/corotated/corotated_elasticity.hpp"
#include "elastic/krylov/coupled_task.hpp"

#include <memory>

namespace maille::deform {

/// One multigrid cycle of `coupled`'s operator on the body at rest.
class RestPreconditioner {
public:
  virtual ~RestPreconditioner() = default;
  /// correction = B residual, symmetric and positive definite on components that are free, zero on others;
  /// dense, [N] and [m].
  virtual void apply(const Displacement& residual, Displacement& correction) = 0;
  virtual std::int64_t bytes() const = 0;
};

/// That of the way which `coupled` takes for the body. @param task must outlive it
std::unique_ptr<RestPreconditioner> make_rest_preconditioner(const CoupledTask& task);

/// The same for the bent body: forces are turned back node by node, by the mean of the frames around, and the
/// correction is turned forth. In coordinates that turn with the body its stiffness is nearly that at rest;
/// what is left is of the order of a cell over the radius of a bend. So the hierarchy is made once and serves
/// every state.
///
/// Nodes of which only some components are free stay unturned: their directions are the world's.
class CorotatedPreconditioner {
public:
  explicit CorotatedPreconditioner(const CoupledTask& task);

  void turn_with(const CorotatedElasticity& elasticity);
  /// See RestPreconditioner. @param residual changed
  void apply(Displacement& residual, Displacement& correction);
  std::int64_t bytes() const;

private:
  void turn(Displacement& field, bool forth) const;

  const CoupledTask& task_;
  std::unique_ptr<RestPreconditioner> at_rest_;
  std::vector<bool> may_turn_;               ///< by node
  std::vector<Eigen::Quaterniond> rotation_; ///< by node
};

} // namespace maille::deform
