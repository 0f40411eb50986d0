#pragma once
/// Unknowns that ties between nodes leave no choice: labels that slide on each other.

#include "discretization/body.hpp"

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/vector.h>

#include <utility>
#include <vector>

namespace maille::fem_ref {

/// In every tie one unknown follows from the others (Gauss-Jordan elimination, node by node of the body).
/// Nodes at the middle of edges and faces of a border are tied as their corners are.
class Ties {
public:
  Ties() = default;
  /// @param body of the scene, which split_borders() made or which has no ties
  template<int dim>
  Ties(const Scene& scene, const Body<dim>& body, const std::vector<bool>& is_prescribed);

  bool empty() const { return followers_.empty(); }
  /// Puts unknowns that follow where the others have them.
  void distribute(dealii::Vector<double>& u) const;
  /// Forces on unknowns that follow act on what they follow, prescribed ones too.
  void condense(dealii::Vector<double>& forces) const;
  /// Adds lines for unknowns that follow; what is prescribed is 0 in them.
  void constrain(const std::vector<bool>& is_prescribed,
                 dealii::AffineConstraints<double>& constraints) const;
  /// True of unknowns that follow.
  bool follows(unsigned unknown) const { return !follows_.empty() && follows_[unknown]; }

private:
  struct Follower {
    unsigned unknown = 0;
    std::vector<std::pair<unsigned, double>> of;
  };
  void eliminate(const std::vector<unsigned>& nodes,
                 const std::vector<std::pair<std::pair<unsigned, unsigned>, Vec3>>& rows,
                 const std::vector<bool>& is_prescribed);

  std::vector<Follower> followers_;
  std::vector<bool> follows_; ///< by unknown; empty: none does
};

} // namespace maille::fem_ref
