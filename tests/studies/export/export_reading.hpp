#pragma once
/// What VTK's own readers find in a file.

#include "maille/base/grid.hpp"
#include "support/temporary_folder.hpp"

#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <filesystem>
#include <string>

namespace maille::test {

inline vtkSmartPointer<vtkDataSet> read_back(const std::filesystem::path& file) {
  if (file.extension() == ".vti") {
    vtkNew<vtkXMLImageDataReader> reader;
    reader->SetFileName(file.c_str());
    reader->Update();
    return vtkSmartPointer<vtkDataSet>(reader->GetOutputAsDataSet());
  }
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  return vtkSmartPointer<vtkDataSet>(reader->GetOutputAsDataSet());
}

inline Vec3 tuple3(vtkDataArray& array, vtkIdType tuple) {
  Vec3 values{};
  array.GetTuple(tuple, values.data());
  return values;
}

} // namespace maille::test
