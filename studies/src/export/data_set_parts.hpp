#pragma once
/// Arrays of VTK data sets, and writing of files; cell arrays are in the world's frame.

#include "body_grid.hpp"
#include "maille/scene/cell_fields.hpp"

#include <vtkCellData.h>
#include <vtkDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkSmartPointer.h>
#include <vtkXMLWriter.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace maille::studies {

/// Tensors of six components in VTK's order, rotated into the world's frame.
/// @param shown  indices in `tensors`, of cells or nodes
vtkSmartPointer<vtkDoubleArray> tensor_array(const char* name,
                                             const std::vector<std::array<double, 6>>& tensors,
                                             const Placement& placement,
                                             const std::vector<std::int64_t>& shown);

void add_text(vtkFieldData& arrays, const char* name, const std::string& text);
/// Adds the array Units: `text`, and the anatomical directions of the world's axes for image readers, if the
/// body's placement has them (world_in).
void add_units(vtkFieldData& arrays, const Placement& placement, const std::string& text);

/// Converts positions, displacements and the text of Units from metres to millimetres.
void use_millimetres(vtkDataSet& body);

enum class Compression {
  zlib, ///< supported by every reader
  lz4,  ///< ten times faster, files a sixth larger
};
/// Writes a file atomically, appended and compressed. @throws std::filesystem::filesystem_error,
/// std::runtime_error
void write_data_set(vtkXMLWriter& writer, vtkDataSet& body, const std::filesystem::path& file,
                    Compression compression = Compression::zlib);

/// Adds MaterialId, FiberDirection and, for a segmentation, Label.
void add_matter(vtkCellData& arrays, const Scene& scene, const Placement& placement,
                const BodyNumbering& numbering);
/// Adds MaterialNames, by MaterialId; for a segmentation also LabelNumbers, ascending, and LabelMaterials,
/// the names of their materials.
void add_names(vtkFieldData& arrays, const Scene& scene);

/// Adds Strain, PrincipalStrain and FiberStrain; with stress also Stress, VonMises and FiberStress. Fibre
/// arrays require Scene::has_fibres().
void add_strain_and_stress(vtkCellData& arrays, const Scene& scene, FieldsOfCells fields,
                           const Placement& placement, const BodyNumbering& numbering, bool with_stress);

} // namespace maille::studies
