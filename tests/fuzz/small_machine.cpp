/// The machine that readers are tried on, by the linker's --wrap: little memory, and headers and values from
/// bytes in place of GDCM and VTK, which work in processes of their own.

#include "plugin_readers.hpp"
#include "support/temporary_folder.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// For maille::available_memory(): sizes are held against this.
extern "C" std::int64_t __wrap__ZN6maille16available_memoryEv();
extern "C" std::int64_t __wrap__ZN6maille16available_memoryEv() {
  return std::int64_t{1} << 20;
}

namespace {

using maille::image_formats::DicomHeader;

/// Numbers as they stand in the file; it needs no GDCM.
std::vector<DicomHeader> headers(const std::vector<std::string>& files) {
  std::vector<DicomHeader> all;
  for (const std::string& file : files) {
    std::array<char, 128> bytes{};
    const std::string text = std::filesystem::is_regular_file(file) ? maille::test::text_of(file) : "";
    text.copy(bytes.data(), bytes.size());
    std::array<double, 14> number{};
    std::memcpy(number.data(), bytes.data(), sizeof number);
    const auto flag = [&](std::size_t at) { return static_cast<unsigned char>(bytes[112 + at]); };
    DicomHeader& header = all.emplace_back();
    header.is_dicom = !text.empty();
    header.is_damaged = flag(0) == 'd';
    header.series = std::string(1, static_cast<char>('a' + flag(1) % 2));
    header.modality = flag(2) == 'S' ? "SEG" : "CT";
    header.columns = flag(3) - 1;
    header.rows = flag(4) - 1;
    header.frames = flag(5);
    header.samples = flag(6);
    header.has_position = header.has_orientation = header.has_spacing = flag(7) != 'n';
    std::copy_n(number.begin(), 3, header.position.begin());
    std::copy_n(number.begin() + 3, 3, header.along[0].begin());
    std::copy_n(number.begin() + 6, 3, header.along[1].begin());
    header.row_spacing = number[9];
    header.column_spacing = number[10];
    header.thickness = number[11];
    header.slope = number[12];
    header.intercept = number[13];
  }
  return all;
}

std::string pixels(const std::string& file, std::vector<double>& values) {
  const DicomHeader header = headers({file}).front();
  values.assign(static_cast<std::size_t>(std::max(0, header.rows) * std::max(0, header.columns)), 1);
  return "";
}

/// The element ImageData as it stands in the file; what is behind it is the text `Units`.
std::string header_of_vti(const std::string& file, std::string& xml, std::string& units) {
  constexpr std::string_view end = "</ImageData>";
  const std::string text = maille::test::text_of(file);
  const std::size_t from = text.find("<ImageData"), to = text.find(end, from);
  if (to == std::string::npos)
    return "no image data";
  xml = text.substr(from, to + end.size() - from);
  units = text.substr(to + end.size());
  return "";
}

/// The file's bytes over and over; a fault where it is as long as a multiple of 16.
std::function<std::string(std::span<char>)> values_of_vti(const std::string& file, bool, const std::string&,
                                                          std::int64_t) {
  return [text = maille::test::text_of(file), next = std::size_t{0}](std::span<char> to) mutable {
    for (char& byte : to)
      byte = text[next++ % text.size()];
    return std::string(text.size() % 16 == 0 ? "data that end early" : "");
  };
}

} // namespace

/// For maille::open_plugin(): the plugins of DICOM and of VTK's images are the stand-ins above.
extern "C" const void* __real__ZN6maille11open_pluginEPKcS1_mPKv(const char* file, const char* what,
                                                                 std::size_t layout, const void* host);
extern "C" const void* __wrap__ZN6maille11open_pluginEPKcS1_mPKv(const char* file, const char* what,
                                                                 std::size_t layout, const void* host);
extern "C" const void* __wrap__ZN6maille11open_pluginEPKcS1_mPKv(const char* file, const char* what,
                                                                 std::size_t layout, const void* host) {
  static constexpr maille::image_formats::DicomFunctions functions{headers, pixels};
  if (std::strstr(file, "dicom") != nullptr)
    return &functions;
  const void* const real = __real__ZN6maille11open_pluginEPKcS1_mPKv(file, what, layout, host);
  if (std::strstr(file, "vtk-readers") == nullptr)
    return real;
  static maille::image_formats::VtkReaders vtk = *static_cast<const maille::image_formats::VtkReaders*>(real);
  vtk.header = header_of_vti; // arrays of results are VTK's own, which field_file tries
  vtk.values = values_of_vti;
  return &vtk;
}
