#pragma once
/// Normals of the smooth surface that a voxel staircase represents.

#include "maille/base/grid.hpp"

#include <cstdint>
#include <map>
#include <vector>

namespace maille {

/// A face of a cell and its direction.
struct OrientedFace {
  std::int64_t cell = 0;
  int axis = 0;
  bool upper = false;
};

/// Means of the area vectors of nearby faces: those of a voxel staircase sum to that of the smooth surface.
class BorderNormals {
public:
  /// Radius of the mean, in units of the longest spacing; weights fall with distance.
  static constexpr double reach = 3;

  BorderNormals(const Grid& grid, const std::vector<OrientedFace>& faces);
  /// Unit normal. @param place in spacings from node 0 @return zero if no face is near, or if faces cancel
  Vec3 at(const Vec3& place) const;
  /// The centre of a face, in spacings from node 0.
  static Vec3 middle(const Grid& grid, const OrientedFace& face);

private:
  struct Patch {
    Vec3 middle, area;
  };
  Index3 bucket(const Vec3& place) const;

  Vec3 spacing_;
  double radius_;
  std::map<Index3, std::vector<Patch>> patches_; ///< by buckets as wide as the reach
};

} // namespace maille
