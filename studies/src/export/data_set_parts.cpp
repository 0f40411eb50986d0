#include "data_set_parts.hpp"

#include "body_grid.hpp"
#include "export/whole_file.hpp"
#include "maille/scene/cell_fields.hpp"

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
#include <cmath>
#include <map>
#include <span>
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

namespace {

/// An unfilled array. @param components  their names; none: a scalar array
vtkSmartPointer<vtkDoubleArray> array_for(const char* name, std::span<const char* const> components,
                                          std::size_t tuples) {
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(name);
  array->SetNumberOfComponents(std::max(1, static_cast<int>(components.size())));
  for (std::size_t component = 0; component < components.size(); ++component)
    array->SetComponentName(static_cast<int>(component), components[component]);
  array->SetNumberOfTuples(static_cast<vtkIdType>(tuples));
  return array;
}

constexpr std::array<const char*, 6> tensor_components{"XX", "YY", "ZZ", "XY", "YZ", "XZ"};

} // namespace

vtkSmartPointer<vtkDoubleArray> tensor_array(const char* name,
                                             const std::vector<std::array<double, 6>>& tensors,
                                             const Placement& placement,
                                             const std::vector<std::int64_t>& shown) {
  auto array = array_for(name, tensor_components, shown.size());
  vtkIdType tuple = 0;
  for (const std::int64_t i : shown)
    array->SetTuple(tuple++, tensor_to_world(placement, tensors[i]).data());
  return array;
}

void add_text(vtkFieldData& arrays, const char* name, const std::string& text) {
  vtkNew<vtkStringArray> array;
  array->SetName(name);
  array->InsertNextValue(text);
  arrays.AddArray(array);
}

void add_units(vtkFieldData& arrays, const Placement& placement, const std::string& text) {
  const char* const world = placement.world == WorldAxes::ras   ? "; world: RAS"
                            : placement.world == WorldAxes::lps ? "; world: LPS"
                                                                : "";
  add_text(arrays, "Units", text + world);
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

void write_data_set(vtkXMLWriter& writer, vtkDataSet& body, const fs::path& file, Compression compression) {
  writer.SetInputData(&body);
  writer.SetDataModeToAppended();
  writer.EncodeAppendedDataOff();
  if (compression == Compression::zlib)
    writer.SetCompressorTypeToZLib();
  else
    writer.SetCompressorTypeToLZ4();
  writer.SetHeaderTypeToUInt64();
  // VTK does not print observed events: the messages of the writer, and those of its pipeline about the
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
    fibre->SetTuple(tuple++, to_world(placement, fibres[cell]).data());
  }
  arrays.AddArray(material_id);
  arrays.AddArray(fibre);
  if (specimen.label.empty())
    return;
  vtkNew<vtkIntArray> label;
  label->SetName("Label");
  for (const std::int64_t cell : numbering.cells)
    label->InsertNextValue(specimen.label[cell]);
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
      material_of.emplace(specimen.label[cell], specimen.material(cell));
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

void add_strain_and_stress(vtkCellData& arrays, const Scene& scene, FieldsOfCells fields,
                           const Placement& placement, const BodyNumbering& numbering, bool with_stress) {
  constexpr std::array<const char*, 3> principal_components{"Largest", "Middle", "Smallest"};
  const std::size_t n = numbering.cells.size();
  const auto added = [&](bool is_there, const char* name, std::span<const char* const> components = {}) {
    vtkSmartPointer<vtkDoubleArray> array;
    if (is_there)
      arrays.AddArray(array = array_for(name, components, n));
    return array;
  };
  const bool has_fibres = scene.has_fibres();
  const auto strain = added(true, "Strain", tensor_components),
             principal = added(true, "PrincipalStrain", principal_components),
             fibre_strain = added(has_fibres, "FiberStrain"),
             stress = added(with_stress, "Stress", tensor_components),
             von_mises = added(with_stress, "VonMises"),
             fibre_stress = added(with_stress && has_fibres, "FiberStress");
  const bool is_finite = scene.strain == Strain::finite;
  const auto green = added(is_finite, "GreenLagrangeStrain", tensor_components),
             logs = added(is_finite, "LogarithmicStrain", tensor_components),
             fibre_stretch = added(is_finite && has_fibres, "FiberStretch"),
             nominal_stress = added(is_finite && with_stress, "NominalStress", tensor_components);
  vtkIdType tuple = 0;
  for (const std::int64_t cell : numbering.cells) {
    const FieldsOfCells::Values of = fields(cell);
    if (is_finite) {
      const auto lagrange = green_lagrange(of.strain);
      green->SetTuple(tuple, tensor_to_world(placement, lagrange).data());
      logs->SetTuple(tuple, tensor_to_world(placement, logarithmic(of.strain)).data());
      if (fibre_stretch != nullptr)
        fibre_stretch->SetValue(tuple, std::sqrt(1 + 2 * along(lagrange, scene.specimen.fibre_of(cell))));
    }
    if (nominal_stress != nullptr)
      nominal_stress->SetTuple(tuple, tensor_to_world(placement, nominal(of.strain, of.stress)).data());
    strain->SetTuple(tuple, tensor_to_world(placement, of.strain).data());
    principal->SetTuple(tuple, principal_values(of.strain).data());
    if (fibre_strain != nullptr) // a T a: the same in every frame
      fibre_strain->SetValue(tuple, along(of.strain, scene.specimen.fibre_of(cell)));
    if (stress != nullptr) {
      stress->SetTuple(tuple, tensor_to_world(placement, of.stress).data());
      von_mises->SetValue(tuple, of.von_mises);
    }
    if (fibre_stress != nullptr)
      fibre_stress->SetValue(tuple, along(of.stress, scene.specimen.fibre_of(cell)));
    ++tuple;
  }
}

} // namespace maille::studies
