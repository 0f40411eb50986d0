// Colour pictures from files, by VTK's readers.

#include "picture/read_picture.hpp"

#include "maille/materials/fault.hpp"

#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkErrorCode.h>
#include <vtkImageData.h>
#include <vtkImageReader2.h>
#include <vtkJPEGReader.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>
#include <vtkSmartPointer.h>
#include <zlib.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace maille::studies {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file, std::string expected, std::string found) {
  throw InputError({{file.string(), 0, "picture", std::move(expected), std::move(found)}});
}

constexpr const char* wanted = "a picture in PNG or JPEG of 8 bits a channel";

std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i)
    number = number << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return number;
}

/// How many bytes a deflated text holds; nothing where it breaks off or is damaged.
std::optional<std::uint64_t> inflated_size(const std::string& deflated) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK)
    return std::nullopt;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(deflated.data()));
  stream.avail_in = static_cast<uInt>(deflated.size());
  std::vector<Bytef> out(std::size_t{1} << 16);
  std::uint64_t size = 0;
  int state = Z_OK;
  while (state == Z_OK) {
    stream.next_out = out.data();
    stream.avail_out = static_cast<uInt>(out.size());
    state = inflate(&stream, Z_NO_FLUSH);
    size += out.size() - stream.avail_out;
  }
  inflateEnd(&stream);
  return state == Z_STREAM_END ? std::optional(size) : std::nullopt;
}

/// A PNG that is whole: where one is damaged, VTK's reader ends the process.
void require_whole_png(const std::filesystem::path& file) {
  constexpr std::size_t signature = 8, around = 12; // of a chunk: length, name, checksum
  constexpr std::uint32_t largest = 16384;
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  std::string deflated;
  std::uint32_t width = 0, height = 0, depth = 0, kind = 0, interlaced = 0;
  bool has_ended = false;
  for (std::size_t at = signature; !has_ended && at + around <= bytes.size();) {
    const std::size_t length = big_endian(bytes, at);
    if (length > bytes.size() - at - around)
      break;
    const std::string name = bytes.substr(at + 4, 4);
    const auto* checked = reinterpret_cast<const Bytef*>(bytes.data()) + at + 4;
    if (crc32(0, checked, static_cast<uInt>(length + 4)) != big_endian(bytes, at + 8 + length))
      break;
    if (name == "IHDR" && length == 13) {
      width = big_endian(bytes, at + 8);
      height = big_endian(bytes, at + 12);
      depth = static_cast<std::uint8_t>(bytes[at + 16]);
      kind = static_cast<std::uint8_t>(bytes[at + 17]);
      interlaced = static_cast<std::uint8_t>(bytes[at + 20]);
    } else if (name == "IDAT")
      deflated.append(bytes, at + 8, length);
    has_ended = name == "IEND";
    at += around + length;
  }
  if (!has_ended || width == 0 || height == 0)
    fail(file, wanted, "a file that breaks off, or is damaged");
  if (width > largest || height > largest)
    fail(file, fmt::format("a picture of at most {} x {} pixels", largest, largest),
         fmt::format("{} x {}", width, height));
  constexpr std::array<std::uint32_t, 7> channels{1, 0, 3, 1, 2, 0, 4}; // by kind of colour
  const std::uint64_t row = 1 + (std::uint64_t{width} * channels.at(kind % 7) * depth + 7) / 8;
  const auto size = inflated_size(deflated);
  if (!size || *size < (interlaced != 0 ? 1 : row * height))
    fail(file, wanted, "a file that breaks off, or is damaged");
}

/// Errors of a reader, in place of words on the standard output.
void take_note(vtkObject* /*reader*/, unsigned long /*event*/, void* has_failed, void* /*message*/) {
  *static_cast<bool*>(has_failed) = true;
}

} // namespace

ColourPicture read_picture(const std::filesystem::path& file) {
  vtkSmartPointer<vtkImageReader2> reader;
  if (file.extension() == ".png")
    reader = vtkSmartPointer<vtkPNGReader>::New();
  else
    reader = vtkSmartPointer<vtkJPEGReader>::New();
  if (reader->CanReadFile(file.c_str()) == 0)
    fail(file, wanted, "a file that is none");
  if (file.extension() == ".png")
    require_whole_png(file);
  bool has_failed = false;
  vtkNew<vtkCallbackCommand> watcher;
  watcher->SetCallback(take_note);
  watcher->SetClientData(&has_failed);
  reader->AddObserver(vtkCommand::ErrorEvent, watcher);
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  if (has_failed || reader->GetErrorCode() != vtkErrorCode::NoError || image->GetNumberOfPoints() == 0)
    fail(file, wanted, "a file that breaks off");
  if (image->GetScalarType() != VTK_UNSIGNED_CHAR)
    fail(file, wanted, fmt::format("{} a channel", image->GetScalarTypeAsString()));
  const int channels = image->GetNumberOfScalarComponents();
  ColourPicture picture;
  picture.width = image->GetDimensions()[0];
  picture.height = image->GetDimensions()[1];
  for (int y = picture.height - 1; y >= 0; --y) // VTK's rows begin at the bottom
    for (int x = 0; x < picture.width; ++x) {
      const auto* pixel = static_cast<const std::uint8_t*>(image->GetScalarPointer(x, y, 0));
      for (int c = 0; c < 3; ++c)
        picture.rgb.push_back(pixel[channels >= 3 ? c : 0]);
    }
  return picture;
}

} // namespace maille::studies
