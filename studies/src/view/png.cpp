#include "maille/studies/export/whole_file.hpp"
#include "view/seen_scene.hpp"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <stdexcept>

namespace maille::studies {

void write_png(const std::vector<std::uint8_t>& rgb, int width, int height,
               const std::filesystem::path& file) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(width, height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const auto row = static_cast<std::ptrdiff_t>(3) * width;
  for (int y = 0; y < height; ++y) // VTK's rows begin at the bottom
    std::copy_n(rgb.begin() + row * y, row,
                static_cast<std::uint8_t*>(image->GetScalarPointer(0, height - 1 - y, 0)));
  vtkNew<vtkPNGWriter> writer; // in memory, since it does not notice a full disk
  writer->SetInputData(image);
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  if (bytes == nullptr)
    throw std::runtime_error("cannot write " + file.string() + ": no PNG can be made of the picture");
  write_whole(file, std::string_view(reinterpret_cast<const char*>(bytes->GetPointer(0)),
                                     static_cast<std::size_t>(bytes->GetNumberOfValues())));
}

} // namespace maille::studies
