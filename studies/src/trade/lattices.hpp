#pragma once
/// One scene on coarser and finer lattices, and answers carried from one to the other.

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
  /// Those of the scene on this lattice; null where some have no place on it, or there is no lattice.
  std::shared_ptr<const std::vector<Measure>> measures = nullptr;
};

/// A scene file on lattices of 1/2, 1, 2, 4 ... times its spacing.
///
/// **Coarser**: the file is read again with fewer `cells` over the same extent (the whole number nearest to
/// an even division, at least one; spacings may then differ a little along the axes), or with larger
/// `coarsen` for images. Shape, holds, moves and loads are placed anew on that lattice: a staircase is
/// coarser, and a region without a node makes the lattice fail.
/// **Finer**: refined(): every cell is halved, so the body stays the one that the scene has.
class Lattices {
public:
  /// @throws InputError where the scene itself is faulty
  explicit Lattices(const std::filesystem::path& file);
  /// The same from text; `file` gives the name and the folder of images.
  Lattices(std::string text, std::filesystem::path file);

  /// As the file has it.
  const Scene& scene() const { return *scene_; }
  const std::vector<Measure>& measures() const { return *measures_; }
  /// Those on the lattice whose scene that is, of those that at() has given; none where some have no place.
  std::vector<Measure> measures_on(const Scene& scene) const;
  /// @param halvings  of the spacing: 1 halves it, -1 doubles it, 0 is the scene itself. Kept for the next
  ///        time.
  LatticeScene at(int halvings);
  /// That lattice as a scene file (TOML), with the scene's file names. Nothing for finer lattices of bodies
  /// other than boxes, which no file can describe.
  /// @param tolerance in place of the scene's, where given
  std::optional<std::string> text(int halvings, std::optional<double> tolerance) const;

private:
  Lattices(std::string text, std::filesystem::path file, SceneAndMeasures read);
  LatticeScene coarser(int doublings) const;
  /// Writes the scene on fewer cells to `text`. @return why that is not possible, or empty
  std::string coarsen(int doublings, std::string& text) const;

  std::string text_;
  std::filesystem::path file_;
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const std::vector<Measure>> measures_;
  std::map<int, LatticeScene> known_;
};

/// Merges `factor` times as many voxels of a specimen's image along each axis.
void coarsen_image(toml::table& specimen, int factor);

/// An answer on one lattice at the nodes of another of the same body: (multi)linear within the cell of matter
/// that a node lies in. A node outside of all matter (staircases differ) takes the linear continuation of the
/// nearest cell. Zero at grid points of `to` that are no nodes. Exact for linear fields.
/// Cost  O(nodes of `to`)
Displacement between_lattices(const Scene& from, const Displacement& displacement, const Scene& to);

} // namespace maille::studies
