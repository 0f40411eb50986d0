#pragma once
/// The loops of XPBD over all nodes and all distance constraints.

namespace maille::lab {

/// The constraints of one direction: distances between nodes (x, y, z) and (x, y, z) + step.
struct XpbdDirection {
  int step[3]; ///< what comes last and is not 0 is 1, and step[0] is -1 only where there is another
  float rest[3];
  float rest_length;
  /// Per node at the near end, over mass / time step^2 in units of the state; 0: no constraint
  const float* stiffness;
  float* multiplier; ///< per node at the near end
};

/// Everything in units in which the time step is 1. Arrays per grid node, x fastest, rows without gaps.
struct XpbdState {
  int nodes[3];
  float* u[3];                  ///< displacement
  float* before[3];             ///< at the end of the last time step
  float* start[3];              ///< where velocities and forces took the nodes, before their multipliers did
  const float* inverse_mass[3]; ///< by component; 0 where prescribed
  const float* load[3];         ///< force; null without loads
  int n_directions;
  const XpbdDirection* direction;
};

/// start = u + keep (u - before) + load * inverse mass, before = the old u, u = start.
/// @param push_again adds to u what all multipliers' forces have added to the old `start`
void xpbd_coast(const XpbdState& state, float keep, bool push_again);
/// Adds to u what the multipliers' forces do to nodes at `start`, where directions have changed since they
/// were found.
void xpbd_push(const XpbdState& state);
/// One Gauss-Seidel iteration over all constraints, from the first row to the last or back.
void xpbd_solve(const XpbdState& state, bool backward);
/// Sums over all nodes and components.
struct XpbdProgress {
  double climb = 0;  ///< of (start - u) (u - before): positive where the steps point uphill
  double motion = 0; ///< of (u - before)^2
};
XpbdProgress xpbd_progress(const XpbdState& state);

} // namespace maille::lab
