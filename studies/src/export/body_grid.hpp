#pragma once
/// The body as VTK data, shared by the files and the pictures.

#include "body_numbering.hpp"
#include "maille/scene/answer.hpp"

#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

namespace maille::studies {

/// @pre the body fills its grid
vtkSmartPointer<vtkImageData> image_grid(const Specimen& specimen);
/// Lines, quads or hexahedra over the numbered nodes and cells.
/// @param placed  true: node positions in the world's frame; false: in the object's
vtkSmartPointer<vtkUnstructuredGrid> cell_grid(const Specimen& specimen, const BodyNumbering& numbering,
                                               bool placed);

/// The displacement of the numbered nodes, padded to three components.
/// @param placement  rotates the vectors into the world's frame
vtkSmartPointer<vtkDoubleArray> vector_array(const char* name, const Displacement& displacement,
                                             const Placement& placement, const BodyNumbering& numbering);

} // namespace maille::studies
