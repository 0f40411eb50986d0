#pragma once
/// The nodes, cell faces or cells that a hold, a move, a load or a label selects: the same for images that
/// are read and for a program's arrays.

#include "maille/materials/toml_reader.hpp"
#include "maille/scene/scene.hpp"
#include "voxels/label_cells.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille::reader {

/// A set of nodes, of outer faces of cells and of whole cells: a leaf (a face of the bounding box, a box, a
/// sphere, listed nodes), or several joined.
class Region {
public:
  /// A face of the bounding box: `x-`, `x+`, ...; nothing where the scene has no face of that name.
  /// @param dimension of the scene; 0 where it is not known
  static std::optional<Region> face(std::string_view name, int dimension);
  /// Between two opposite corners, inclusive, object's frame [m].
  static Region box(const Vec3& first, const Vec3& second);
  /// The same in another frame, which `placement` carries the object's into.
  static Region placed_box(const Vec3& first, const Vec3& second, const Placement& placement);
  /// @param centre in the object's frame [m]
  static Region sphere(const Vec3& centre, double radius);
  /// Nodes by their numbers in the body's grid, in any order; of a number that is there twice, one counts.
  static Region numbered(std::vector<std::int64_t> nodes);
  /// The same; of faces and cells only those of `cells`. Both in any order.
  static Region numbered(std::vector<std::int64_t> nodes, std::vector<std::int64_t> cells);
  /// The same of cells and all their nodes.
  static Region of_cells(const Grid& grid, std::vector<std::int64_t> cells);
  /// What is in at least one of them, in each of them, or not in the one: nodes, faces and cells alike.
  static Region any(std::vector<Region> parts);
  static Region all(std::vector<Region> parts);
  static Region outside(Region part);

  /// Sorted, each once.
  std::vector<std::int64_t> nodes(const Specimen& specimen) const;
  /// The nodes of `among` that are its own as corners of cells, and these cells: a node on a border between
  /// two boxes, labels or masks counts in part on either side. Both stay as they are where none is, and of
  /// faces of the bounding box and of listed nodes.
  void share_nodes(const Specimen& specimen, const std::vector<std::int64_t>& among,
                   std::vector<std::int64_t>& nodes, std::vector<std::int64_t>& cells) const;
  std::vector<FaceLoad> faces(const Specimen& specimen) const;
  /// The same, each with its part of the surface: of cells that are tissue in part the surface lies on all
  /// faces across which less is tissue, each by how much less, up to void: those in a row are in the region
  /// where the outermost is. 1 on faces of whole cells.
  std::vector<std::pair<FaceLoad, double>> weighted_faces(const Specimen& specimen) const;
  /// True if all corners of the cell are in it, and it is one of its cells; of a face of the box, none are.
  bool contains_cell(const Specimen& specimen, std::int64_t cell) const;

private:
  enum class Kind { face, box, placed_box, sphere, numbered, any, all, outside };

  explicit Region(Kind kind) : kind_(kind) {}
  static Region joined(Kind kind, std::vector<Region> parts);
  bool contains(const Specimen& specimen, const Index3& node) const;
  /// @param node, cell one of the corners of the other
  bool contains_corner(const Specimen& specimen, const Index3& node, std::int64_t cell) const;
  bool shares_nodes() const;
  bool contains_face(const Specimen& specimen, std::int64_t cell, int axis, bool upper) const;
  bool has_face(const Specimen& specimen, std::int64_t cell, int axis, bool upper) const;
  /// `is_in` of the parts, joined as the kind says. @pre any, all or outside
  template<class IsIn>
  bool join(IsIn&& is_in) const;

  Kind kind_;
  int face_axis_ = -1; ///< of a face
  bool upper_ = false;
  Vec3 low_{}, high_{}; ///< of a box
  Placement placement_; ///< of a placed box
  Vec3 centre_{};       ///< of a sphere
  double radius_ = 0;
  std::vector<std::int64_t> numbers_;              ///< of nodes; sorted, unique
  std::optional<std::vector<std::int64_t>> cells_; ///< of numbered: no others are in it; sorted, unique
  std::vector<Region> parts_;                      ///< of any, all (one or more) and outside (one)
};

/// Places that differ by less are one [m]: a viewer rounds coordinates, and NIfTI keeps its affine in
/// float32.
double place_tolerance(const Specimen& body);

/// Where a body reaches, for messages: along its grid and, where it stands in a world, there [mm].
std::string reach_in_words(const Specimen& body);

/// The frame of a body that is an image: its origin at the outer corner of voxel 0, its axes along the
/// image's.
Placement placement_of(const ImageInfo& info);
/// Every grey value but 0, for material 0.
std::vector<LabelRange> all_but_zero();

/// Appends a range; a fault of `path` where it overlaps another. @param text as it is asked for
void add_label(const LabelRange& range, const std::string& text, int line, const std::string& path,
               std::vector<LabelRange>& ranges, FaultList& faults);

/// A label as it is asked for, and its line.
struct NamedLabel {
  std::string text;
  int line = 0;
};
/// A label that no voxel has is a slip: what it was meant for would be missing without a word.
/// @param names of the ranges, in their order
void check_labels_occur(const LabelCensus& census, const std::vector<NamedLabel>& names,
                        const std::string& path, FaultList& faults);

/// Grid, placement and materials of a body's cells, not cut down to its matter. Two-dimensional where the
/// image has one slice.
/// @param coarsen voxels of a cell along each axis
/// @param census  is told of every voxel
/// @throws InputError of the image; then the body is as it was
void fill_cells(const LayeredImage& image, const Index3& coarsen, const std::vector<LabelRange>& ranges,
                LabelCensus& census, Specimen& body);

/// A body without a cell of matter is a fault.
bool has_matter(const Specimen& body, const std::string& path, int line, FaultList& faults);

} // namespace maille::reader
