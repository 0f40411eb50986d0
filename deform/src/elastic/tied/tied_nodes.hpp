#pragma once
/// Projection onto displacements in which tied nodes move together, and forces of ties.

#include "elastic/model/fixed_mask.hpp"
#include "maille/scene/answer.hpp"

#include <Eigen/Core>

#include <vector>

namespace maille::deform {

/// Connected ties form a cluster, the copies of one node of a body; clusters are independent.
class TiedNodes {
public:
  /// @param fixed_components which no projection changes
  /// @param diagonal of the operator [N/m]: the stiffer of two nodes moves less
  TiedNodes(const NodeTies& ties, const FixedMask& fixed_components, const Displacement& diagonal);

  /// u += the smallest change, in the norm of the diagonal, that makes tied nodes move together where
  /// components are free.
  void bring_together(Displacement& u) const;
  /// f -= what ties take of it: the transpose of the projection, bring_together() of a displacement that is 0
  /// where components are fixed.
  void share(Displacement& f) const;
  /// f -= the forces of ties that balance f where components may move; what is left where they are fixed is
  /// what holds them. @param f forces K u - loads, everywhere
  void take_out_tie_forces(Displacement& f) const;

private:
  struct Component {
    std::int64_t node = 0;
    int component = 0;
  };
  struct Cluster {
    std::vector<Component> free, fixed;
    Eigen::MatrixXd of_free, of_fixed; ///< ties, a row each, of these components
    Eigen::MatrixXd gain;              ///< free x ties: minus it times the gaps brings them together
  };
  static Eigen::VectorXd gather(const Displacement& field, const std::vector<Component>& components);

  std::vector<Cluster> clusters_;
};

/// What the preconditioner of tied nodes holds single bodies by: at each tied node springs to the ground
/// along its ties, of which so much as of a bar of the body's length; where they rub those of friction, too.
List<NodalSpring> springs_at_ties(const Scene& scene, const Displacement& diagonal);

/// Largest opening of a tie [m], and its number.
struct OpenTie {
  double gap = 0;
  const NodeTie* tie = nullptr;
};
OpenTie widest_tie(const NodeTies& tied, const Displacement& u);

} // namespace maille::deform
