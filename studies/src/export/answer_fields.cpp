#include "answer_fields.hpp"

#include "body_grid.hpp"
#include "data_set_parts.hpp"

#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkErrorCode.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <fmt/format.h>
#include <stdexcept>

namespace maille::studies {

namespace {

std::optional<Displacement> field(vtkDataSet& body, const char* name, const Scene& scene,
                                  const BodyNumbering& numbering) {
  vtkDataArray* const array = body.GetPointData()->GetArray(name);
  if (array == nullptr || array->GetNumberOfComponents() != 3)
    return std::nullopt;
  Displacement result(scene.specimen.grid);
  const double in_a_metre = is_in_millimetres(body) ? 1e3 : 1;
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
    Vec3 value{};
    array->GetTuple(i, value.data());
    value = to_object(scene.specimen.placement, value);
    for (int c = 0; c < scene.dimension(); ++c)
      result(c, numbering.nodes[static_cast<std::size_t>(i)]) =
          value[static_cast<std::size_t>(c)] / in_a_metre;
  }
  return result;
}

template<class Reader>
vtkSmartPointer<vtkDataSet> read(const std::filesystem::path& file) {
  vtkNew<Reader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  if (reader->GetErrorCode() != vtkErrorCode::NoError)
    throw std::runtime_error("cannot read " + file.string());
  return vtkSmartPointer<vtkDataSet>(reader->GetOutput());
}

} // namespace

AnswerFields read_answer_fields(const Scene& scene, const std::filesystem::path& file) {
  if (!std::filesystem::exists(file))
    throw std::runtime_error("there is no " + file.string());
  const bool is_whole = file.extension() == ".vti";
  const auto body = is_whole ? read<vtkXMLImageDataReader>(file) : read<vtkXMLUnstructuredGridReader>(file);
  const BodyNumbering numbering = is_whole ? whole_grid(scene.specimen.grid) : matter_only(scene.specimen);
  if (body->GetNumberOfPoints() != static_cast<vtkIdType>(numbering.nodes.size()))
    throw std::runtime_error(fmt::format("{} has {} points, the scene's body {}", file.string(),
                                         body->GetNumberOfPoints(), numbering.nodes.size()));
  AnswerFields fields;
  auto displacement = field(*body, "Displacement", scene, numbering);
  if (!displacement)
    throw std::runtime_error(file.string() + " holds no Displacement");
  fields.displacement = std::move(*displacement);
  fields.reference = field(*body, "DisplacementReference", scene, numbering);
  fields.error = field(*body, "DisplacementError", scene, numbering);
  fields.estimate = field(*body, "DisplacementErrorEstimate", scene, numbering);
  return fields;
}

} // namespace maille::studies
