#pragma once
/// Scene files of one sentence: a body, and what is done to it.

#include "maille/materials/text_file.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace maille::lab {

/// A scene file and what is special about it.
struct KindScene {
  std::string name; ///< e.g. `plate one cell thick, nu 0.45, gravity`
  std::string text; ///< TOML; images are named relative to their folder
};

/// A material with a density, as TOML.
std::string isotropic(double nu, const char* youngs_modulus = "10 kPa");
/// Fibres `ratio` times as stiff along as across, turned by an angle in degrees in the xz plane, as TOML.
std::string fibres(double ratio, double angle);

std::string held(const char* where);
/// A move by x, y, z millimetres.
std::string moved(const char* where, double x, double y, double z);
/// Conditions on a body of a size in millimetres, as TOML: `pull`, `bend`, `twist`, `traction` at x+, held at
/// x-; `shear`, `squeeze`, `poke` (the middle half) at z+, held at z-; `gravity` across; `hinge`, held along
/// an edge; `plane bend`, where nothing moves across.
std::string action(const std::string& word, const std::array<double, 3>& mm);

/// Muscles and bone of MAILLE_DATA, as specimens; axes of voxels, of which the third is up.
/// @param blocks of voxels that make one cell, per axis
std::string calf_muscle(int label, const std::string& material, const std::array<int, 3>& blocks = {1, 1, 1});
std::string head(int threshold, const std::string& material, int block);

/// A body of several materials, or of a shape of its own.
struct LabelledBody {
  using Cells = std::array<int, 3>;
  using Point = std::array<double, 3>;
  /// What lies at a point in mm from the corner: 0 is nothing, 1 the first material.
  using LabelAt = std::function<int(const Point&)>;

  std::string name;
  Cells cells; ///< of 1 mm
  std::vector<std::string> materials;
  LabelAt label;
};

/// Muscle, fat and a skin of 1 mm; of materials of 1 MPa and 10 kPa: a soft seam, a stiff sheet in gel, a
/// checkerboard, a shell around gel; an L of one material.
LabelledBody body_under_skin();
LabelledBody body_with_soft_seam();
LabelledBody gel_with_stiff_sheet();
LabelledBody checkerboard();
LabelledBody shell_around_gel();
LabelledBody body_like_an_l();
/// 1 MPa, and 10 kPa that is nearly incompressible.
std::vector<std::string> stiff_and_soft();
/// Muscle, fat, skin.
std::vector<std::string> soft_tissues();
/// Whether a point of a cube of 8 mm is not in its walls of 1 mm.
bool is_inside_shell(const LabelledBody::Point& at);

/// Collects scenes, and makes the images that they name.
class SceneMaker {
public:
  using Cells = LabelledBody::Cells;
  using Point = LabelledBody::Point;

  /// @param scale cells are divided by it along every axis
  SceneMaker(int scale, std::filesystem::path folder) : scale_(scale), folder_(std::move(folder)) {}

  /// @param spacing of undivided cells, in mm
  void box(const std::string& words, const Cells& cells, const std::string& material, const std::string& word,
           const Point& spacing = {1, 1, 1});
  /// One for each word.
  void image(const LabelledBody& body, const std::vector<std::string>& words);
  void add(const std::string& words, const std::string& text) { scenes_.push_back({words, text}); }
  int scale() const { return scale_; }
  std::vector<KindScene> take() { return std::move(scenes_); }

private:
  int scale_;
  std::filesystem::path folder_;
  std::vector<KindScene> scenes_;
};

/// Scenes, and the temporary folder with their images, which goes with them.
class SceneSet {
public:
  /// @param scale of SceneMaker; @param fill adds the scenes
  SceneSet(const std::string& name, int scale, const std::function<void(SceneMaker&)>& fill) : folder_(name) {
    SceneMaker maker(scale, folder_.path());
    fill(maker);
    scenes_ = maker.take();
  }
  const std::vector<KindScene>& list() const { return scenes_; }
  /// That images are named relative to.
  const std::filesystem::path& folder() const { return folder_.path(); }

private:
  WorkFolder folder_;
  std::vector<KindScene> scenes_;
};

/// Scenes of many kinds, the hard ones among them: boxes that are poked, sheared, pulled and bent, with
/// Poisson's ratios of 0.3 to 0.4999; plates and strips one and two cells thick; bodies held along an edge;
/// fibres up to 50 times as stiff along as across; layers of skin, fat and muscle, soft seams, thin
/// inclusions and checkerboards; slender bodies; gravity and tractions; flat cells; bellies; with MAILLE_DATA
/// muscles and bone from images.
/// @param scale divides cells of 1 mm along every axis: a part one cell thick is then `scale` cells thick
SceneSet kind_scenes(int scale);

/// Scenes that are unlike those of the table that `choose` knows: layers of muscle, fat and skin, seams,
/// sheets and checkerboards; plates of one and two cells, of one material and of two; shells: hollow boxes,
/// balls, tubes and domes; gravity and tractions on stout and slender boxes; fibres 50 times as stiff along
/// as across; with MAILLE_DATA all fourteen muscles of a calf from MRI, and bone and flesh of a head from CT.
/// Cells are of half a millimetre where they are not an image's.
SceneSet unlike_scenes();

/// The numbers of 0 .. n - 1 that a quick run looks at: `wanted` of them, spread evenly.
std::vector<std::size_t> spread(std::size_t n, std::size_t wanted);

/// A scene file and what is wanted of it.
struct UnseenScene {
  std::string text; ///< TOML
  std::string shape, load, material;
  double error = 0, seconds = 0; ///< wished
};

/// Draws scenes: boxes, bellies and ellipsoids; pulled, bent and poked; isotropic to a Poisson ratio of 0.49
/// or with fibres up to 20 times as stiff along as across, turned by any angle; 8 to 32 cells along an axis.
/// The table (scripts/trade-table) holds other loads (but for bellies that are pulled), other materials and
/// other sizes. Wishes: errors of 1.5 to 40 %, times of 0.3 to 300 ms, evenly on a logarithm.
/// Repeatable: the same scenes everywhere
class UnseenScenes {
public:
  explicit UnseenScenes(std::uint32_t seed) : lot_(seed) {}
  UnseenScene draw();

private:
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(lot_()) / 4294967296.0;
  }
  int whole(int low, int high) {
    return low + static_cast<int>(lot_() % static_cast<std::uint32_t>(high - low + 1));
  }
  double on_logarithm(double low, double high);
  std::string draw_material(std::string& words);
  std::string draw_load(const std::string& shape, const int (&cells)[3], std::string& words);

  std::mt19937 lot_; // its numbers are the same everywhere, those of distributions are not
};

} // namespace maille::lab
