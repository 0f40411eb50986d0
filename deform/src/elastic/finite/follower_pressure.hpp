#pragma once
/// Pressure that follows its faces: normal to each, on its present area.
///
/// The vector area of a face of a cell is half the product of its diagonals, in the plane its edge turned by
/// a right angle; pressure times that goes to its corners in equal parts, as a dead load's force does at
/// rest.
/// Exact for flat faces and for the resultant of any closed surface.

#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"

#include <vector>

namespace maille::deform {

class FollowerPressure {
public:
  FollowerPressure() = default;
  /// @param scene its loads that follow count, in 2D and 3D; its body must outlive this
  explicit FollowerPressure(const Scene& scene);

  bool is_empty() const { return faces_.empty(); }
  /// Adds the forces in a state, dense [N].
  void add_forces(const Displacement& u, Displacement& forces) const;

private:
  struct Face {
    std::vector<std::int64_t> corners; ///< counter-clockwise, seen against the axis of its normal
    double pressure = 0;               ///< on the upper side of the matter > 0; on the lower < 0 [Pa]
    int axis = 0;
  };
  Grid grid_;
  Vec3 origin_{};
  std::vector<Face> faces_;
};

} // namespace maille::deform
