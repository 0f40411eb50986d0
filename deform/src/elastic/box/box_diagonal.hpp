#pragma once
/// The diagonal of the operator of a box, and how far its eigenvalues lie above it.

#include "elastic/box/box_kernel.hpp"

namespace maille::deform {

/// What the operators along one axis have on their diagonals at one node (see BoxCoefficients).
struct BoxDiagonal {
  double mass = 0, link = 0, change = 0;

  BoxDiagonal(const BoxAxis<double>& axis, int i)
      : mass(axis.mass[i - 1] + axis.mass[i]), link(axis.link[i - 1] + axis.link[i]),
        change((axis.mass[i - 1] > 0 ? 1 : 0) - (axis.mass[i] > 0 ? 1 : 0)) {}
  double share() const { return mass / 2; }
};

/// The diagonal of component c of a node.
double box_diagonal(const BoxCoefficients& coefficients, int c, const BoxDiagonal& x, const BoxDiagonal& y,
                    const BoxDiagonal& z);

/// The largest eigenvalue of the operator over its diagonal on a small box of regular cells, a little rounded
/// up. That of a larger box is no larger: it is a sum of such.
double largest_eigenvalue_of_block(const BoxCoefficients& coefficients, const Index3& cells);

} // namespace maille::deform
