#include "export/vtk_files.hpp"

#include "body_grid.hpp"
#include "body_pieces.hpp"
#include "data_set_parts.hpp"
#include "export/whole_file.hpp"
#include "maille/mechanics/recovery.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/frame.hpp"

#include <fmt/format.h>

#include <vtkCellData.h>
#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <stdexcept>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

void require_fit(const Scene& scene, const Displacement& displacement, const char* what) {
  const bool fits = displacement.n_components() == static_cast<std::size_t>(scene.dimension()) &&
                    displacement.n_nodes() == static_cast<std::size_t>(scene.specimen.grid.n_nodes());
  if (!fits)
    throw std::invalid_argument(
        fmt::format("write_vtk: {} does not fit the grid of scene {}", what, scene.name));
}

/// Calls use() with the cell strains of the answer, or with its displacement.
template<class Use>
auto with_strains(const ExportFields& fields, const Use& use) {
  return fields.cell_strain != nullptr && !fields.cell_strain->empty() ? use(*fields.cell_strain)
                                                                       : use(*fields.displacement);
}

/// Adds nodal tensors of the answer, or recovered ones if it has none.
void add_nodal_tensors(vtkPointData& arrays, const Scene& scene, const ExportFields& fields,
                       const BodyNumbering& numbering) {
  const Placement& placement = scene.specimen.placement;
  if (fields.nodal_strain == nullptr && fields.nodal_stress == nullptr)
    return;
  const auto has = [](const auto* tensors) { return tensors != nullptr && !tensors->empty(); };
  RecoveredFields::Shown recovered;
  const auto *strain = fields.nodal_strain, *stress = fields.nodal_stress;
  if (!has(strain) && !has(stress)) {
    recovered = with_strains(
        fields, [&](const auto& of) { return RecoveredFields(scene, cell_fields(scene, of)).at_nodes(); });
    strain = &recovered.strain;
    stress = &recovered.stress;
  }
  if (has(strain))
    arrays.AddArray(tensor_array("NodalStrain", *strain, placement, numbering.nodes));
  if (fields.has_stress && has(stress))
    arrays.AddArray(tensor_array("NodalStress", *stress, placement, numbering.nodes));
}

void add_point_arrays(vtkDataSet& body, const Scene& scene, const ExportFields& fields,
                      const BodyNumbering& numbering) {
  vtkPointData& arrays = *body.GetPointData();
  const Placement& placement = scene.specimen.placement;
  const auto displacement = vector_array("Displacement", *fields.displacement, placement, numbering);
  arrays.AddArray(displacement);
  if (fields.reference != nullptr) {
    const auto reference = vector_array("DisplacementReference", *fields.reference, placement, numbering);
    // Computed from the written arrays, so that the third is exactly their difference.
    vtkNew<vtkDoubleArray> error;
    error->DeepCopy(displacement);
    error->SetName("DisplacementError");
    for (vtkIdType i = 0; i < error->GetNumberOfValues(); ++i)
      error->SetValue(i, displacement->GetValue(i) - reference->GetValue(i));
    arrays.AddArray(reference);
    arrays.AddArray(error);
  }
  if (fields.error_estimate != nullptr)
    arrays.AddArray(vector_array("DisplacementErrorEstimate", *fields.error_estimate, placement, numbering));
  if (fields.reaction != nullptr && !fields.reaction->empty()) {
    Displacement forces(scene.specimen.grid); // one vector per node, like displacements
    for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
      forces(scene.prescribed[i].component, scene.prescribed[i].node) = fields.reaction->at(i);
    arrays.AddArray(vector_array("Reaction", forces, placement, numbering));
  }
  add_nodal_tensors(arrays, scene, fields, numbering);
  arrays.SetActiveVectors("Displacement");
}

/// Adds the rotation of every cell, if the scene has cell frames: axis times angle.
void add_rotation(vtkCellData& arrays, const Scene& scene, const Displacement& displacement,
                  const BodyNumbering& numbering) {
  const auto rotation = block_rotations(scene, displacement);
  vtkNew<vtkDoubleArray> turn;
  turn->SetName("Rotation");
  turn->SetNumberOfComponents(3);
  turn->SetNumberOfTuples(static_cast<vtkIdType>(numbering.cells.size()));
  vtkIdType tuple = 0;
  for (const std::int64_t cell : numbering.cells) {
    const Eigen::AngleAxisd by(rotation[cell]);
    const Eigen::Vector3d vector = by.angle() * by.axis();
    turn->SetTuple(tuple++, to_world(scene.specimen.placement, {vector[0], vector[1], vector[2]}).data());
  }
  arrays.AddArray(turn);
}

void add_field_data(vtkFieldData& arrays, const Placement& placement, const ExportFields& fields) {
  add_units(arrays, placement,
            "lengths: m; all vectors and tensors in the world's frame; Displacement, DisplacementReference, "
            "DisplacementError, DisplacementErrorEstimate: m; FiberDirection: 1; Strain, NodalStrain, "
            "FiberStrain, PrincipalStrain: 1, tensor shear; VonMises, NodalStress, FiberStress, Stress: Pa; "
            "Rotation: rad; Reaction: N (N/m in 2D); StrainEnergy: J (J/m in 2D)");
  add_text(arrays, "Provenance", fields.provenance);
  if (fields.strain_energy) {
    vtkNew<vtkDoubleArray> energy;
    energy->SetName("StrainEnergy");
    energy->InsertNextValue(*fields.strain_energy);
    arrays.AddArray(energy);
  }
  if (fields.time) {
    vtkNew<vtkDoubleArray> time;
    time->SetName("TimeValue"); // the name that ParaView's readers look for
    time->InsertNextValue(*fields.time);
    arrays.AddArray(time);
  }
}

/// Adds all arrays except names.
void add_arrays(vtkDataSet& body, const Scene& scene, const ExportFields& fields,
                const BodyNumbering& numbering) {
  const Placement& placement = scene.specimen.placement;
  add_point_arrays(body, scene, fields, numbering);
  add_matter(*body.GetCellData(), scene, placement, numbering);
  body.GetCellData()->SetActiveScalars("MaterialId");
  with_strains(fields, [&](const auto& of) {
    add_strain_and_stress(*body.GetCellData(), scene, FieldsOfCells(scene, of), placement, numbering,
                          fields.has_stress);
  });
  if (in_blocks(scene))
    add_rotation(*body.GetCellData(), scene, *fields.displacement, numbering);
  add_field_data(*body.GetFieldData(), placement, fields);
  if (fields.unit == LengthUnit::millimetre)
    use_millimetres(body);
}

/// A piece of write_vtk()'s data set. Recovered nodal values use cells of up to two layers beyond it.
vtkSmartPointer<vtkDataSet> data_set_of(const Scene& scene, const ExportFields& fields, const Layers& piece,
                                        vtkFieldData& names) {
  constexpr int beyond = 2;
  const BodyNumbering of_body = numbering_of(scene.specimen, piece);
  const auto body = cell_grid(scene.specimen, of_body, true);
  for (int i = 0; i < names.GetNumberOfArrays(); ++i)
    body->GetFieldData()->AddArray(names.GetAbstractArray(i));
  add_layers(*body->GetFieldData(), piece);
  const LayersOfBody layers(
      scene, fields,
      {std::max(0, piece.first - beyond), std::min(scene.specimen.grid.cells()[2], piece.end + beyond)});
  add_arrays(*body, layers.scene(), layers.fields(), layers.numbering(of_body));
  return body;
}

/// @pre 3D; strains are in the frame of the grid
fs::path write_in_pieces(const Scene& scene, const ExportFields& fields, const fs::path& stem) {
  constexpr int pieces_of_file = 12;
  constexpr int most_writers = 4; // each uses 330 MB of memory
  const std::vector<Layers> pieces = pieces_of(scene.specimen, fields.most_cells / pieces_of_file);
  fs::path list = stem;
  list += ".pvtu";
  make_folder_of_pieces(file_of_piece(list, 0).parent_path());
  vtkNew<vtkFieldData> names;
  add_names(*names, scene);
  std::atomic<std::size_t> next{0};
  std::string text;
  const auto write_pieces = [&] {
    for (std::size_t i = next++; i < pieces.size(); i = next++) {
      const auto body = data_set_of(scene, fields, pieces[i], *names);
      write_data_set(*vtkNew<vtkXMLUnstructuredGridWriter>(), *body, file_of_piece(list, i),
                     Compression::lz4);
      if (i == 0)
        text = list_of_pieces(list, pieces.size(), *body);
    }
  };
  std::vector<std::future<void>> others;
  for (int writer = 1; writer < std::min(fields.threads, most_writers); ++writer)
    others.push_back(std::async(std::launch::async, write_pieces));
  write_pieces();
  for (std::future<void>& other : others)
    other.get();
  write_whole(list, text);
  return list;
}

} // namespace

fs::path write_vtk(const Scene& scene, const ExportFields& fields, const fs::path& stem) {
  if (fields.displacement == nullptr)
    throw std::invalid_argument("write_vtk: no displacement");
  require_fit(scene, *fields.displacement, "the displacement");
  if (fields.reference != nullptr)
    require_fit(scene, *fields.reference, "the reference");
  if (fields.error_estimate != nullptr)
    require_fit(scene, *fields.error_estimate, "the estimate of the error");

  const Specimen& specimen = scene.specimen;
  const bool is_whole = specimen.n_matter_cells() == specimen.grid.n_cells();
  if (!is_whole && scene.dimension() == 3 && specimen.n_matter_cells() > fields.most_cells &&
      !in_blocks(scene) && !object_frame(scene).is_turned)
    return write_in_pieces(scene, fields, stem);
  const BodyNumbering numbering = is_whole ? whole_grid(specimen.grid) : matter_only(specimen);
  vtkSmartPointer<vtkDataSet> body;
  if (is_whole)
    body = image_grid(specimen);
  else
    body = cell_grid(specimen, numbering, true);
  add_names(*body->GetFieldData(), scene);
  add_arrays(*body, scene, fields, numbering);

  fs::path file = stem;
  file += ending_of_vtk(scene); // not replace_extension: a stem may contain a dot
  if (is_whole)
    write_data_set(*vtkNew<vtkXMLImageDataWriter>(), *body, file);
  else
    write_data_set(*vtkNew<vtkXMLUnstructuredGridWriter>(), *body, file);
  return file;
}

} // namespace maille::studies
