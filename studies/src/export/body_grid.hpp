#pragma once
/// The body as VTK data, shared by the files and the pictures.

#include "maille/scene/answer.hpp"

#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <array>
#include <cstdint>
#include <vector>

namespace maille::studies {

/// Which nodes and cells of the grid are in a VTK data set, in the data set's order.
struct BodyNumbering {
  std::vector<std::int64_t> nodes;
  std::vector<std::int64_t> cells;
};

/// Every node and cell of the grid.
BodyNumbering whole_grid(const Grid& grid);
/// The cells of matter and their corners, both in the grid's order.
BodyNumbering matter_only(const Specimen& specimen);

/// A symmetric tensor of the object's frame, XX YY ZZ XY YZ XZ, in the world's.
std::array<double, 6> tensor_to_world(const Placement& placement, const std::array<double, 6>& tensor);

/// @pre every cell holds matter
vtkSmartPointer<vtkImageData> image_grid(const Specimen& specimen);
/// Lines, quads or hexahedra over the numbered nodes and cells.
/// @param placed  node positions in the world's frame; else in the object's
vtkSmartPointer<vtkUnstructuredGrid> cell_grid(const Specimen& specimen, const BodyNumbering& numbering,
                                               bool placed);

/// The displacement of the numbered nodes, padded to three components.
/// @param placement  turned into its world's frame
vtkSmartPointer<vtkDoubleArray> vector_array(const char* name, const Displacement& displacement,
                                             const Placement& placement, const BodyNumbering& numbering);

} // namespace maille::studies
