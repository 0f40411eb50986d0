#include "data_set_parts.hpp"

#include "body_grid.hpp"
#include "maille/studies/export/whole_file.hpp"

#include <fmt/format.h>

#include <vtkCallbackCommand.h>
#include <vtkErrorCode.h>
#include <vtkExecutive.h>
#include <vtkNew.h>
#include <vtkStringArray.h>

#include <stdexcept>

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

} // namespace maille::studies
