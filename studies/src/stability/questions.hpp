#pragma once
/// Scene files of extremes, put together from parts.

#include "maille/scene/scene.hpp"

#include <string>

namespace maille::studies {

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

} // namespace maille::studies
