#pragma once
/// Builds a scene from data in memory: a box or an array of labels, materials, holds, moves and loads.
///
/// Everything is in SI units and in the object's frame: axes along the grid, origin at the outer corner of
/// the first cell or voxel. Rules and error messages are those of scene files (docs/scene.md); docs/cpp.md
/// has whole programs.

#include "maille/base/grid.hpp"
#include "maille/images/image.hpp"
#include "maille/materials/fault.hpp"
#include "maille/scene/scene.hpp"

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace maille {

struct KeyTable; // maille/materials/toml_reader.hpp

struct SceneAndMeasures; // maille/scene/measure/measure.hpp

/// Voxel (i, j, k) is element first + i stride[0] + j stride[1] + k stride[2] of the array. i, j, k run along
/// the array's axes x, y, z for any order in memory; a stride may be negative (a flipped axis) or larger than
/// necessary (a part of an array).
struct ArrayLayout {
  Index3 size{0, 0, 0}; ///< voxels along x, y, z, > 0; one along z: a scene of two dimensions
  std::array<std::int64_t, 3> stride{0, 0, 0}; ///< in elements, not bytes
  std::int64_t first = 0;                      ///< element of voxel (0, 0, 0)

  /// x fastest: Fortran order of array(x, y, z), C order of array[z][y][x]; NIfTI, VTK, ITK.
  static ArrayLayout x_fastest(const Index3& size);
  /// z fastest: C order of array[x][y][z]; numpy's default.
  static ArrayLayout z_fastest(const Index3& size);

  std::int64_t n_voxels() const { return std::int64_t{1} * size[0] * size[1] * size[2]; }
  std::int64_t element(const Index3& at) const {
    return first + at[0] * stride[0] + at[1] * stride[1] + at[2] * stride[2];
  }
  /// True if sizes are > 0, every voxel is an element of an array of `n_elements`, and there are at least as
  /// many elements as voxels.
  bool fits(std::int64_t n_elements) const;
};

/// Rows of the 4 x 4 matrix from voxel indices (i, j, k, 1) to the centre of the voxel in the world [m]:
/// NIfTI's affine in m instead of mm. Columns 0 to 2 are perpendicular to 1e-3, with any lengths (the
/// spacing) and either handedness.
using Affine = std::array<std::array<double, 4>, 4>;

/// The affine of a grid of voxels.
/// @param spacing of voxels along each axis of the array [m]
/// @param origin centre of voxel (0, 0, 0) in the world [m]
/// @param direction rows of the 3 x 3 matrix from the array's axes to the world; columns of length 1
Affine affine_of(const Vec3& spacing, const Vec3& origin = {0, 0, 0},
                 const std::array<Vec3, 3>& direction = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});

/// A material by its name in the library (`muscle/soleus`), or as an object.
using MaterialChoice = std::variant<std::string, Material>;

/// Nodes, faces of cells, or cells between two opposite corners, inclusive, object's frame [m].
struct BoxRegion {
  Vec3 first{}, second{};
};

/// Nodes by number in the builder's grid, SceneBuilder::grid(): i + nodes x (j + nodes y k). Any order;
/// duplicates count once. A face or cell is selected if all its corners are listed.
struct NodeList {
  std::vector<std::int64_t> nodes;
};

/// Region of a hold, a move or a load: a face of the bounding box of the matter (`x-`, `x+`, ...) or another
/// region of scene files (`{ label = 17, touching = 30 }`; numbers in SI), a box, or nodes.
using Where = std::variant<std::string, BoxRegion, NodeList>;

/// Collects a scene and checks it as a whole: only build() reports errors, all at once. A builder can be
/// copied, changed and built again. Memory: four bytes per voxel of labels, as long as the builder exists.
class SceneBuilder {
public:
  /// @param name of the scene in results; also its title, until there is one
  explicit SceneBuilder(std::string name = "scene");
  SceneBuilder& title(std::string text);

  /// A box of cells, all of matter; replaces the body.
  /// @param dimension 1, 2 or 3; @param cells along each axis, 1 along axes beyond the dimension
  /// @param spacing of cells [m], > 0; also along axes beyond the dimension
  SceneBuilder& box(int dimension, const Index3& cells, const Vec3& spacing);

  /// Voxels of labels, one per cell; replaces the body. `material` selects the labels of the body; 0 is
  /// background unless it has its own material. The array is copied. The grid of the scene is cropped to the
  /// body (see first_cell); node lists and boxes refer to the whole array.
  /// @param voxels_to_world see Affine, affine_of
  SceneBuilder& labels(std::span<const std::uint8_t> values, const ArrayLayout& layout,
                       const Affine& voxels_to_world);
  SceneBuilder& labels(std::span<const std::uint16_t> values, const ArrayLayout& layout,
                       const Affine& voxels_to_world);
  SceneBuilder& labels(std::span<const std::int16_t> values, const ArrayLayout& layout,
                       const Affine& voxels_to_world);
  SceneBuilder& labels(std::span<const std::int32_t> values, const ArrayLayout& layout,
                       const Affine& voxels_to_world);
  SceneBuilder& labels(std::span<const std::int64_t> values, const ArrayLayout& layout,
                       const Affine& voxels_to_world);
  /// World axes of the array's affine, so that regions may use anatomical directions (`end = "distal"`);
  /// default unknown. Applies only to the last array given.
  SceneBuilder& world(WorldAxes axes);

  /// Material of a box, or of every non-zero voxel of an array. Excludes materials by label.
  SceneBuilder& material(MaterialChoice choice);
  /// Material of the voxels with that label. A label without voxels is an error.
  SceneBuilder& material(std::int64_t label, MaterialChoice choice);
  /// Assumption for the third direction of a two-dimensional scene (default: plane strain).
  SceneBuilder& plane(PlaneAssumption assumption);

  /// One direction of fibres, object's frame, of any length > 0; default x.
  SceneBuilder& fibre(const Vec3& direction);
  /// One direction per cell, object's frame, any length > 0 in matter, ignored elsewhere; replaces fibre().
  /// @param layout of the box's cells, or of the voxels
  SceneBuilder& fibres(std::span<const std::array<float, 3>> directions, const ArrayLayout& layout);

  /// Fixes nodes.
  /// @param axes components, e.g. `xz`; absent: all
  SceneBuilder& hold(Where where, std::optional<std::string> axes = {});
  /// Displaces nodes. @param by [m]
  SceneBuilder& move(Where where, const Vec3& by, std::optional<std::string> axes = {});
  /// Force per area [Pa] on the outer faces of cells in the region; in 1D the cross-section is 1 m^2, in 2D
  /// the thickness 1 m.
  SceneBuilder& traction(Where where, const Vec3& pascal);
  /// Force [N], in 2D per metre of thickness, spread evenly over the area of the same faces.
  SceneBuilder& force(Where where, const Vec3& newton);
  /// Acceleration [m/s^2]; several calls add up.
  SceneBuilder& gravity(const Vec3& acceleration);
  /// Active stress >= 0 [Pa] of the fibres in the region; without a region, of all cells. Calls add up.
  SceneBuilder& contraction(double pascal, std::optional<Where> where = {});

  /// Source of the limits of links; without this call the elastic methods have none. `given` limits must be
  /// valid ratios (see NeighbourLimits); for `material` or `failure` every material must define them.
  SceneBuilder& limits(const LimitSettings& settings);
  /// Tolerance between 0 and 1, sweeps from 1 to 10^9, increments from 0 (as many as needed) to 10^4.
  SceneBuilder& relaxation(const RelaxationSettings& settings);
  /// Default: small.
  SceneBuilder& strain(Strain strain);

  /// A quantity to evaluate on answers, by the keys of a `[[measure]]` of a scene file, in TOML:
  /// measure("pull", R"(force = "move[1]")"). Lengths and angles without a unit are in SI. Places are in the
  /// object's frame of the whole array; holds and moves are numbered from 1 in the order of their calls.
  SceneBuilder& measure(std::string name, std::string keys);

  /// Keys of a scene file, in TOML, for a body of labels(): [specimen] without `shape` and `image` (labels,
  /// material, fibre, coarsen), [[hold]], [[move]], [limits] and so on; they replace the other calls. Lengths
  /// and angles have a unit, or `units` states it. @param folder for relative file names
  SceneBuilder& keys(std::string toml, std::filesystem::path folder = {});
  /// The same as a table; without labels() it defines the whole scene, including [specimen].
  SceneBuilder& keys(std::shared_ptr<const KeyTable> table, std::filesystem::path folder = {});

  /// The grid as given, which node lists refer to; empty before the body is valid. O(1)
  Grid grid() const;

  /// The checked scene: prescribed components sorted and unique, grid cropped to matter, without loose
  /// pieces.
  /// @throws InputError with every fault; a fault's key is its name in a scene file (`move[2].where`), file
  /// and line are empty
  /// Cost  O(voxels + cells + nodes of conditions log of them)
  Scene build() const;
  /// The same without an exception: the scene, or every fault.
  std::variant<Scene, std::vector<Fault>> try_build() const;
  /// The scene and its measures; their faults are reported with all others.
  SceneAndMeasures build_with_measures() const;

private:
  class Assembly; ///< one build

  struct BoxBody {
    int dimension = 0;
    Index3 cells{};
    Vec3 spacing{};
  };
  struct LabelBody {
    Image image;
    std::vector<Fault> faults; ///< in layout, affine and labels; if there are any, `image` may be empty
  };
  struct FibreArray {
    Index3 size{};
    std::vector<std::array<float, 3>> values; ///< x fastest
    std::vector<Fault> faults;
  };
  struct LabelMaterial {
    std::optional<std::int64_t> label;
    MaterialChoice choice;
  };
  struct Condition {
    Where where;
    Vec3 by{};
    std::optional<std::string> axes;
  };
  enum class LoadKind { traction, force, gravity, contraction };
  struct Load {
    LoadKind kind = LoadKind::traction;
    std::optional<Where> where;
    Vec3 vector{}; ///< for a contraction: its stress, in x
  };

  template<class Label>
  SceneBuilder& copy_labels(std::span<const Label> values, const ArrayLayout& layout, const Affine& affine);

  std::string name_;
  std::optional<std::string> title_;
  std::variant<std::monostate, BoxBody, LabelBody> body_;
  std::vector<LabelMaterial> materials_;
  std::optional<PlaneAssumption> plane_;
  Vec3 fibre_{1, 0, 0};
  std::optional<FibreArray> fibres_;
  std::vector<Condition> holds_, moves_;
  std::vector<Load> loads_;
  std::vector<std::pair<std::string, std::string>> measures_; ///< name, keys
  LimitSettings limits_;
  RelaxationSettings relaxation_;
  Strain strain_ = Strain::small;
  std::optional<std::string> keys_;
  std::shared_ptr<const KeyTable> table_; ///< in place of keys_
  std::filesystem::path folder_;          ///< of keys_
};

/// Position of a body's cell (0, 0, 0) in the grid before cropping: voxel (i, j, k) is cell (i, j, k) minus
/// this; the same for nodes. Not for scenes on a rotated lattice.
Index3 first_cell(const Specimen& specimen);

} // namespace maille
