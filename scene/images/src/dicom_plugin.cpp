// The shared object maille-dicom.so: reads DICOM files by GDCM in a separate process.

#include "apart.hpp"
#include "plugin_readers.hpp"

#include <gdcmImageReader.h>
#include <gdcmReader.h>
#include <gdcmStringFilter.h>
#include <gdcmTrace.h>
#include <gdcmTransferSyntax.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace {

using namespace maille::image_formats;

/// Extra memory, because GDCM allocates the sizes that a file states [bytes].
constexpr std::uint64_t memory = std::uint64_t{256} << 20;

/// DICOM files begin with 128 arbitrary bytes and these letters.
bool begins_as_dicom(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::array<char, 132> bytes{};
  return stream.read(bytes.data(), bytes.size()) && std::memcmp(bytes.data() + 128, "DICM", 4) == 0;
}

std::string text(const gdcm::StringFilter& filter, std::uint16_t group, std::uint16_t element) {
  std::string found = filter.ToString(gdcm::Tag(group, element));
  while (!found.empty() && (found.back() == ' ' || found.back() == '\0'))
    found.pop_back();
  return found;
}

/// The numbers of an element, separated by backslashes; empty if one is unreadable.
std::vector<double> numbers(const gdcm::StringFilter& filter, std::uint16_t group, std::uint16_t element) {
  const std::string found = text(filter, group, element);
  std::vector<double> values;
  for (const char *at = found.data(), *const end = at + found.size(); at < end;) {
    at = std::find_if(at, end, [](char c) { return c != ' ' && c != '+'; });
    double value = 0;
    const auto [behind, error] = std::from_chars(at, end, value);
    if (error != std::errc{})
      return {};
    values.push_back(value);
    at = std::find(behind, end, '\\');
    at += at < end ? 1 : 0;
  }
  return values;
}

double first_or(const std::vector<double>& found, double otherwise) {
  return found.empty() ? otherwise : found.front();
}

/// Values out of the range of int become -1, which is invalid in all headers.
int whole_or(const std::vector<double>& found, int otherwise) {
  const double number = first_or(found, otherwise);
  return number >= 0 && number <= 1e9 ? static_cast<int>(number) : -1;
}

DicomHeader read_header(const std::string& file) {
  bound_memory_and_time(file, memory);
  DicomHeader header;
  if (!begins_as_dicom(file))
    return header;
  gdcm::Reader reader;
  reader.SetFileName(file.c_str());
  if (!reader.ReadUpToTag(gdcm::Tag(0x7fe0, 0x0010))) {
    header.is_damaged = true;
    return header;
  }
  gdcm::StringFilter filter;
  filter.SetFile(reader.GetFile());
  header.is_dicom = true;
  header.series = text(filter, 0x0020, 0x000e);
  header.series_name = text(filter, 0x0008, 0x103e);
  header.image_type = text(filter, 0x0008, 0x0008);
  header.modality = text(filter, 0x0008, 0x0060);
  header.transfer_syntax =
      gdcm::TransferSyntax::GetTSString(reader.GetFile().GetHeader().GetDataSetTransferSyntax());
  header.rows = whole_or(numbers(filter, 0x0028, 0x0010), 0);
  header.columns = whole_or(numbers(filter, 0x0028, 0x0011), 0);
  header.samples = whole_or(numbers(filter, 0x0028, 0x0002), 1);
  header.frames = whole_or(numbers(filter, 0x0028, 0x0008), 1);
  if (const auto found = numbers(filter, 0x0020, 0x0032); found.size() == 3) {
    header.has_position = true;
    std::copy(found.begin(), found.end(), header.position.begin());
  }
  if (const auto found = numbers(filter, 0x0020, 0x0037); found.size() == 6) {
    header.has_orientation = true;
    for (std::size_t i = 0; i < 6; ++i)
      header.along[i / 3][i % 3] = found[i];
  }
  if (const auto found = numbers(filter, 0x0028, 0x0030); found.size() == 2) {
    header.has_spacing = true;
    header.row_spacing = found[0];
    header.column_spacing = found[1];
  }
  header.thickness = first_or(numbers(filter, 0x0018, 0x0088), first_or(numbers(filter, 0x0018, 0x0050), 0));
  header.slope = first_or(numbers(filter, 0x0028, 0x1053), 1);
  header.intercept = first_or(numbers(filter, 0x0028, 0x1052), 0);
  return header;
}

/// Calls put(values) for successive parts of the pixels.
template<class Stored, class Put>
void convert(const std::vector<char>& bytes, const Put& put) {
  constexpr std::size_t in_part = std::size_t{1} << 16;
  std::vector<double> part;
  for (std::size_t i = 0; i < bytes.size() / sizeof(Stored); ++i) {
    Stored value;
    std::memcpy(&value, bytes.data() + i * sizeof(Stored), sizeof(Stored));
    part.push_back(static_cast<double>(value));
    if (part.size() == in_part) {
      put(part);
      part.clear();
    }
  }
  put(part);
}

/// True if the file ends before the announced pixels, which GDCM would fill silently. For compressed pixels
/// the decoder reports it.
bool is_cut_short(const std::string& file, const gdcm::DataSet& data) {
  const gdcm::Tag tag(0x7fe0, 0x0010);
  if (!data.FindDataElement(tag) || data.GetDataElement(tag).GetVL().IsUndefined())
    return false;
  const std::uint32_t length = data.GetDataElement(tag).GetVL();
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
  // Group, element, with explicit VR the representation and two zeros, and the length.
  for (const bool is_big : {false, true}) {
    const std::string name = is_big ? std::string("\x7f\xe0\x00\x10", 4) : std::string("\xe0\x7f\x10\x00", 4);
    std::string size(4, '\0');
    for (unsigned n = 0; n < 4; ++n)
      size[is_big ? 3 - n : n] = static_cast<char>(length >> (8 * n) & 0xffU);
    for (std::size_t at = bytes.find(name); at != std::string::npos; at = bytes.find(name, at + 1))
      for (const std::size_t to_size : {std::size_t{4}, std::size_t{8}})
        if (at + to_size + 4 <= bytes.size() && bytes.compare(at + to_size, 4, size) == 0 &&
            at + to_size + 4 + length > bytes.size())
          return true;
  }
  return false;
}

/// True if uncompressed pixels have fewer bytes than rows and columns require; GDCM would fill the rest.
bool has_too_few_bytes(const gdcm::DataSet& data, const gdcm::Image& image) {
  const gdcm::Tag tag(0x7fe0, 0x0010);
  const gdcm::PixelFormat& format = image.GetPixelFormat();
  if (!data.FindDataElement(tag) || data.GetDataElement(tag).GetVL().IsUndefined())
    return false;
  const std::size_t pixels = image.GetBufferLength() / format.GetPixelSize(),
                    bits = std::size_t{format.GetBitsAllocated()} * format.GetSamplesPerPixel();
  return std::uint32_t{data.GetDataElement(tag).GetVL()} < pixels * bits / 8;
}

/// Corrects pixels if the compressed stream and the header disagree about the sign: the header decides.
class SignOfHeader {
public:
  SignOfHeader(const std::string& file, const gdcm::PixelFormat& format) {
    gdcm::Reader reader;
    reader.SetFileName(file.c_str());
    if (!reader.ReadUpToTag(gdcm::Tag(0x7fe0, 0x0010)))
      return;
    gdcm::StringFilter filter;
    filter.SetFile(reader.GetFile());
    if (!reader.GetFile().GetHeader().GetDataSetTransferSyntax().IsEncapsulated())
      return;
    is_signed_ = first_or(numbers(filter, 0x0028, 0x0103), 0) == 1;
    range_ = std::ldexp(1.0, format.GetBitsStored());
  }
  void correct(std::vector<double>& values) const {
    if (range_ == 0)
      return;
    for (double& value : values)
      if (is_signed_ && value >= range_ / 2 && value < range_)
        value -= range_;
      else if (!is_signed_ && value < 0)
        value += range_;
  }

private:
  bool is_signed_ = false;
  double range_ = 0; ///< 0: not compressed, nothing to correct
};

/// @param begin receives the number of pixels, before the first part
template<class Begin, class Put>
std::string read_pixels(const std::string& file, const Begin& begin, const Put& put) {
  bound_memory_and_time(file, memory);
  gdcm::ImageReader reader;
  reader.SetFileName(file.c_str());
  if (!reader.Read())
    return "pixels that GDCM cannot decode";
  if (is_cut_short(file, reader.GetFile().GetDataSet()))
    return "a file that is cut short";
  const gdcm::Image& image = reader.GetImage();
  if (has_too_few_bytes(reader.GetFile().GetDataSet(), image))
    return "fewer bytes of pixels than its rows and columns ask for";
  std::error_code ignored;
  const std::uintmax_t size = std::filesystem::file_size(file, ignored);
  constexpr std::size_t always = std::size_t{1} << 25, a_byte = 20; // 4096 x 4096 pixels of 16 bits
  if (image.GetBufferLength() > always + a_byte * size)
    return "more pixels than its size allows";
  std::vector<char> bytes(image.GetBufferLength());
  if (!image.GetBuffer(bytes.data()))
    return "pixels that GDCM cannot decode";
  const SignOfHeader sign(file, image.GetPixelFormat());
  const auto give = [&]<class Stored>(Stored /*one*/) {
    begin(bytes.size() / sizeof(Stored));
    convert<Stored>(bytes, [&](std::vector<double>& part) {
      sign.correct(part);
      put(part);
    });
    return std::string();
  };
  switch (image.GetPixelFormat().GetScalarType()) {
  case gdcm::PixelFormat::UINT8:
    return give(std::uint8_t{});
  case gdcm::PixelFormat::INT8:
    return give(std::int8_t{});
  case gdcm::PixelFormat::UINT12:
  case gdcm::PixelFormat::UINT16:
    return give(std::uint16_t{});
  case gdcm::PixelFormat::INT12:
  case gdcm::PixelFormat::INT16:
    return give(std::int16_t{});
  case gdcm::PixelFormat::UINT32:
    return give(std::uint32_t{});
  case gdcm::PixelFormat::INT32:
    return give(std::int32_t{});
  case gdcm::PixelFormat::FLOAT32:
    return give(float{});
  case gdcm::PixelFormat::FLOAT64:
    return give(double{});
  default:
    return "pixels of a type that is no number of 8 to 64 bits";
  }
}

struct Plain {
  bool is_dicom = false, is_damaged = false, has_position = false, has_orientation = false,
       has_spacing = false;
  int columns = 0, rows = 0, frames = 0, samples = 0;
  std::array<double, 14> numbers{};
};

void put(const Pipe& pipe, const DicomHeader& h) {
  const Plain plain{h.is_dicom,
                    h.is_damaged,
                    h.has_position,
                    h.has_orientation,
                    h.has_spacing,
                    h.columns,
                    h.rows,
                    h.frames,
                    h.samples,
                    {h.position[0], h.position[1], h.position[2], h.along[0][0], h.along[0][1], h.along[0][2],
                     h.along[1][0], h.along[1][1], h.along[1][2], h.row_spacing, h.column_spacing,
                     h.thickness, h.slope, h.intercept}};
  pipe.put(&plain, sizeof(plain));
  for (const std::string* text : {&h.series, &h.series_name, &h.modality, &h.transfer_syntax, &h.image_type})
    pipe.put_text(*text);
}

bool take(const Pipe& pipe, DicomHeader& h) {
  Plain plain;
  if (!pipe.take(&plain, sizeof(plain)))
    return false;
  h.is_dicom = plain.is_dicom;
  h.is_damaged = plain.is_damaged;
  h.has_position = plain.has_position;
  h.has_orientation = plain.has_orientation;
  h.has_spacing = plain.has_spacing;
  h.columns = plain.columns;
  h.rows = plain.rows;
  h.frames = plain.frames;
  h.samples = plain.samples;
  const auto& n = plain.numbers;
  h.position = {n[0], n[1], n[2]};
  h.along = {{{n[3], n[4], n[5]}, {n[6], n[7], n[8]}}};
  h.row_spacing = n[9];
  h.column_spacing = n[10];
  h.thickness = n[11];
  h.slope = n[12];
  h.intercept = n[13];
  for (std::string* text : {&h.series, &h.series_name, &h.modality, &h.transfer_syntax, &h.image_type})
    if (!pipe.take_text(*text))
      return false;
  return true;
}

std::vector<DicomHeader> headers(const std::vector<std::string>& files) {
  std::vector<DicomHeader> found;
  while (found.size() < files.size()) { // if a file kills the process, another one continues after it
    const std::size_t first = found.size();
    const auto work = [&](const Pipe& pipe) {
      for (std::size_t n = first; n < files.size(); ++n)
        put(pipe, read_header(files[n]));
    };
    const Apart child(work);
    for (DicomHeader header; found.size() < files.size() && take(child.pipe, header); header = {})
      found.push_back(header);
    if (found.size() < files.size()) {
      found.emplace_back();
      found.back().is_damaged = true;
    }
  }
  return found;
}

std::string pixels(const std::string& file, std::vector<double>& values) {
  const auto work = [&](const Pipe& pipe) {
    const auto begin = [&](std::size_t n) {
      pipe.put_text({});
      pipe.put(&n, sizeof(n));
    };
    const auto put = [&](const std::vector<double>& part) {
      pipe.put(part.data(), part.size() * sizeof(double));
    };
    if (const std::string said = read_pixels(file, begin, put); !said.empty())
      pipe.put_text(said);
  };
  const Apart child(work);
  std::string said;
  std::size_t size = 0;
  constexpr std::size_t most = std::size_t{1} << 32U; // 65536 x 65536
  if (!child.pipe.take_text(said))
    return too_much;
  if (!said.empty())
    return said;
  if (!child.pipe.take(&size, sizeof(size)) || size > most)
    return too_much;
  values.resize(size);
  return child.pipe.take(values.data(), size * sizeof(double)) ? "" : too_much;
}

constexpr DicomFunctions functions{.headers = headers, .pixels = pixels};

} // namespace

extern "C" const void* maille_plugin(std::size_t layout, const void* host);

extern "C" const void* maille_plugin(std::size_t layout, const void* /*host*/) {
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  return layout == maille::image_formats::dicom_layout ? &functions : nullptr;
}
