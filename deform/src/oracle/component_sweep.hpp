#pragma once
/// Gauss-Seidel sweeps over one displacement component.

#include "lattice/link_table.hpp"

#include <vector>

namespace maille::deform {

class ComponentSweep {
public:
  /// @param table must outlive this; @param u one value per node of the body, prescribed ones in place [m]
  ComponentSweep(const LinkTable& table, int component, std::vector<double> u,
                 const std::vector<Prescribed>& prescribed);

  /// Every free node moves to the mean of its neighbours, within its links' limits. @return the largest move
  double relax_elastic();
  /// Every free node that breaks limits moves as little as they ask. @return the largest move
  double relax_deformable();

  int component() const { return component_; }
  const std::vector<double>& values() const { return u_; }
  /// Nodes whose component is free and that have a neighbour, ascending.
  const std::vector<std::int32_t>& free_nodes() const { return free_; }
  std::int64_t bytes() const;

private:
  template<class Rule>
  double sweep(Rule rule);

  const LinkTable& table_;
  int component_;
  std::vector<double> u_;
  std::vector<std::int32_t> free_;
};

} // namespace maille::deform
