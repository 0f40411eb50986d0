#pragma once
/// Displacements that an image or a list of points has, at any place.

#include "maille/images/image.hpp"

#include <optional>

namespace maille {

struct Specimen;

/// Whether read_image takes it, by the ending of its name, rather than as a table.
bool is_image_file(const std::filesystem::path& file);

/// Vectors on the voxels of an image, between their centres linear along each axis (multilinear); half a
/// voxel beyond the outer centres it is what they have.
class DisplacementImage {
public:
  /// @param metres per unit of the file's values
  /// @param body   in whose world places are (see on_body); voxels beside it that are 0 or NaN are
  /// extrapolated
  ///               linearly from the body's voxels. May be null
  /// @throws InputError: the file is no image, or its values a voxel do not match its axes (three; of one
  /// slice
  ///         two or three)
  DisplacementImage(const std::filesystem::path& file, double metres, const Specimen* body);

  /// At a point of the world [m], along the axes in which the file's vectors are [m], of the body's
  /// object where the header states them. Nothing outside, and where a voxel around it is not finite.
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

/// A displacement that was seen at a point.
struct DisplacementPoint {
  Vec3 place{}, displacement{}; ///< in the frame that the file is in [m]
  std::optional<double> sigma;  ///< standard deviation of each component, > 0 [m]
  int line = 0;
};

/// Reads CSV: columns `x`, `y`, `z`, `ux`, `uy`, `uz`, each `[unit]` or in metres, and `sigma` if wanted; `z`
/// and `uz` may be left out.
/// @param scene of the scene that names the file: where it has other units than metres, columns need theirs
/// @throws InputError with every fault; a sigma that is not > 0 is one, and a place with two displacements
std::vector<DisplacementPoint> read_displacement_points(const std::filesystem::path& file,
                                                        const FileUnits* scene = nullptr);

} // namespace maille
