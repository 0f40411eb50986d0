#pragma once
/// Elimination of unknowns by ties between nodes: labels that slide on each other.

#include "discretization/body.hpp"

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/vector.h>

#include <utility>
#include <vector>

namespace maille::fem_ref {

/// Each tie makes one unknown dependent on the others (Gauss-Jordan elimination, node by node of the body).
/// Mid-points of edges and faces of a border are tied like their corners.
class Ties {
public:
  Ties() = default;
  /// @param body of the scene, after split_borders() or without ties
  template<int dim>
  Ties(const Scene& scene, const Body<dim>& body, const std::vector<bool>& is_prescribed);

  bool empty() const { return followers_.empty(); }
  /// Sets dependent unknowns from the independent ones.
  void distribute(dealii::Vector<double>& u) const;
  /// Moves forces on dependent unknowns to the independent ones, prescribed ones included.
  void condense(dealii::Vector<double>& forces) const;
  /// Adds constraint lines for dependent unknowns; prescribed unknowns count as 0 in them.
  void constrain(const std::vector<bool>& is_prescribed,
                 dealii::AffineConstraints<double>& constraints) const;
  /// True for dependent unknowns.
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
  std::vector<bool> follows_; ///< by unknown; empty: no dependent unknowns
};

} // namespace maille::fem_ref
