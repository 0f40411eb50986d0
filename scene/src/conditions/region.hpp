#pragma once
/// The nodes, cell faces or cells that a hold, a move, a load or a label selects: common to image files and
/// arrays of programs.

#include "maille/materials/toml_reader.hpp"
#include "maille/scene/scene.hpp"
#include "voxels/label_cells.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille::reader {

/// A set of nodes, of outer faces of cells and of whole cells: a leaf (a face of the bounding box, a box, a
/// sphere, listed nodes), or a combination of several.
class Region {
public:
  /// A face of the bounding box: `x-`, `x+`, ...; nothing if the scene has no such face.
  /// @param dimension of the scene; 0 if it is not known
  static std::optional<Region> face(std::string_view name, int dimension);
  /// Between two opposite corners, inclusive, object's frame [m].
  static Region box(const Vec3& first, const Vec3& second);
  /// The same in another frame; `placement` maps the object's frame to it.
  static Region placed_box(const Vec3& first, const Vec3& second, const Placement& placement);
  /// @param centre in the object's frame [m]
  static Region sphere(const Vec3& centre, double radius);
  /// Nodes by their numbers in the body's grid, in any order; duplicates count once.
  static Region numbered(std::vector<std::int64_t> nodes);
  /// The same; faces and cells are limited to those of `cells`. Both in any order.
  static Region numbered(std::vector<std::int64_t> nodes, std::vector<std::int64_t> cells);
  /// The same for cells and all their nodes.
  static Region of_cells(const Grid& grid, std::vector<std::int64_t> cells);
  /// Union, intersection or complement of regions, for nodes, faces and cells.
  static Region any(std::vector<Region> parts);
  static Region all(std::vector<Region> parts);
  static Region outside(Region part);

  /// Sorted, each once.
  std::vector<std::int64_t> nodes(const Specimen& specimen) const;
  /// The nodes of `among` that are corners of its cells, and these cells: a node on a border between two
  /// boxes, labels or masks belongs partly to each. Unchanged if there are none, and for faces of the
  /// bounding box and listed nodes.
  void share_nodes(const Specimen& specimen, const std::vector<std::int64_t>& among,
                   std::vector<std::int64_t>& nodes, std::vector<std::int64_t>& cells) const;
  std::vector<FaceLoad> faces(const Specimen& specimen) const;
  /// The same faces with weights. Around partially filled cells the surface is distributed over all faces
  /// across which the tissue fraction falls, weighted by the decrease, down to empty cells; such faces in a
  /// row are in the region if the outermost is. Weight 1 on faces of whole cells.
  std::vector<std::pair<FaceLoad, double>> weighted_faces(const Specimen& specimen) const;
  /// True if all corners of the cell are in it, and it is one of its cells; false for a face of the box.
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
  /// Combines `is_in` of the parts by the kind. @pre any, all or outside
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
  std::optional<std::vector<std::int64_t>> cells_; ///< of numbered: the only cells in it; sorted, unique
  std::vector<Region> parts_;                      ///< of any, all (one or more) and outside (one)
};

/// Tolerance for equal places [m]: viewers round coordinates, and NIfTI stores its affine in float32.
double place_tolerance(const Specimen& body);

/// Extent of a body for messages: along its grid and, if its image defines a world, there [mm].
std::string reach_in_words(const Specimen& body);

/// The frame of a body from an image: origin at the outer corner of voxel 0, axes along the image's.
Placement placement_of(const ImageInfo& info);
/// Range of all grey values except 0, for material 0.
std::vector<LabelRange> all_but_zero();

/// Appends a range; a fault of `path` if it overlaps another. @param text the range as requested
void add_label(const LabelRange& range, const std::string& text, int line, const std::string& path,
               std::vector<LabelRange>& ranges, FaultList& faults);

/// A requested label and its line.
struct NamedLabel {
  std::string text;
  int line = 0;
};
/// Adds a fault for each label without voxels: it is a mistake, and its region would be missing silently.
/// @param names of the ranges, in their order
void check_labels_occur(const LabelCensus& census, const std::vector<NamedLabel>& names,
                        const std::string& path, FaultList& faults);

/// Fills grid, placement and materials of a body's cells, not cropped to its matter. Two-dimensional if the
/// image has one slice.
/// @param coarsen voxels of a cell along each axis
/// @param census  counts every voxel
/// @throws InputError for a faulty image; then the body is unchanged
void fill_cells(const LayeredImage& image, const Index3& coarsen, const std::vector<LabelRange>& ranges,
                LabelCensus& census, Specimen& body);

/// True if the body has matter; else adds a fault.
bool has_matter(const Specimen& body, const std::string& path, int line, FaultList& faults);

} // namespace maille::reader
