#pragma once
/// Arrays of VTK data sets, and their files; arrays of cells are in the world's frame.

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

/// Six components each, in VTK's order, turned into the world's frame.
/// @param shown  places in `tensors`, of cells or nodes
vtkSmartPointer<vtkDoubleArray> tensor_array(const char* name,
                                             const std::vector<std::array<double, 6>>& tensors,
                                             const Placement& placement,
                                             const std::vector<std::int64_t>& shown);

void add_text(vtkFieldData& arrays, const char* name, const std::string& text);
/// The array Units: `text` and, where the body's place says it, what the world's axes point to, which image
/// readers take (world_in).
void add_units(vtkFieldData& arrays, const Placement& placement, const std::string& text);

/// Places, displacements and what Units says of them, from metres to millimetres.
void use_millimetres(vtkDataSet& body);

enum class Compression {
  zlib, ///< every reader has it
  lz4,  ///< a tenth of the time, a sixth more bytes
};
/// Appended, compressed, whole or not at all. @throws std::filesystem::filesystem_error, std::runtime_error
void write_data_set(vtkXMLWriter& writer, vtkDataSet& body, const std::filesystem::path& file,
                    Compression compression = Compression::zlib);

/// MaterialId, FiberDirection and, of a segmentation, Label.
void add_matter(vtkCellData& arrays, const Scene& scene, const Placement& placement,
                const BodyNumbering& numbering);
/// MaterialNames, by MaterialId; of a segmentation LabelNumbers, ascending, and LabelMaterials, their
/// materials' names.
void add_names(vtkFieldData& arrays, const Scene& scene);

/// Strain, PrincipalStrain and FiberStrain; with stress also Stress, VonMises and FiberStress. Those of
/// fibres where Scene::has_fibres().
void add_strain_and_stress(vtkCellData& arrays, const Scene& scene, FieldsOfCells fields,
                           const Placement& placement, const BodyNumbering& numbering, bool with_stress);

} // namespace maille::studies
