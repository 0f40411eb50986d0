#pragma once
/// What `studies/lab/run stability` asks: scene files of extremes put together from parts, and answers
/// that are
/// known without solving anything.

#include "maille/scene/scene.hpp"
#include "stability/extremes.hpp"

#include <string>

namespace maille::lab {

/// A box of one matter; every part as a scene file has it.
struct Question {
  std::string cells = "[8, 8, 8]", spacing = "0.001";
  std::string material = "{ youngs_modulus = 10000, poisson_ratio = 0.3 }";
  std::string fibre = {};
  std::string limits = {};     ///< the lines of [limits]; empty: none
  std::string conditions = {}; ///< [[hold]], [[move]] and [[load]]
  std::string relaxation = {};

  std::string text() const;
  /// @throws InputError
  Scene scene() const;
};

/// Given limits, the same along all axes.
std::string given_limits(double stretch, double compress, double shear);

/// One face along `axis` held, the other moved by that much [m] along it, the sides free to follow: a uniform
/// strain, if the matter's axes are those of the grid.
std::string pulled(int dimension, int axis, double by);
/// Held at one end along x, the other end taken along by three numbers, as a scene file has them.
std::string clamped(const std::string& by);
/// Held below; four by four nodes about the middle of the upper face of 8 x 8 x 8 cells are pushed in.
/// @param spacing, depth [m]
std::string poked(const Vec3& spacing, double depth);
/// A node is moved.
std::string moved_node(const Vec3& position, const Vec3& by);

/// u = strain x for coupled and finite elements; for methods whose components do not feel each other only the
/// component `axis`, the others at rest. Holds for `limits` where they are taut.
Truth uniform_strain(const Vec3& strain, int axis);
/// The component x of layers across x, as springs in series share a pull: stiffnesses of the cells along x.
/// The other components at rest.
Truth in_series(const std::vector<double>& stiffness, double by);
/// The whole body moves by that; where limits leave slack, only by methods that relax: others let it lag
/// behind.
Truth shift(const Vec3& by, bool has_slack);
/// The body turns as a whole, as its handles do.
Truth rigid_turn();

} // namespace maille::lab
