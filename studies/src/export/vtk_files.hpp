#pragma once
/// Scenes and answers as files for ParaView: one grid per answer, and a list of files that makes a series.

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

/// What a file shows of a scene beside the body itself.
struct ExportFields {
  const Displacement* displacement = nullptr;   ///< [m], object's frame, on the scene's grid; required
  const Displacement* reference = nullptr;      ///< adds DisplacementReference and DisplacementError
  const Displacement* error_estimate = nullptr; ///< adds DisplacementErrorEstimate
  std::string provenance = "{}";                ///< JSON: who made the answer, with what, from what
  std::optional<double> time = {};              ///< adds TimeValue, which ParaView takes as the file's time
  const std::vector<double>* reaction =
      nullptr;                              ///< Answer::reaction [N]; adds Reaction where it is not empty
  std::optional<double> strain_energy = {}; ///< [J]; adds StrainEnergy
  /// Answer::nodal_strain and nodal_stress; add NodalStrain and NodalStress, recovered from the displacement
  /// (RecoveredFields) where both are empty
  const std::vector<std::array<double, 6>>*nodal_strain = nullptr, *nodal_stress = nullptr;
  /// Answer::cell_strain; null or empty: what the displacement of the corners says
  const std::vector<std::array<double, 6>>* cell_strain = nullptr;
  bool has_stress = true;              ///< false: no Stress, VonMises, FiberStress and NodalStress
  LengthUnit unit = LengthUnit::metre; ///< of places and displacements in the file; all else is in SI units
  std::int64_t most_cells = 3'000'000; ///< of matter; a body of more is written in pieces of a twelfth of it
  int threads = 1;                     ///< four at most write a piece each

  /// Everything that an answer has to show: stress of methods that know one.
  void show(const Answer& answer);
};

/// @brief Writes the undeformed body with the fields of one answer; arrays and units: docs/files.md.
///
/// A body that fills its grid becomes `stem.vti` (image data placed by its origin and direction matrix); a
/// masked body becomes `stem.vtu` (its cells of matter and their nodes, in world coordinates, nodes in the
/// grid's order), or, of more than three million cells, `stem.pvtu` and files of some layers of cells each in
/// the folder `stem`. XML, appended, zlib (pieces: LZ4), 64-bit headers. All vectors and tensors are in the
/// world's frame, of the body at rest: where a body turns, its strain is that of the body before it turned.
///
/// @param scene   one, two or three dimensions, at least one cell of matter
/// @param stem    path without ending, in a folder that exists; an older file of that name is replaced
/// @return the file's path
/// @throws std::invalid_argument  a displacement is missing or does not fit the scene's grid
/// @throws std::filesystem::filesystem_error, std::runtime_error  the file could not be written; the message
///         has the path. A file appears whole or not at all: it is written beside its place and renamed.
/// Cost        O(cells); of a body in one file about five times the displacement's bytes while it runs, in
///             pieces half a GB a thread
/// Repeatable  same input, same bytes
std::filesystem::path write_vtk(const Scene& scene, const ExportFields& fields,
                                const std::filesystem::path& stem);
/// Of its files in one piece.
inline const char* ending_of_vtk(const Scene& scene) {
  return scene.specimen.n_matter_cells() == scene.specimen.grid.n_cells() ? ".vti" : ".vtu";
}

/// One file of a series.
struct PvdEntry {
  double time = 0;
  std::filesystem::path file;
  int part = 0; ///< of several files of one time
};

/// @brief Writes a ParaView collection: the files of a series with their times.
/// @param entries  files are listed relative to the folder of `pvd`, with forward slashes
/// @throws std::filesystem::filesystem_error, std::runtime_error  as write_vtk
void write_pvd(const std::vector<PvdEntry>& entries, const std::filesystem::path& pvd);

/// One file of several that are looked at side by side.
struct NamedBlock {
  std::string name;
  std::filesystem::path file;
};

/// @brief Writes a multi-block data set (`.vtm`) over files of write_vtk, which VTK's readers open as blocks
///        of these names.
/// @param blocks  files are listed as by write_pvd
/// @throws std::filesystem::filesystem_error, std::runtime_error  as write_vtk
void write_blocks(const std::vector<NamedBlock>& blocks, const std::filesystem::path& vtm);

/// Collects the files of a series `stem_0000.vti`, `stem_0001.vti`, ... and lists them in `stem.pvd`.
class PvdSeries {
public:
  /// @param n_steps  steps to come; decides how many digits a step's number gets, so that names sort (at
  /// least 4)
  PvdSeries(std::filesystem::path stem, std::size_t n_steps);
  /// Writes the next step; its time is set to `time`.
  /// @return the file's path; @throws as write_vtk
  std::filesystem::path add(const Scene& scene, ExportFields fields, double time);
  /// Writes `stem.pvd` over the steps so far. @return its path; @throws as write_pvd
  std::filesystem::path write() const;

private:
  std::filesystem::path stem_;
  int n_digits_;
  std::vector<PvdEntry> entries_;
};

} // namespace maille::studies
