#pragma once
/// The parts of the scene reader, one function per table of the file.
///
/// Each part reads its keys, adds a fault for each error, and returns what it could read, so that one pass
/// finds all errors; read_scene throws at the end. A part takes what earlier parts have made (units,
/// materials, the specimen) as arguments and keeps no state.

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

/// Whether a file can be read, is TOML, and has a key, as "specimen.look".
bool is_set(const std::filesystem::path& file, std::string_view key);

/// Materials of a scene in the order of their numbers; the same text gives the same number.
class MaterialTable {
public:
  /// Number of the material that `node` names or describes; nothing and a fault where it does neither.
  std::optional<std::uint8_t> add(const toml::node& node, const std::string& path, FaultList& faults);
  /// Number of a program's material; the same one gives the same number.
  std::optional<std::uint8_t> add(Material material, const std::string& path, FaultList& faults);
  std::vector<Material> take() { return std::move(materials_); }
  const std::vector<Material>& materials() const { return materials_; }

private:
  std::optional<std::uint8_t> append(Material material, const std::string& path, int line, FaultList& faults);

  std::vector<Material> materials_;
  std::map<std::string, std::uint8_t> number_of_; ///< by library name or TOML text
};

/// A material by its name in the library; nothing and a fault where it has none of that name.
std::optional<Material> library_material(const std::string& name, const std::string& path, int line,
                                         FaultList& faults);

/// A path as a scene names it, see named_file; nothing and a fault where it leads nowhere.
std::optional<std::filesystem::path> resolve_path(const std::string& text, const std::string& path, int line,
                                                  FaultList& faults);
/// The file that a key names, from the folder of the file that is read.
std::optional<std::filesystem::path> read_file_name(TableReader& table, std::string_view key);
/// `unit` of a file of surfaces, in metres: mm where it is absent.
double read_unit(TableReader& table);
/// `labels = 17`, `"17..19"`, or a list of them.
std::vector<LabelRange> read_label_ranges(TableReader& table);

/// Faults of a file that a scene names are faults of the scene.
void adopt(const InputError& error, const std::string& path, int line, FaultList& faults);

class LabelCells;
struct LabelRange;

/// Fibres that run to either side of a seam across `axis`: as they are asked for above it, mirrored below.
struct Bipennate {
  std::size_t axis = 0;
  std::optional<double> at; ///< [m]; the middle of the body's box where unset
};

/// How fibres are asked for: one direction, two halves of it, a line to follow, or an image of tensors.
struct FibreRequest {
  Vec3 direction{1, 0, 0};
  std::optional<Bipennate> bipennate;
  std::vector<Vec3> curve;                       ///< not empty: a FibreCurve's points
  std::string tensor_image;                      ///< not empty: directions come from this image
  double smoothing_radius = 0;                   ///< of the tensor image's directions [m]
  CoordinateFrame frame = CoordinateFrame::grid; ///< of `direction` and `curve`
  std::string path;                              ///< of the key
  int line = 0;
};
std::optional<FibreRequest> read_fibre(TableReader& table);
/// Whether a `[specimen]` is of an image or surfaces and has no `fibre`: their axes mean nothing to muscles.
bool lacks_fibre(const toml::table& specimen);
/// A fault of one, where `needed_by` has constants or a pull along fibres.
void add_lack_of_fibre(int line, const std::string& needed_by, FaultList& faults);
/// The same direction with length 1; nothing where it is zero or not finite.
std::optional<Vec3> unit_vector(Vec3 direction);
/// The direction that a list of `n` numbers, or three, has; nothing, without a fault, where it has none.
std::optional<Vec3> direction_of(const toml::node& node, std::size_t n);

/// Gives the body's matter the fibres that were asked for, but for those of tensor images. @return false, and
/// a fault, where the body does not stand in their frame
bool place_fibres(FibreRequest request, Specimen& body, FaultList& faults);

/// The `[specimen]` table: shape, grid, matter, fibres. Fills scene.specimen, scene.materials, scene.plane.
/// @param labels where not null, the label of each cell of an image is put there
/// @param given where not null, the body is of that image: there is neither `shape` nor `image`
/// @return false where the specimen is too faulty to place conditions on it
bool read_specimen(TableReader& table, Scene& scene, std::vector<float>* labels,
                   const Image* given = nullptr);

/// What the table of a body need not say.
struct BodyDefaults {
  bool has_material = true;    ///< false: `material` may be absent; then there is no material 0
  std::optional<Vec3> spacing; ///< of generated shapes
};
/// `material` of a body. @param is_needed a fault where it is absent
void read_material(TableReader& table, bool is_needed, MaterialTable& materials);
/// The same keys, with others beside them: the caller calls `finish`. @param shape as `shape` says
bool read_body(TableReader& table, const std::string& shape, const BodyDefaults& defaults, Scene& scene,
               std::vector<float>* labels);
/// `cells` and `spacing`, as a grid that fits into memory.
std::optional<Grid> read_grid(TableReader& table, const std::optional<Vec3>& default_spacing);
/// `spacing`: one length, or one for each axis of the scene. Where it is absent `otherwise`, or a fault.
std::optional<Vec3> read_spacing(TableReader& table, int dimension, const std::optional<Vec3>& otherwise);
/// One whole number or a list of them, each from `least` to `most`; empty where something else stands there.
std::vector<int> whole_numbers(const toml::node& node, int least, int most);
/// `cells = [nx, ny, nz]`, or fewer, or one number: their count is the scene's dimension.
std::optional<std::vector<int>> read_cells(TableReader& table);

/// Matter in a generated shape, one number a cell (no_material: none), for the whole grid.
std::vector<std::uint8_t> ellipsoid_cells(const Grid& grid);
/// A spindle along x between two tendons of `tendon_fraction` of its length each; material 0 is the belly, 1
/// the tendon.
std::vector<std::uint8_t> muscle_cells(const Grid& grid, double tendon_fraction);

/// `shape = "image"`. @param labels, given as in read_specimen. @return false where there is no body
bool read_image_specimen(TableReader& table, bool has_material, MaterialTable& materials, Scene& scene,
                         std::vector<float>* labels, const Image* given = nullptr);
/// `shape = "surface"`: `surface` (closed, .stl or .obj; of several the labels 1, 2, ...), `unit`,
/// `spacing`, and the keys of an image's labels and fibres. @return false where there is no body
bool read_surface_specimen(TableReader& table, bool has_material,
                           const std::optional<Vec3>& spacing_otherwise, MaterialTable& materials,
                           Scene& scene, std::vector<float>* labels);
/// The scene that the keys of a file say. @param given of its body, in place of a file that the scene names
/// @throws InputError
SceneAndMeasures scene_of(const toml::table& document, const std::filesystem::path& file,
                          const Image* given = nullptr);
/// True if two images have the same voxels in the same places, to a thousandth of a voxel.
bool have_same_voxels(const ImageInfo& one, const ImageInfo& other);

inline constexpr double widest_smooth = 16; ///< [voxels]; memory and time grow with it

/// `partial_volume` of an image, as it is asked for.
struct PartialVolume {
  enum class From { labels, grey, smooth };
  From from = From::labels;
  double none = 0, full = 1; ///< grey values
  std::string image;         ///< of these; empty: the body's own
  double width = 0;          ///< of smoothing [m]
  double least = 0.05;       ///< of a cell that is to be matter
  int line = 0;
};
/// Nothing where the key is absent, or faulty.
std::optional<PartialVolume> read_partial_volume(TableReader& specimen, const Index3& coarsen);
/// Gives the body's cells their tissue, those too that the surface runs through. @param body not cut down
void fill_partial_volume(const PartialVolume& asked, const LayeredImage& image,
                         const std::vector<LabelRange>& ranges, const Index3& coarsen, TableReader& table,
                         Specimen& body);
/// `stiffness` of a body from an image: fills its stiffness_ratio. @param scene null: only the key's own
/// faults
void read_stiffness_map(TableReader& specimen, const std::vector<Material>& materials, Scene* scene);

/// Directions from a diffusion-tensor image on the voxels of the label image, smoothed and filled; see
/// FibreField.
/// @throws InputError for a faulty image
void fibres_from_tensors(const std::filesystem::path& file, const FibreRequest& request,
                         const LabelCells& labels, const std::string& path, FaultList& faults,
                         Specimen& specimen);

/// `turn = { angle, axis, about }` of a move; nothing where it is absent, nothing and a fault where it is
/// faulty.
/// @param dimension of the scene; 0 where it is not known
/// @param turns_about_its_middle set where `about` is absent
std::optional<Turn> read_turn(TableReader& table, int dimension, bool& turns_about_its_middle);

/// `course`: a value over the time of a run; nothing where it is absent or faulty.
std::optional<TimeCourse> read_course(TableReader& table);
/// The `[[drive]]` tables: appends their conditions.
void read_drives(TableReader& root, const Scene& scene, bool has_body, std::vector<Condition>& conditions);
/// The `[[sliding]]` tables: fills sliding.
void read_sliding(TableReader& root, Scene& scene, bool has_body);
/// Nodes that springs of loads hold; the loads' own faults are left to read_loads.
std::vector<std::int64_t> nodes_of_foundations(const toml::table& root, const Scene& scene,
                                               const FaultList& faults);

/// Larger angles are a mistake, and would need too many increments.
inline constexpr double largest_turn = 200 * std::numbers::pi;

/// `frame`, or `otherwise` if the key is absent; nothing and a fault for another word.
std::optional<CoordinateFrame> read_frame(TableReader& table, CoordinateFrame otherwise);

/// What the places and vectors of a table are in, by its key `frame`.
struct TableFrame {
  CoordinateFrame frame = CoordinateFrame::grid;
  Placement placement;     ///< carries points of the object's frame into it
  Placement body_in_world; ///< the body's own, whatever the frame

  Vec3 vector_in_object(const Vec3& vector) const;
  /// The same turn, which a frame that is mirrored sees as one the other way.
  Turn in_object(Turn turn) const;
};
/// A fault where the body does not stand in that frame, or is not three-dimensional.
/// @param body  null where it is faulty: its frames are taken to be one
TableFrame read_table_frame(TableReader& table, int dimension, const Specimen* body);

/// A corner of a box, or a centre: a quantity for each axis of the scene, or three; missing ones are 0.
/// @param dimension of the scene; 0: any number of axes @param wanted for the fault
std::optional<Vec3> read_point(const toml::node& node, const std::string& path, int dimension,
                               const char* wanted, FaultList& faults);

/// `where`: a face, or a table of box, sphere, label, image, surface, points, any, all or not: see
/// docs/scene.md.
/// Nothing and faults for an invalid region. Files are looked for from the folder of the file that is read.
/// @param dimension of the scene; 0 where it is not known, and every length is right
/// @param body      null where it is faulty: only what is wrong with the region's own form is found
/// @param frame     of its places, unless it says so itself
std::optional<Region> read_region(TableReader& table, int dimension, const Specimen* body,
                                  CoordinateFrame frame = CoordinateFrame::grid);

/// The `[[hold]]`, `[[move]]`, `[[drive]]`, `[[load]]` and `[[sliding]]` tables of `root`; fills prescribed,
/// tractions, springs, gravity, active_stress and sliding, and leaves out matter that nothing holds.
/// Without a body their faults are found and nothing is placed.
/// @param labels of the cells of an image, where asks_for_labels(root)
void read_conditions(TableReader& root, const toml::table& document, Scene& scene,
                     const std::vector<float>& labels, bool has_body);
/// The `[test]` table, which stands for holds and moves: fills scene.test. @return its conditions
std::vector<Condition> read_test(TableReader& root, Scene& scene, bool has_body);
/// `hold` tables of a body that may be free: fills prescribed.
void read_holds(TableReader& table, Scene& scene, bool has_body);
/// `limits` and `relaxation` of a scene, or of an object.
void read_limits(TableReader& table, Scene& scene);
void read_relaxation(TableReader& table, Scene& scene);
/// What the settings of a relaxation must keep to.
inline constexpr int most_cells_along_an_axis = 1'000'000'000;
/// A fault for every material that lacks what the limits are taken from.
void check_limit_source(const Scene& scene, const std::string& path, int line, FaultList& faults);
/// A fault where a scene that is not two-dimensional states a plane. @param dimension 0 where it is not known
void check_plane(int dimension, const std::string& path, int line, FaultList& faults);
/// The `[[load]]` tables alone.
void read_loads(TableReader& root, Scene& scene, const std::vector<float>& labels, bool has_body);
/// True if a load names labels of an image.
bool asks_for_labels(const toml::table& root);

/// Bytes that a grid needs for one answer, at least; a fault where that is more than the machine has free.
bool fits_into_memory(const Index3& cells, int dimension, const std::string& path, int line,
                      FaultList& faults);

/// A vector of quantities: one for each of the scene's axes (one number in one dimension), or three of which
/// those beyond the scene's dimension are 0.
std::optional<Vec3> read_vector(TableReader& table, std::string_view key, int dimension);

/// Text of a value as the file has it.
std::string in_words(const toml::node& node);

/// `where` of a table that has one.
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
