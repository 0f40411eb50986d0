#pragma once
/// Scenes and answers as files for ParaView: one grid per answer, and lists of files as series.

#include "maille/scene/answer.hpp"
#include "maille/scene/warp/warp.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// Fields of a file, in addition to the body.
struct ExportFields {
  const Displacement* displacement = nullptr;    ///< [m], object's frame, on the scene's grid; required
  const Displacement* reference = nullptr;       ///< adds DisplacementReference and DisplacementError
  const Displacement* error_estimate = nullptr;  ///< adds DisplacementErrorEstimate
  std::string provenance = "{}";                 ///< JSON: who made the answer, with what, from what
  std::optional<double> time = {};               ///< adds TimeValue, the time of the file in ParaView
  const std::vector<double>* reaction = nullptr; ///< Answer::reaction [N]; adds Reaction if it is not empty
  std::optional<double> strain_energy = {};      ///< [J]; adds StrainEnergy
  /// Answer::nodal_strain and nodal_stress; add NodalStrain and NodalStress; if both are empty, these are
  /// recovered from the displacement (RecoveredFields)
  const std::vector<std::array<double, 6>>*nodal_strain = nullptr, *nodal_stress = nullptr;
  /// Answer::cell_strain; null or empty: strain from the displacement of the corners
  const std::vector<std::array<double, 6>>* cell_strain = nullptr;
  bool has_stress = true;              ///< false: no Stress, VonMises, FiberStress and NodalStress
  LengthUnit unit = LengthUnit::metre; ///< of positions and displacements; all other data is in SI units
  std::int64_t most_cells = 3'000'000; ///< larger bodies are written in pieces of a twelfth of this
  int threads = 1;                     ///< at most four threads write pieces

  /// Selects all fields of an answer; stress only for methods with stress.
  void show(const Answer& answer);
};

/// @brief Writes the undeformed body with the fields of one answer; arrays and units: docs/files.md.
///
/// A body that fills its grid becomes `stem.vti` (image data with origin and direction matrix). A masked body
/// becomes `stem.vtu` (its cells and their nodes, in world coordinates, nodes in grid order) or, above three
/// million cells, `stem.pvtu` and files of some layers of cells each in the folder `stem`. XML, appended,
/// zlib (pieces: LZ4), 64-bit headers. All vectors and tensors are in the world's frame, of the body at rest:
/// the strain of a rotated body is given before its rotation.
///
/// @param scene   one, two or three dimensions, with at least one cell
/// @param stem    path without ending, in an existing folder; an older file of that name is replaced
/// @return the file's path
/// @throws std::invalid_argument  a displacement is missing or does not match the scene's grid
/// @throws std::filesystem::filesystem_error, std::runtime_error  the file could not be written; the message
///         contains the path. Files are written atomically, under a temporary name that is then renamed.
/// Cost        O(cells); memory: for a single file about five times the displacement's bytes, for pieces half
///             a GB per thread
/// Repeatable  same input, same bytes
std::filesystem::path write_vtk(const Scene& scene, const ExportFields& fields,
                                const std::filesystem::path& stem);
/// Ending of its single-piece files.
inline const char* ending_of_vtk(const Scene& scene) {
  return scene.specimen.n_matter_cells() == scene.specimen.grid.n_cells() ? ".vti" : ".vtu";
}

/// One file of a series.
struct PvdEntry {
  double time = 0;
  std::filesystem::path file;
  int part = 0; ///< part number, for several files at one time
};

/// @brief Writes a ParaView collection: the files of a series with their times.
/// @param entries  files are listed relative to the folder of `pvd`, with forward slashes
/// @throws std::filesystem::filesystem_error, std::runtime_error  as write_vtk
void write_pvd(const std::vector<PvdEntry>& entries, const std::filesystem::path& pvd);

/// One of several files for side-by-side display.
struct NamedBlock {
  std::string name;
  std::filesystem::path file;
};

/// @brief Writes a multi-block data set (`.vtm`) of write_vtk's files, which VTK's readers open as blocks
///        with these names.
/// @param blocks  paths are written as in write_pvd
/// @throws std::filesystem::filesystem_error, std::runtime_error  as write_vtk
void write_blocks(const std::vector<NamedBlock>& blocks, const std::filesystem::path& vtm);

/// Collects the files of a series `stem_0000.vti`, `stem_0001.vti`, ... and lists them in `stem.pvd`.
class PvdSeries {
public:
  /// @param n_steps  expected number of steps; determines the number of digits in file names (at least 4), so
  /// that they sort
  PvdSeries(std::filesystem::path stem, std::size_t n_steps);
  /// Writes the next step, at time `time`.
  /// @return the file's path; @throws as write_vtk
  std::filesystem::path add(const Scene& scene, ExportFields fields, double time);
  /// Writes `stem.pvd` with the steps so far. @return its path; @throws as write_pvd
  std::filesystem::path write() const;

private:
  std::filesystem::path stem_;
  int n_digits_;
  std::vector<PvdEntry> entries_;
};

} // namespace maille::studies
