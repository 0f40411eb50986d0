#pragma once
/// What a smooth, rigid ball meets in an elastic layer.

namespace maille::lab {

struct LayerContact {
  double force = 0;  ///< [N]
  double radius = 0; ///< of a contact with Hertz's pressure of the same mean square distance [m]
};

/// A rigid ball pressed without friction into a layer that is bonded to rigid ground and has no end sideways:
/// Hertz's contact where it is thick.
///
/// Source  transform of a layer's surface: Johnson 1985, Contact Mechanics, 5.8; the dual integral equations
///         with it as a Fredholm equation: Lebedev and Ufliand 1958 (J. Appl. Math. Mech. 22); a sphere in
///         place of a paraboloid: Sneddon 1965 (Int. J. Eng. Sci. 3)
/// @param ball radius [m] @param depth of its lowest point under the surface [m], 0 < depth < ball
/// @param thickness of the layer [m] @param youngs_modulus [Pa] @param poisson_ratio -1 to 0.5
/// Range   exact but for sums over 60 points: to 1e-3
LayerContact ball_on_layer(double ball, double depth, double thickness, double youngs_modulus,
                           double poisson_ratio);

} // namespace maille::lab
