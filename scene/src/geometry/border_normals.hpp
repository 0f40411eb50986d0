#pragma once
/// The smooth surface that steps of voxels stand for: its normals.

#include "maille/base/grid.hpp"

#include <cstdint>
#include <map>
#include <vector>

namespace maille {

/// A face of a cell, and which way it looks.
struct OrientedFace {
  std::int64_t cell = 0;
  int axis = 0;
  bool upper = false;
};

/// Means of faces' area vectors near a place: those of steps of voxels add up to the smooth surface's.
class BorderNormals {
public:
  /// Radius within which faces count, in the longest spacings; weights fall with distance.
  static constexpr double reach = 3;

  BorderNormals(const Grid& grid, const std::vector<OrientedFace>& faces);
  /// Normal of length 1. @param place in spacings from node 0; zero without a face near it, or where faces
  /// cancel
  Vec3 at(const Vec3& place) const;
  /// The middle of a face, in spacings from node 0.
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
