#pragma once
/// Scenes and answers as files for ParaView: one grid per answer, and a list of files that makes a series.

#include "maille/scene/answer.hpp"

#include <array>
#include <cstddef>
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
  /// Answer::nodal_strain and nodal_stress; add NodalStrain and NodalStress where they are not empty
  const std::vector<std::array<double, 6>>*nodal_strain = nullptr, *nodal_stress = nullptr;

  /// Everything that an answer has to show.
  void show(const Answer& answer);
};

/// @brief Writes the undeformed body with the fields of one answer.
///
/// A body that fills its grid becomes `stem.vti` (image data whose origin and direction matrix put it where
/// the specimen's placement says); a masked body becomes `stem.vtu` (its cells of matter and their nodes, in
/// world coordinates, nodes in the grid's order). XML, appended, zlib, 64-bit headers.
///
/// - points, world's frame [m]: Displacement (the active vectors); with a reference also DisplacementReference and
///   DisplacementError = Displacement - DisplacementReference; DisplacementErrorEstimate, the same without a reference
///   (deform::estimate_error); Reaction [N], the force on the body that keeps a held or moved
///   node where it is, zero elsewhere; components X Y Z; NodalStrain [1] and NodalStress [Pa] of finite elements, recovered as
///   fem_ref::Options::recover_stress says, components and frame as of cells
/// - cells: MaterialId (the active scalars; unsigned char, index into the scene's materials); FiberDirection (world's
///   frame, unit length, sign-free); Strain and Stress of `displacement` (XX YY ZZ XY YZ XZ, object's frame, tensor
///   shear, [1] and [Pa]); VonMises [Pa]
/// - field: Units and Provenance (text), StrainEnergy [J] where it is known, and with `time` TimeValue
///
/// Vectors are padded with zeros to three components and turned into the world's frame, since ParaView's
/// WarpByVector adds them to world coordinates. Tensors stay in the object's frame, in which the constants of
/// the materials and the limits of the links are stated. The two frames agree unless the specimen is an image
/// with an oblique header.
///
/// @param scene   one, two or three dimensions, at least one cell of matter
/// @param stem    path without ending, in a folder that exists; an older file of that name is replaced
/// @return the file's path
/// @throws std::invalid_argument  a displacement is missing or does not fit the scene's grid
/// @throws std::filesystem::filesystem_error, std::runtime_error  the file could not be written; the message
///         has the path. A file appears whole or not at all: it is written beside its place and renamed.
///
/// Cost        O(cells); about five times the displacement's bytes while it runs
/// Repeatable  same input, same bytes
std::filesystem::path write_vtk(const Scene& scene, const ExportFields& fields,
                                const std::filesystem::path& stem);

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
