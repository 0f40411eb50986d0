#include "data_set_parts.hpp"

#include "body_grid.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/studies/export/whole_file.hpp"

#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkErrorCode.h>
#include <vtkExecutive.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string_view>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

void keep_message(vtkObject*, unsigned long, void* kept, void* message) {
  auto& text = *static_cast<std::string*>(kept);
  if (text.empty() && message != nullptr)
    text = static_cast<const char*>(message);
}

} // namespace

vtkSmartPointer<vtkDoubleArray> tensor_array(const char* name,
                                             const std::vector<std::array<double, 6>>& tensors,
                                             const Placement& placement,
                                             const std::vector<std::int64_t>& shown) {
  constexpr std::array<const char*, 6> component_names{"XX", "YY", "ZZ", "XY", "YZ", "XZ"};
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(name);
  array->SetNumberOfComponents(6);
  for (int component = 0; component < 6; ++component)
    array->SetComponentName(component, component_names[static_cast<std::size_t>(component)]);
  array->SetNumberOfTuples(static_cast<vtkIdType>(shown.size()));
  vtkIdType tuple = 0;
  for (const std::int64_t i : shown)
    array->SetTuple(tuple++, tensor_to_world(placement, tensors[static_cast<std::size_t>(i)]).data());
  return array;
}

void add_text(vtkFieldData& arrays, const char* name, const std::string& text) {
  vtkNew<vtkStringArray> array;
  array->SetName(name);
  array->InsertNextValue(text);
  arrays.AddArray(array);
}

void use_millimetres(vtkDataSet& body) {
  constexpr double millimetres = 1e3;
  if (auto* const image = vtkImageData::SafeDownCast(&body)) {
    std::array<double, 3> origin{}, spacing{};
    image->GetOrigin(origin.data());
    image->GetSpacing(spacing.data());
    image->SetOrigin(millimetres * origin[0], millimetres * origin[1], millimetres * origin[2]);
    image->SetSpacing(millimetres * spacing[0], millimetres * spacing[1], millimetres * spacing[2]);
  } else if (auto* const points = vtkPointSet::SafeDownCast(&body)) {
    for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i) {
      std::array<double, 3> at{};
      points->GetPoint(i, at.data());
      points->GetPoints()->SetPoint(i, millimetres * at[0], millimetres * at[1], millimetres * at[2]);
    }
  }
  for (int a = 0; a < body.GetPointData()->GetNumberOfArrays(); ++a)
    if (vtkDataArray* const array = body.GetPointData()->GetArray(a);
        array != nullptr && std::string_view(array->GetName()).starts_with("Displacement"))
      for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i)
        for (int c = 0; c < array->GetNumberOfComponents(); ++c)
          array->SetComponent(i, c, millimetres * array->GetComponent(i, c));
  if (auto* const units = vtkStringArray::SafeDownCast(body.GetFieldData()->GetAbstractArray("Units"))) {
    std::string text = units->GetValue(0);
    for (std::size_t at = text.find(": m;"); at != std::string::npos; at = text.find(": m;", at + 1))
      text.replace(at, 4, ": mm;");
    units->SetValue(0, text);
  }
}

bool is_in_millimetres(vtkDataSet& body) {
  auto* const units = vtkStringArray::SafeDownCast(body.GetFieldData()->GetAbstractArray("Units"));
  return units != nullptr && units->GetNumberOfValues() > 0 &&
         std::string(units->GetValue(0)).starts_with("lengths: mm");
}

void write_data_set(vtkXMLWriter& writer, vtkDataSet& body, const fs::path& file) {
  writer.SetInputData(&body);
  writer.SetDataModeToAppended();
  writer.EncodeAppendedDataOff();
  writer.SetCompressorTypeToZLib();
  writer.SetHeaderTypeToUInt64();
  // What is observed VTK does not print: the writer's complaint, and its pipeline's complaint about the
  // writer.
  std::string complaint;
  vtkNew<vtkCallbackCommand> listener;
  listener->SetCallback(keep_message);
  listener->SetClientData(&complaint);
  writer.AddObserver("ErrorEvent", listener);
  writer.GetExecutive()->AddObserver("ErrorEvent", listener);
  write_whole(file, [&](const fs::path& path) {
    writer.SetFileName(path.c_str());
    const int written = writer.Write();
    if (written == 0 || writer.GetErrorCode() != vtkErrorCode::NoError || !complaint.empty())
      throw std::runtime_error(fmt::format("cannot write {}: {}", file.string(),
                                           vtkErrorCode::GetStringFromErrorCode(writer.GetErrorCode())));
  });
}

namespace {

using Tensors = std::vector<std::array<double, 6>>;

/// A number a cell. @param value  of a cell's place on the grid
template<class Value>
vtkSmartPointer<vtkDoubleArray> scalar_array(const char* name, const BodyNumbering& numbering,
                                             const Value& value) {
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(name);
  array->SetNumberOfTuples(static_cast<vtkIdType>(numbering.cells.size()));
  vtkIdType tuple = 0;
  for (const std::int64_t cell : numbering.cells)
    array->SetValue(tuple++, value(cell));
  return array;
}

/// a T a along the fibres: the same in every frame.
vtkSmartPointer<vtkDoubleArray> along_fibres(const char* name, const Tensors& tensors,
                                             const Specimen& specimen, const BodyNumbering& numbering) {
  return scalar_array(name, numbering, [&](std::int64_t cell) {
    return along(tensors[static_cast<std::size_t>(cell)], specimen.fibre_of(cell));
  });
}

/// The three principal values, the largest first.
vtkSmartPointer<vtkDoubleArray> principal_array(const char* name, const Tensors& tensors,
                                                const BodyNumbering& numbering) {
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(name);
  array->SetNumberOfComponents(3);
  constexpr std::array<const char*, 3> component_names{"Largest", "Middle", "Smallest"};
  for (int component = 0; component < 3; ++component)
    array->SetComponentName(component, component_names[static_cast<std::size_t>(component)]);
  array->SetNumberOfTuples(static_cast<vtkIdType>(numbering.cells.size()));
  vtkIdType tuple = 0;
  for (const std::int64_t cell : numbering.cells)
    array->SetTuple(tuple++, principal_values(tensors[static_cast<std::size_t>(cell)]).data());
  return array;
}

} // namespace

void add_matter(vtkCellData& arrays, const Scene& scene, const Placement& placement,
                const BodyNumbering& numbering) {
  const Specimen& specimen = scene.specimen;
  const auto n_cells = static_cast<vtkIdType>(numbering.cells.size());
  vtkNew<vtkUnsignedCharArray> material_id;
  material_id->SetName("MaterialId");
  material_id->SetNumberOfTuples(n_cells);
  vtkNew<vtkDoubleArray> fibre;
  fibre->SetName("FiberDirection");
  fibre->SetNumberOfComponents(3);
  fibre->SetComponentName(0, "X");
  fibre->SetComponentName(1, "Y");
  fibre->SetComponentName(2, "Z");
  fibre->SetNumberOfTuples(n_cells);
  const std::vector<Vec3> fibres = with_one_sign(specimen, placement);
  vtkIdType tuple = 0;
  for (const std::int64_t cell : numbering.cells) {
    material_id->SetValue(tuple, specimen.material(cell));
    fibre->SetTuple(tuple++, to_world(placement, fibres[static_cast<std::size_t>(cell)]).data());
  }
  arrays.AddArray(material_id);
  arrays.AddArray(fibre);
  if (specimen.label.empty())
    return;
  vtkNew<vtkIntArray> label;
  label->SetName("Label");
  for (const std::int64_t cell : numbering.cells)
    label->InsertNextValue(specimen.label[static_cast<std::size_t>(cell)]);
  arrays.AddArray(label);
}

void add_names(vtkFieldData& arrays, const Scene& scene) {
  vtkNew<vtkStringArray> names;
  names->SetName("MaterialNames");
  for (const Material& material : scene.materials)
    names->InsertNextValue(material.name);
  arrays.AddArray(names);
  const Specimen& specimen = scene.specimen;
  if (specimen.label.empty())
    return;
  std::map<std::int32_t, std::uint8_t> material_of;
  for (std::int64_t cell = 0; cell < specimen.grid.n_cells(); ++cell)
    if (specimen.is_matter(cell))
      material_of.emplace(specimen.label[static_cast<std::size_t>(cell)], specimen.material(cell));
  vtkNew<vtkIntArray> numbers;
  numbers->SetName("LabelNumbers");
  vtkNew<vtkStringArray> materials;
  materials->SetName("LabelMaterials");
  for (const auto& [label, material] : material_of) {
    numbers->InsertNextValue(label);
    materials->InsertNextValue(scene.materials.at(material).name);
  }
  arrays.AddArray(numbers);
  arrays.AddArray(materials);
}

void add_strain_and_stress(vtkCellData& arrays, const Scene& scene, const CellFields& fields,
                           const Placement& placement, const BodyNumbering& numbering, bool with_stress) {
  arrays.AddArray(tensor_array("Strain", fields.strain, placement, numbering.cells));
  arrays.AddArray(principal_array("PrincipalStrain", fields.strain, numbering));
  if (scene.has_fibres())
    arrays.AddArray(along_fibres("FiberStrain", fields.strain, scene.specimen, numbering));
  if (!with_stress)
    return;
  arrays.AddArray(tensor_array("Stress", fields.stress, placement, numbering.cells));
  arrays.AddArray(scalar_array("VonMises", numbering, [&](std::int64_t cell) {
    return fields.von_mises[static_cast<std::size_t>(cell)];
  }));
  if (scene.has_fibres())
    arrays.AddArray(along_fibres("FiberStress", fields.stress, scene.specimen, numbering));
}

} // namespace maille::studies
