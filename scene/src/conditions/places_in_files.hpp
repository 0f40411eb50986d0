#pragma once
/// Regions defined by files: voxels of a mask, nodes near a triangulated surface, nodes near landmarks.

#include "conditions/anatomy.hpp"

#include <filesystem>

namespace maille::reader {

/// Voxels of an image whose grey values are in one of the ranges.
/// Cost: reading the image, 27 look-ups per node. @throws InputError for a faulty image
/// @param ranges        empty: every value but 0
/// @param resample      use the voxel at the centre of each cell, for any grid of the image
/// A fault if the image's voxels are not those of the body, or those that its cells consist of; a cell is in
/// the region if at least half of its voxels are.
OrFault<Region> region_of_mask(const std::filesystem::path& file, const std::vector<LabelRange>& ranges,
                               bool resample, const Specimen& body);

using Triangle = std::array<Vec3, 3>;
/// A surface from an STL file (binary or text) or an OBJ file.
struct SurfaceMesh {
  std::vector<Triangle> triangles;      ///< in the file's unit, or [m]
  std::optional<CoordinateFrame> frame; ///< for files of 3D Slicer, which state `SPACE=LPS` or `SPACE=RAS`
};
/// @throws InputError: missing, truncated, neither form, not finite, or no triangle
SurfaceMesh read_stl(const std::filesystem::path& file);
/// The same for Wavefront OBJ; faces with more than three corners are cut into triangles.
SurfaceMesh read_obj(const std::filesystem::path& file);
/// By the file name ending: .obj, else STL. @param metres length of the file's unit
SurfaceMesh read_surface_mesh(const std::filesystem::path& file, double metres = 1);

/// Points of 3D Slicer's markups, .fcsv or .mrk.json.
struct Landmarks {
  std::vector<Vec3> points; ///< [m]
  std::vector<std::string> names;
  std::optional<CoordinateFrame> frame; ///< as the file states
};
/// @throws InputError: missing, not in its form, not finite, or without a point
Landmarks read_landmarks(const std::filesystem::path& file);

/// Distance of a point from a triangle, also a degenerate one.
double distance(const Vec3& point, const Triangle& triangle);

/// Nodes of the body within a distance [m] of any of the triangles; object's frame.
std::vector<std::int64_t> nodes_near(const std::vector<Triangle>& triangles, double within,
                                     const Specimen& body);

} // namespace maille::reader
