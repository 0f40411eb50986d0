#pragma once
/// Displacements from an image or a list of points, evaluated at any place.

#include "maille/images/image.hpp"

#include <optional>

namespace maille {

struct Specimen;

/// True if the ending of the name is that of an image, for read_image; false: the file is a table.
bool is_image_file(const std::filesystem::path& file);

/// Vectors on the voxels of an image: multilinear between voxel centres, constant half a voxel beyond the
/// outer ones.
class DisplacementImage {
public:
  /// @param metres per unit of the file's values
  /// @param body   defines the world of places (see on_body); voxels outside its matter that are 0 or NaN are
  /// extrapolated
  ///               linearly from the body's voxels. May be null
  /// @throws InputError: the file is no image, or its number of values per voxel does not match its axes
  /// (three; two or three for one slice)
  DisplacementImage(const std::filesystem::path& file, double metres, const Specimen* body);

  /// Displacement at a point of the world [m], along the axes of the file's vectors; along those of the
  /// body's object if the header states the axes. Nothing outside the image, or if a surrounding voxel is not
  /// finite.
  std::optional<Vec3> at(const Vec3& point) const;
  bool is_along_object() const { return to_object_.has_value(); }
  const ImageInfo& info() const { return image_.info; }

private:
  void continue_matter(const std::filesystem::path& file, const Specimen& body);

  Image image_;
  double metres_;
  std::optional<std::array<Vec3, 3>> to_object_; ///< rows of the matrix from the file's vectors
};

struct FileUnits;

/// A displacement that was observed at a point.
struct DisplacementPoint {
  Vec3 place{}, displacement{}; ///< in the file's frame [m]
  std::optional<double> sigma;  ///< standard deviation of each component, > 0 [m]
  int line = 0;
};

/// Reads CSV: columns `x`, `y`, `z`, `ux`, `uy`, `uz`, each `[unit]` or in metres, and optionally `sigma`;
/// `z` and `uz` may be left out.
/// @param scene units of the scene that names the file: if they are not metres, columns must state theirs
/// @throws InputError with every fault, including sigma <= 0 and two displacements at one place
std::vector<DisplacementPoint> read_displacement_points(const std::filesystem::path& file,
                                                        const FileUnits* scene = nullptr);

} // namespace maille
