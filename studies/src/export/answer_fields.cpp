#include "answer_fields.hpp"

#include "body_grid.hpp"
#include "body_pieces.hpp"
#include "data_set_parts.hpp"

#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkErrorCode.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <fmt/format.h>
#include <optional>
#include <stdexcept>
#include <vector>

namespace maille::studies {
namespace fs = std::filesystem;

namespace {

/// Puts an array of some nodes into a field of all, which it makes where there is none.
void add_field(vtkDataSet& body, const char* name, const Scene& scene, const BodyNumbering& numbering,
               std::optional<Displacement>& all) {
  vtkDataArray* const array = body.GetPointData()->GetArray(name);
  if (array == nullptr || array->GetNumberOfComponents() != 3)
    return;
  if (!all)
    all.emplace(scene.specimen.grid);
  const double in_a_metre = is_in_millimetres(body) ? 1e3 : 1;
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
    Vec3 value{};
    array->GetTuple(i, value.data());
    value = to_object(scene.specimen.placement, value);
    for (int c = 0; c < scene.dimension(); ++c)
      (*all)(c, numbering.nodes[static_cast<std::size_t>(i)]) =
          value[static_cast<std::size_t>(c)] / in_a_metre;
  }
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
  AnswerFields fields;
  std::optional<Displacement> displacement;
  const auto add = [&](const fs::path& part, vtkDataSet& body, const BodyNumbering& numbering) {
    if (body.GetNumberOfPoints() != static_cast<vtkIdType>(numbering.nodes.size()))
      throw std::runtime_error(fmt::format("{} has {} points, the scene's body {}", part.string(),
                                           body.GetNumberOfPoints(), numbering.nodes.size()));
    add_field(body, "Displacement", scene, numbering, displacement);
    add_field(body, "DisplacementReference", scene, numbering, fields.reference);
    add_field(body, "DisplacementError", scene, numbering, fields.error);
    add_field(body, "DisplacementErrorEstimate", scene, numbering, fields.estimate);
  };
  if (file.extension() == ".pvtu")
    for (std::size_t i = 0; fs::exists(file_of_piece(file, i)); ++i) {
      const auto piece = read<vtkXMLUnstructuredGridReader>(file_of_piece(file, i));
      const Layers layers = layers_in(*piece->GetFieldData());
      if (layers.first < 0 || layers.first >= layers.end || layers.end > scene.specimen.grid.cells()[2])
        throw std::runtime_error(file.string() + " is of another grid");
      add(file, *piece, numbering_of(scene.specimen, layers));
    }
  else if (file.extension() == ".vti")
    add(file, *read<vtkXMLImageDataReader>(file), whole_grid(scene.specimen.grid));
  else
    add(file, *read<vtkXMLUnstructuredGridReader>(file), matter_only(scene.specimen));
  if (!displacement)
    throw std::runtime_error(file.string() + " holds no Displacement");
  fields.displacement = std::move(*displacement);
  return fields;
}

} // namespace maille::studies
