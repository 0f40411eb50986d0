#pragma once
/// Large bodies as several files of some layers of cells each, so that no file needs memory for the whole.

#include "body_numbering.hpp"
#include "export/vtk_files.hpp"

#include <vtkDataSet.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace maille::studies {

/// Splits the body into pieces of whole layers, each with the fewest layers that hold `cells` cells.
std::vector<Layers> pieces_of(const Specimen& specimen, std::int64_t cells);

/// Data of some layers of a body for write_vtk(), numbered on the grid of the layers.
class LayersOfBody {
public:
  /// @param fields of the whole scene; both must outlive this
  LayersOfBody(const Scene& scene, const ExportFields& fields, const Layers& layers);

  const Scene& scene() const { return scene_; }
  const ExportFields& fields() const { return fields_; }
  /// Converts numbers on the grid of the body to numbers on the grid of the layers.
  BodyNumbering numbering(BodyNumbering of_body) const;

private:
  using Tensors = std::vector<std::array<double, 6>>;

  std::int64_t first_cell_ = 0, first_node_ = 0;
  Scene scene_;
  ExportFields fields_;
  std::array<Displacement, 3> displacements_;
  std::array<Tensors, 3> tensors_;
  std::vector<double> reaction_;
};

/// File of a piece of `stem.pvtu`.
std::filesystem::path file_of_piece(const std::filesystem::path& list, std::size_t piece);
/// Text of the list. @param one  any piece; all pieces have the same arrays
std::string list_of_pieces(const std::filesystem::path& list, std::size_t pieces, vtkDataSet& one);

/// Stores the layers of a piece in its arrays.
void add_layers(vtkFieldData& arrays, const Layers& layers);

} // namespace maille::studies
