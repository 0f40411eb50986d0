// Colour pictures from files.

#include "picture/read_picture.hpp"

#include "maille/materials/text_file.hpp"

#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkErrorCode.h>
#include <vtkImageData.h>
#include <vtkJPEGReader.h>
#include <vtkNew.h>

#include <cstddef>

namespace maille::studies {

namespace {

constexpr std::int64_t largest_file = std::int64_t{1} << 30; ///< [bytes]

/// Checks the size in the header of a JPEG (ITU T.81, B.2.2) against the size of its file.
void require_jpeg_size(std::string_view bytes, const std::filesystem::path& file) {
  const auto byte = [&](std::size_t at) { return std::uint64_t{static_cast<std::uint8_t>(bytes[at])}; };
  for (std::size_t at = 2; at + 9 < bytes.size();) {
    if (byte(at) != 0xff)
      break;
    const auto marker = byte(at + 1);
    if (marker == 0xff || marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8)) { // segments without a length
      at += marker == 0xff ? 1 : 2;
      continue;
    }
    if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc)
      return require_picture_size(file, byte(at + 7) << 8 | byte(at + 8), byte(at + 5) << 8 | byte(at + 6),
                                  bytes.size());
    at += 2 + (byte(at + 2) << 8 | byte(at + 3));
  }
  fail_picture(file, wanted_picture, "a file that is none, or is damaged");
}

/// Records errors of a reader, which would otherwise print to the standard output.
void take_note(vtkObject* /*reader*/, unsigned long /*event*/, void* has_failed, void* /*message*/) {
  *static_cast<bool*>(has_failed) = true;
}

} // namespace

ColourPicture read_picture(const std::filesystem::path& file) {
  const std::string bytes = read_text_file(file, "a picture", largest_file);
  if (file.extension() == ".png")
    return read_png(bytes, file);
  require_jpeg_size(bytes, file);
  vtkNew<vtkJPEGReader> reader;
  if (reader->CanReadFile(file.c_str()) == 0)
    fail_picture(file, wanted_picture, "a file that is none");
  bool has_failed = false;
  vtkNew<vtkCallbackCommand> watcher;
  watcher->SetCallback(take_note);
  watcher->SetClientData(&has_failed);
  reader->AddObserver(vtkCommand::ErrorEvent, watcher);
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  if (has_failed || reader->GetErrorCode() != vtkErrorCode::NoError || image->GetNumberOfPoints() == 0)
    fail_picture(file, wanted_picture, "a file that breaks off");
  if (image->GetScalarType() != VTK_UNSIGNED_CHAR)
    fail_picture(file, wanted_picture, fmt::format("{} a channel", image->GetScalarTypeAsString()));
  const int channels = image->GetNumberOfScalarComponents();
  ColourPicture picture;
  picture.width = image->GetDimensions()[0];
  picture.height = image->GetDimensions()[1];
  picture.rgb.reserve(std::size_t{3} * image->GetNumberOfPoints());
  for (int y = picture.height - 1; y >= 0; --y) // VTK's rows start at the bottom
    for (int x = 0; x < picture.width; ++x) {
      const auto* pixel = static_cast<const std::uint8_t*>(image->GetScalarPointer(x, y, 0));
      for (int c = 0; c < 3; ++c)
        picture.rgb.push_back(pixel[channels >= 3 ? c : 0]);
    }
  return picture;
}

} // namespace maille::studies
