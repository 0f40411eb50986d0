#pragma once
/// One scene on coarser and finer lattices, and transfer of answers between them.

#include "maille/materials/toml_reader.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/measure/measure.hpp"

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace maille::studies {

/// A scene on one lattice, or why it cannot be built.
struct LatticeScene {
  std::shared_ptr<const Scene> scene; ///< null if it cannot be built
  std::string why_not;
  /// The scene's measures on this lattice; null if some do not fit on it, or there is no lattice.
  std::shared_ptr<const std::vector<Measure>> measures = nullptr;
};

/// A scene file on lattices of 1/2, 1, 2, 4 ... times its spacing.
///
/// **Coarser**: the file is read again with fewer `cells` over the same extent (the integer nearest to an
/// even division, at least one; spacings may then differ slightly between axes), or with larger `coarsen` for
/// images. Shape, holds, moves and loads are set up anew on that lattice: staircases are coarser, and a
/// region without nodes makes the lattice fail.
/// **Finer**: refined(): every cell is halved, so the body has the same shape.
class Lattices {
public:
  /// @throws InputError if the scene itself is invalid
  explicit Lattices(const std::filesystem::path& file);
  /// The same from text; `file` gives the name and the folder of images.
  Lattices(std::string text, std::filesystem::path file);

  /// The scene of the file.
  const Scene& scene() const { return *scene_; }
  const std::vector<Measure>& measures() const { return *measures_; }
  /// Measures on the lattice of a scene from at(); empty if some do not fit on it.
  std::vector<Measure> measures_on(const Scene& scene) const;
  /// The scene on a lattice; cached. @param halvings  of the spacing: 1 halves it, -1 doubles it, 0 is the
  /// scene itself
  LatticeScene at(int halvings);
  /// The lattice as a scene file (TOML), with the file names of the scene. Nothing for finer lattices of
  /// bodies other than boxes, which a file cannot describe.
  /// @param tolerance replaces the scene's, if given
  std::optional<std::string> text(int halvings, std::optional<double> tolerance) const;

private:
  Lattices(std::string text, std::filesystem::path file, SceneAndMeasures read);
  LatticeScene coarser(int doublings) const;
  /// Writes the scene on fewer cells to `text`. @return the reason of a failure, or empty
  std::string coarsen(int doublings, std::string& text) const;

  std::string text_;
  std::filesystem::path file_;
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const std::vector<Measure>> measures_;
  std::map<int, LatticeScene> known_;
};

/// Merges `factor` times as many voxels of a specimen's image along each axis.
void coarsen_image(toml::table& specimen, int factor);

/// Transfers an answer between lattices of the same body: (multi)linear within the cell that contains a node.
/// Nodes outside the body (staircases differ) get the linear extrapolation from the nearest cell. Zero at
/// grid points of `to` that are not nodes. Exact for linear fields.
/// Cost  O(nodes of `to`)
Displacement between_lattices(const Scene& from, const Displacement& displacement, const Scene& to);

} // namespace maille::studies
