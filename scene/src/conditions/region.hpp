#pragma once
/// The nodes, cell faces or cells that a hold, a move or a load selects.

#include "maille/scene/scene.hpp"

#include <optional>
#include <string_view>
#include <vector>

namespace maille::reader {

class Region {
public:
  /// A face of the bounding box: `x-`, `x+`, ...; nothing where the scene has no face of that name.
  /// @param dimension of the scene; 0 where it is not known
  static std::optional<Region> face(std::string_view name, int dimension);
  /// Between two opposite corners, inclusive, object's frame [m].
  static Region box(const Vec3& first, const Vec3& second);
  /// Nodes by their numbers in the body's grid, in any order; of a number that is there twice, one counts.
  static Region numbered(std::vector<std::int64_t> nodes);

  std::vector<std::int64_t> nodes(const Specimen& specimen) const;
  std::vector<FaceLoad> faces(const Specimen& specimen) const;
  /// True if all corners of the cell are in it; of a face, none are.
  bool contains_cell(const Specimen& specimen, std::int64_t cell) const;

private:
  enum class Kind { face, box, numbered };

  explicit Region(Kind kind) : kind_(kind) {}
  bool contains(const Specimen& specimen, const Index3& node) const;

  Kind kind_;
  int face_axis_ = -1; ///< of a face
  bool upper_ = false;
  Vec3 low_{}, high_{};               ///< of a box
  std::vector<std::int64_t> numbers_; ///< sorted, unique
};

} // namespace maille::reader
