#pragma once
/// The parts of the scene reader, one function per table of the file.
///
/// Each part reads its keys, adds a fault for each error, and returns the valid values, so that one pass
/// finds all errors; read_scene throws at the end. Results of earlier parts (units, materials, the specimen)
/// are arguments; parts have no state.

#include "conditions/anatomy.hpp"
#include "conditions/prescribe.hpp"
#include "conditions/region.hpp"
#include "geometry/pieces.hpp"
#include "maille/images/image.hpp"
#include "maille/materials/toml_reader.hpp"
#include "maille/scene/measure/measure.hpp"
#include "maille/scene/scene.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <numbers>
#include <string>

namespace maille::reader {

/// True if a file can be read, is TOML, and has the key, for example "specimen.look".
bool is_set(const std::filesystem::path& file, std::string_view key);

/// Materials of a scene in the order of their numbers; the same text gives the same number.
class MaterialTable {
public:
  /// Number of the material that `node` names or describes; nothing and a fault if it does neither.
  std::optional<std::uint8_t> add(const toml::node& node, const std::string& path, FaultList& faults);
  /// Number of a program's material; equal materials have the same number.
  std::optional<std::uint8_t> add(Material material, const std::string& path, FaultList& faults);
  std::vector<Material> take() { return std::move(materials_); }
  const std::vector<Material>& materials() const { return materials_; }

private:
  std::optional<std::uint8_t> append(Material material, const std::string& path, int line, FaultList& faults);

  std::vector<Material> materials_;
  std::map<std::string, std::uint8_t> number_of_; ///< by library name or TOML text
};

/// A material by its name in the library; nothing and a fault if it is unknown.
std::optional<Material> library_material(const std::string& name, const std::string& path, int line,
                                         FaultList& faults);

/// Resolves a path in a scene, see named_file; nothing and a fault if it cannot be resolved.
std::optional<std::filesystem::path> resolve_path(const std::string& text, const std::string& path, int line,
                                                  FaultList& faults);
/// The file that a key names, relative to the folder of the file that is read.
std::optional<std::filesystem::path> read_file_name(TableReader& table, std::string_view key);
/// `unit` of a surface file, in metres; default mm.
double read_unit(TableReader& table);
/// `labels = 17`, `"17..19"`, or a list of them.
std::vector<LabelRange> read_label_ranges(TableReader& table);

/// Adds the faults of a file that a scene names to those of the scene.
void adopt(const InputError& error, const std::string& path, int line, FaultList& faults);

class LabelCells;
struct LabelRange;

/// Fibres on the two sides of a seam across `axis`: as requested above it, mirrored below.
struct Bipennate {
  std::size_t axis = 0;
  std::optional<double> at; ///< [m]; unset: the centre of the body's box
};

/// Requested fibres: one direction, a bipennate pair, a curve to follow, or an image of tensors.
struct FibreRequest {
  Vec3 direction{1, 0, 0};
  std::optional<Bipennate> bipennate;
  std::vector<Vec3> curve;                       ///< if not empty: points of a FibreCurve
  std::string tensor_image;                      ///< if not empty: image that defines directions
  double smoothing_radius = 0;                   ///< of the tensor image's directions [m]
  CoordinateFrame frame = CoordinateFrame::grid; ///< of `direction` and `curve`
  std::string path;                              ///< of the key
  int line = 0;
};
std::optional<FibreRequest> read_fibre(TableReader& table);
/// True if a `[specimen]` from an image or surfaces has no `fibre`: its axes do not define fibres of muscles.
bool lacks_fibre(const toml::table& specimen);
/// Adds a fault for a missing fibre; `needed_by` has anisotropic constants or active stress.
void add_lack_of_fibre(int line, const std::string& needed_by, FaultList& faults);
/// The normalised direction; nothing if it is zero or not finite.
std::optional<Vec3> unit_vector(Vec3 direction);
/// The direction in a list of `n` numbers, or three; nothing, without a fault, if none exists.
std::optional<Vec3> direction_of(const toml::node& node, std::size_t n);

/// Sets the requested fibres of the body's matter, except those from tensor images. @return false, and a
/// fault, if the body has no position in their frame
bool place_fibres(FibreRequest request, Specimen& body, FaultList& faults);

/// The `[specimen]` table: shape, grid, matter, fibres. Fills scene.specimen, scene.materials, scene.plane.
/// @param labels if not null, receives the label of each cell of an image
/// @param given if not null, the image of the body; then there is neither `shape` nor `image`
/// @return false if conditions cannot be placed on the faulty specimen
bool read_specimen(TableReader& table, Scene& scene, std::vector<float>* labels,
                   const Image* given = nullptr);

/// Defaults for the table of a body.
struct BodyDefaults {
  bool has_material = true;    ///< false: `material` may be absent, then material 0 is undefined
  std::optional<Vec3> spacing; ///< of generated shapes
};
/// `material` of a body. @param is_needed a fault if it is absent
void read_material(TableReader& table, bool is_needed, MaterialTable& materials);
/// The same keys among others: the caller calls `finish`. @param shape value of `shape`
bool read_body(TableReader& table, const std::string& shape, const BodyDefaults& defaults, Scene& scene,
               std::vector<float>* labels);
/// `cells` and `spacing`, as a grid that fits into memory.
std::optional<Grid> read_grid(TableReader& table, const std::optional<Vec3>& default_spacing);
/// `spacing`: one length, or one per axis of the scene. If it is absent `otherwise`, or a fault.
std::optional<Vec3> read_spacing(TableReader& table, int dimension, const std::optional<Vec3>& otherwise);
/// One whole number or a list, each from `least` to `most`; empty for other values.
std::vector<int> whole_numbers(const toml::node& node, int least, int most);
/// `cells = [nx, ny, nz]`, or fewer, or one number; their count is the scene's dimension.
std::optional<std::vector<int>> read_cells(TableReader& table);

/// Materials of a generated shape, one number per cell of the whole grid (no_material: none).
std::vector<std::uint8_t> ellipsoid_cells(const Grid& grid);
/// A spindle along x between two tendons of `tendon_fraction` of its length each; material 0 is the belly, 1
/// the tendon.
std::vector<std::uint8_t> muscle_cells(const Grid& grid, double tendon_fraction);

/// `shape = "image"`. @param labels, given as in read_specimen. @return false if there is no body
bool read_image_specimen(TableReader& table, bool has_material, MaterialTable& materials, Scene& scene,
                         std::vector<float>* labels, const Image* given = nullptr);
/// `shape = "surface"`: `surface` (closed, .stl or .obj; several get the labels 1, 2, ...), `unit`,
/// `spacing`, and the keys for an image's labels and fibres. @return false if there is no body
bool read_surface_specimen(TableReader& table, bool has_material,
                           const std::optional<Vec3>& spacing_otherwise, MaterialTable& materials,
                           Scene& scene, std::vector<float>* labels);
/// The scene defined by the keys of a file. @param given image of its body, instead of a file
/// @throws InputError
SceneAndMeasures scene_of(const toml::table& document, const std::filesystem::path& file,
                          const Image* given = nullptr);
/// True if two images have the same voxels in the same places, to a thousandth of a voxel.
bool have_same_voxels(const ImageInfo& one, const ImageInfo& other);

inline constexpr double widest_smooth = 16; ///< [voxels]; memory and time scale with it

/// `partial_volume` of an image, as requested.
struct PartialVolume {
  enum class From { labels, grey, smooth };
  From from = From::labels;
  double none = 0, full = 1; ///< grey values
  std::string image;         ///< image of grey values; empty: the body's own
  double width = 0;          ///< of smoothing [m]
  double least = 0.05;       ///< tissue fraction of a cell of matter
  int line = 0;
};
/// Nothing if the key is absent or faulty.
std::optional<PartialVolume> read_partial_volume(TableReader& specimen, const Index3& coarsen);
/// Sets the tissue fraction of the body's cells, including cut ones. @param body not cropped
void fill_partial_volume(const PartialVolume& asked, const LayeredImage& image,
                         const std::vector<LabelRange>& ranges, const Index3& coarsen, TableReader& table,
                         Specimen& body);
/// `stiffness` of a body from an image: fills its stiffness_ratio. @param scene null: only faults of the key
void read_stiffness_map(TableReader& specimen, const std::vector<Material>& materials, Scene* scene);

/// Directions from a diffusion-tensor image on the voxels of the label image, smoothed and filled; see
/// FibreField.
/// @throws InputError for a faulty image
void fibres_from_tensors(const std::filesystem::path& file, const FibreRequest& request,
                         const LabelCells& labels, const std::string& path, FaultList& faults,
                         Specimen& specimen);

/// `turn = { angle, axis, about }` of a move; nothing if it is absent, nothing and a fault if it is faulty.
/// @param dimension of the scene; 0 where it is not known
/// @param turns_about_its_middle set if `about` is absent
std::optional<Turn> read_turn(TableReader& table, int dimension, bool& turns_about_its_middle);

/// `course`: a value over the time of a run; nothing if it is absent or faulty.
std::optional<TimeCourse> read_course(TableReader& table);
/// The `[[drive]]` tables: appends their conditions.
void read_drives(TableReader& root, const Scene& scene, bool has_body, std::vector<Condition>& conditions);
/// The `[[sliding]]` tables: fills sliding.
void read_sliding(TableReader& root, Scene& scene, bool has_body);
/// Nodes with springs of loads; faults of the loads are left to read_loads.
std::vector<std::int64_t> nodes_of_foundations(const toml::table& root, const Scene& scene,
                                               const FaultList& faults);

/// Limit of angles: larger ones are a mistake, and would need too many increments [rad].
inline constexpr double largest_turn = 200 * std::numbers::pi;

/// `frame`, or `otherwise` if the key is absent; nothing and a fault for another word.
std::optional<CoordinateFrame> read_frame(TableReader& table, CoordinateFrame otherwise);

/// Frame of the places and vectors of a table, by its key `frame`.
struct TableFrame {
  CoordinateFrame frame = CoordinateFrame::grid;
  Placement placement;     ///< maps the object's frame to it
  Placement body_in_world; ///< of the body, for any frame

  Vec3 vector_in_object(const Vec3& vector) const;
  /// The same rotation in the object's frame; a mirrored frame reverses it.
  Turn in_object(Turn turn) const;
};
/// A fault if the body has no position in that frame, or is not three-dimensional.
/// @param body  null if it is faulty: its frames are assumed to be equal
TableFrame read_table_frame(TableReader& table, int dimension, const Specimen* body);

/// A corner of a box, or a centre: one quantity per axis of the scene, or three; missing ones are 0.
/// @param dimension of the scene; 0: any number of axes @param wanted for the fault
std::optional<Vec3> read_point(const toml::node& node, const std::string& path, int dimension,
                               const char* wanted, FaultList& faults);

/// `where`: a face, or a table of box, sphere, label, image, surface, points, any, all or not: see
/// docs/scene.md.
/// Nothing and faults for an invalid region. File names are relative to the folder of the file that is read.
/// @param dimension of the scene; 0 if it is not known: then vectors of any length are valid
/// @param body      null if it is faulty: only faults of the region's own form are found
/// @param frame     frame of its places, unless it states its own
std::optional<Region> read_region(TableReader& table, int dimension, const Specimen* body,
                                  CoordinateFrame frame = CoordinateFrame::grid);

/// The `[[hold]]`, `[[move]]`, `[[drive]]`, `[[load]]` and `[[sliding]]` tables of `root`; fills prescribed,
/// tractions, springs, gravity, active_stress and sliding, and leaves out pieces without holds. Without a
/// body only their faults are found.
/// @param labels of the cells of an image, if asks_for_labels(root)
void read_conditions(TableReader& root, const toml::table& document, Scene& scene,
                     const std::vector<float>& labels, bool has_body);
/// The `[test]` table, which replaces holds and moves: fills scene.test. @return its conditions
std::vector<Condition> read_test(TableReader& root, Scene& scene, bool has_body);
/// `hold` tables of a body that may be without holds: fills prescribed.
void read_holds(TableReader& table, Scene& scene, bool has_body);
/// `limits` and `relaxation` of a scene, or of an object.
void read_limits(TableReader& table, Scene& scene);
void read_relaxation(TableReader& table, Scene& scene);
/// Largest number of cells of a grid along an axis.
inline constexpr int most_cells_along_an_axis = 1'000'000'000;
/// A fault for every material without the data for the source of limits.
void check_limit_source(const Scene& scene, const std::string& path, int line, FaultList& faults);
/// A fault if a scene that is not two-dimensional sets `plane`. @param dimension 0 if it is not known
void check_plane(int dimension, const std::string& path, int line, FaultList& faults);
/// Reads only the `[[load]]` tables.
void read_loads(TableReader& root, Scene& scene, const std::vector<float>& labels, bool has_body);
/// True if a load names labels of an image.
bool asks_for_labels(const toml::table& root);

/// Checks the least memory that one answer needs on a grid; a fault if it exceeds the free memory.
bool fits_into_memory(const Index3& cells, int dimension, const std::string& path, int line,
                      FaultList& faults);

/// A vector of quantities: one per axis of the scene (one number in 1D), or three, zero beyond the scene's
/// dimension.
std::optional<Vec3> read_vector(TableReader& table, std::string_view key, int dimension);

/// Text of a value as in the file.
std::string in_words(const toml::node& node);

/// `where` of a table. @pre it has one
Asked asked_where(TableReader& table);

/// Calls `read` with a reader for every table of the array `key`.
template<class Read>
void for_each_table(TableReader& root, const char* key, Read&& read) {
  const toml::node* node = root.find(key);
  if (!node)
    return;
  const auto* list = node->as_array();
  if (!list || !list->is_array_of_tables()) {
    root.fault(key, fmt::format("tables [[{}]]", key));
    return;
  }
  for (std::size_t i = 0; i < list->size(); ++i) {
    TableReader table(*list->get(i)->as_table(), fmt::format("{}[{}]", root.path_of(key), i + 1),
                      root.faults(), root.declared_under(key));
    read(table);
    table.finish();
  }
}

} // namespace maille::reader
