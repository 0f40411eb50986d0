#pragma once
/// Scene files of one sentence: a body, and what is done to it.

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace maille::studies {

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
/// By so many millimetres.
std::string moved(const char* where, double x, double y, double z);
/// What is done to a body of so many millimetres, as TOML: `pull`, `bend`, `twist`, `traction` at x+, held at
/// x-; `shear`, `squeeze`, `poke` (the middle half) at z+, held at z-; `gravity` across; `hinge`, held along
/// an edge; `plane bend`, where nothing moves across.
std::string action(const std::string& word, const std::array<double, 3>& mm);

/// Muscles and bone of MAILLE_DATA, as specimens; axes of voxels, of which the third is up.
/// @param blocks of voxels that make one cell, per axis
std::string calf_muscle(int label, const std::string& material, const std::array<int, 3>& blocks = {1, 1, 1});
std::string head(int threshold, const std::string& material, int block);

/// Collects scenes, and makes the images that they name.
class SceneMaker {
public:
  using Cells = std::array<int, 3>;
  using Point = std::array<double, 3>;
  /// What lies at a point in mm from the corner: 0 is nothing, 1 the first material.
  using LabelAt = std::function<int(const Point&)>;

  /// @param scale cells are divided by it along every axis
  SceneMaker(int scale, std::filesystem::path folder) : scale_(scale), folder_(std::move(folder)) {}

  /// @param spacing of undivided cells, in mm
  void box(const std::string& words, const Cells& cells, const std::string& material, const std::string& word,
           const Point& spacing = {1, 1, 1});
  /// Of cells of 1 mm.
  void image(const std::string& words, const Cells& cells, const std::vector<std::string>& materials,
             const LabelAt& label, const std::string& word);
  void add(const std::string& words, const std::string& text) { scenes_.push_back({words, text}); }
  int scale() const { return scale_; }
  std::vector<KindScene> take() { return std::move(scenes_); }

private:
  int scale_;
  std::filesystem::path folder_;
  std::vector<KindScene> scenes_;
};

} // namespace maille::studies
