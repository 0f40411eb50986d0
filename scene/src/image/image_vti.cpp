// VTK's XML image data (.vti), and arrays of nodes in .vti and .vtu.
//
// Source: VTK File Formats (Kitware), section on XML formats, and VTK 9.1's vtkXMLWriter for what it leaves
// open. Raw appended data is no valid XML, so the file is cut at <AppendedData before the XML is parsed.
// Departures: one Piece only; compressors other than zlib and LZ4 are refused by name.

#include "image/image_vti_data.hpp"
#include "maille/scene/voxel_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

namespace maille::image_formats {
namespace {

using pugi::xml_node;

constexpr std::string_view appended_tag = "<AppendedData";
constexpr std::size_t largest_tag = 4096;
constexpr std::ptrdiff_t largest_markup = 200000; // characters < and quotes: bounds the parser's memory

bool looks_like_xml(std::string_view text) {
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (text.starts_with(byte_order_mark))
    text.remove_prefix(byte_order_mark.size());
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && text[first] == '<';
}

/// Reads the text up to the appended data, and that element's own tag.
void read_text(const std::filesystem::path& file, std::int64_t largest_text, VtiFile& vti, Faults& faults) {
  const ByteSourcePtr source = open_file(file, 0, faults);
  std::string& text = vti.text;
  std::vector<char> chunk(std::size_t{1} << 16);
  std::size_t cut = std::string::npos;
  bool is_at_end = false;
  while (cut == std::string::npos && !is_at_end) {
    const std::size_t got = source->read(chunk);
    is_at_end = got < chunk.size();
    const std::size_t searched = text.size() - std::min(text.size(), appended_tag.size() - 1);
    text.append(chunk.data(), got);
    if (searched == 0 && !looks_like_xml(text)) // do not read on through gibibytes of something else
      faults.fail("", "XML", in_quotes(text));
    cut = text.find(appended_tag, searched);
    if (cut == std::string::npos && static_cast<std::int64_t>(text.size()) > largest_text)
      faults.fail("", fmt::format("at most {} bytes of XML", largest_text), "more");
  }
  if (cut == std::string::npos)
    return;
  while (text.size() < cut + largest_tag && !is_at_end) {
    const std::size_t got = source->read(std::span(chunk).first(largest_tag));
    is_at_end = got < largest_tag;
    text.append(chunk.data(), got);
  }
  const std::size_t tag_end = text.find('>', cut);
  const std::size_t data =
      tag_end == std::string::npos ? tag_end : text.find_first_not_of(" \t\r\n", tag_end + 1);
  if (data == std::string::npos || data - cut > largest_tag || text[data] != '_')
    faults.fail("AppendedData", "a tag and, after white space, an underscore before the data",
                in_quotes(std::string_view(text).substr(cut)));
  vti.appended_from = static_cast<std::int64_t>(data) + 1;
  text.resize(tag_end + 1);
  text += "</AppendedData></VTKFile>";
}

void parse_text(VtiFile& vti, Faults& faults) {
  const std::ptrdiff_t markup = std::count_if(vti.text.begin(), vti.text.end(),
                                              [](char c) { return c == '<' || c == '"' || c == '\''; });
  if (markup > largest_markup)
    faults.fail("", fmt::format("at most {} tags and quotes in the XML", largest_markup),
                fmt::format("{}", markup));
  const pugi::xml_parse_result outcome = vti.document.load_buffer_inplace(
      vti.text.data(), vti.text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!outcome)
    faults.fail("", "well-formed XML", fmt::format("{} at byte {}", outcome.description(), outcome.offset));
}

/// The attribute's text; a fault and nothing if it is not one of those allowed.
std::string choice(xml_node node, const char* name, std::initializer_list<std::string_view> allowed,
                   const char* otherwise, Faults& faults) {
  const std::string value = node.attribute(name).as_string(otherwise);
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end())
    return value;
  std::string expected;
  for (const std::string_view one : allowed)
    expected += (expected.empty() ? "" : " or ") + (one.empty() ? std::string("none") : std::string(one));
  faults.add(name, expected, value.empty() ? "nothing" : in_quotes(value));
  return {};
}

xml_node read_encoding(VtiFile& vti, std::initializer_list<std::string_view> types, Faults& faults) {
  const xml_node root = vti.document.child("VTKFile");
  if (!root)
    faults.fail("VTKFile", "this as the outermost element", in_quotes(vti.document.first_child().name()));
  const std::string type = choice(root, "type", types, "", faults);
  vti.swap_bytes =
      must_swap(choice(root, "byte_order", {"LittleEndian", "BigEndian"}, "", faults) == "BigEndian");
  vti.has_wide_header = choice(root, "header_type", {"UInt32", "UInt64"}, "UInt32", faults) == "UInt64";
  const std::string compressor =
      choice(root, "compressor", {"", "vtkZLibDataCompressor", "vtkLZ4DataCompressor"}, "", faults);
  vti.is_compressed = !compressor.empty();
  vti.is_lz4 = compressor == "vtkLZ4DataCompressor";
  if (vti.appended_from > 0)
    vti.is_appended_raw =
        choice(root.child("AppendedData"), "encoding", {"raw", "base64"}, "", faults) == "raw";
  const xml_node grid = root.child(type.c_str());
  if (!grid && !type.empty())
    faults.add(type, "this element", "none");
  faults.throw_if_any();
  return grid;
}

template<class T>
std::optional<std::vector<T>> numbers(xml_node node, const char* name, std::size_t count, bool is_required,
                                      Faults& faults) {
  const pugi::xml_attribute attribute = node.attribute(name);
  if (attribute.empty() && !is_required)
    return std::nullopt;
  auto values = parse_numbers<T>(attribute.value(), count);
  if (!values)
    faults.add(name, fmt::format("{} number{}", count, count == 1 ? "" : "s"),
               attribute.empty() ? "nothing" : in_quotes(attribute.value()));
  return values;
}

/// First and last point along each axis.
using Extent = std::array<std::array<std::int64_t, 2>, 3>;

Extent read_extent(xml_node grid, Faults& faults) {
  const auto values = numbers<std::int64_t>(grid, "WholeExtent", 6, true, faults);
  faults.throw_if_any();
  Extent extent{};
  constexpr std::int64_t largest = 1 << 30;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    extent[axis] = {(*values)[2 * axis], (*values)[2 * axis + 1]};
    if (extent[axis][0] < -largest || extent[axis][1] > largest || extent[axis][0] > extent[axis][1])
      faults.fail("WholeExtent", fmt::format("first <= last along each axis, within +-{}", largest),
                  in_quotes(grid.attribute("WholeExtent").value()));
  }
  return extent;
}

xml_node only_piece(xml_node grid, Faults& faults) {
  const xml_node piece = grid.child("Piece");
  const auto n_pieces = std::distance(grid.children("Piece").begin(), grid.children("Piece").end());
  if (n_pieces != 1)
    faults.fail("Piece", "one piece", fmt::format("{}", n_pieces));
  const auto whole = parse_numbers<std::int64_t>(grid.attribute("WholeExtent").value(), 6);
  if (parse_numbers<std::int64_t>(piece.attribute("Extent").value(), 6) != whole)
    faults.add("Piece Extent", "the same as WholeExtent", in_quotes(piece.attribute("Extent").value()));
  return piece;
}

/// Arrays of voxels, without VTK's own book-keeping.
std::vector<xml_node> arrays_in(xml_node piece, bool only_active) {
  std::vector<xml_node> arrays;
  for (const char* of : {"CellData", "PointData"}) {
    const std::string_view active = piece.child(of).attribute("Scalars").value();
    for (const xml_node array : piece.child(of).children("DataArray"))
      if (const std::string_view name = array.attribute("Name").value();
          name != "vtkGhostType" && (!only_active || (!active.empty() && name == active)))
        arrays.push_back(array);
  }
  return arrays;
}

/// The active scalars, else the only array; of several a fault that lists them.
xml_node values_of(xml_node piece, Faults& faults) {
  const std::vector<xml_node> all = arrays_in(piece, false), active = arrays_in(piece, true);
  std::vector<xml_node> found = active.empty() ? all : active;
  if (!active.empty()) { // those of cells count before those of points
    const std::string first = found.front().parent().name();
    std::erase_if(found, [&](xml_node array) { return array.parent().name() != first; });
  }
  if (found.empty())
    faults.fail("CellData, PointData", "a DataArray", "none");
  std::string names;
  for (const xml_node array : found)
    names += fmt::format("{}{} of {}", names.empty() ? "" : ", ", in_quotes(array.attribute("Name").value()),
                         array.parent().name());
  if (found.size() > 1)
    faults.fail("Scalars", "one array, or one that is active (Scalars=\"NAME\" of CellData or PointData)",
                names);
  return found.front();
}

/// Whether a text such as `m`, `length: m` or `lengths: m; Stress: Pa` says that lengths are in metres.
bool says_metres(std::string_view text) {
  std::string before;
  std::string word;
  bool is_first = true;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    const bool is_letter = i < text.size() && std::isalnum(static_cast<unsigned char>(text[i])) != 0;
    if (is_letter) {
      word += text[i];
      continue;
    }
    if (word == "m" && (is_first || before == "length" || before == "lengths"))
      return true;
    if (!word.empty()) {
      is_first = false;
      before = std::exchange(word, {});
    }
  }
  return false;
}

double units_per_metre(const std::shared_ptr<VtiFile>& vti, xml_node grid, Faults& faults) {
  constexpr std::size_t longest_text = 4096;
  const xml_node units = grid.child("FieldData").find_child_by_attribute("Array", "Name", "Units");
  if (!units || std::string_view(units.attribute("type").value()) != "String")
    return 1000;
  std::string text(longest_text, '\0');
  text.resize(open_vti_array(vti, units, ScalarType::int8, std::nullopt, faults)->read(text));
  return says_metres(text) ? 1 : 1000;
}

/// Voxel 0 stands at the first point, or half a spacing further in if voxels are cells.
FileGeometry read_geometry(xml_node grid, const Extent& extent, bool has_cells, Faults& faults) {
  FileGeometry geometry;
  geometry.spacing_keys.fill("Spacing");
  geometry.origin_key = "Origin";
  geometry.direction_key = "Direction";
  Vec3 origin{0, 0, 0};
  if (const auto values = numbers<double>(grid, "Spacing", 3, true, faults))
    std::copy(values->begin(), values->end(), geometry.spacing.begin());
  if (const auto values = numbers<double>(grid, "Origin", 3, true, faults))
    std::copy(values->begin(), values->end(), origin.begin());
  if (const auto values = numbers<double>(grid, "Direction", 9, false, faults))
    for (std::size_t i = 0; i < 9; ++i)
      geometry.direction[i / 3][i % 3] = (*values)[i];
  for (std::size_t row = 0; row < 3; ++row) {
    geometry.origin[row] = origin[row];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double half = has_cells && extent[axis][1] > extent[axis][0] ? 0.5 : 0;
      geometry.origin[row] += geometry.direction[row][axis] * geometry.spacing[axis] *
                              (static_cast<double>(extent[axis][0]) + half);
    }
  }
  return geometry;
}

void read_array(xml_node array, const std::string& name, const Extent& extent, bool has_cells,
                OpenImage& image, Faults& faults) {
  const auto type = vti_scalar_type(array.attribute("type").value());
  if (!type)
    faults.add(name + " type", "Int8 to Int64, UInt8 to UInt64, Float32 or Float64",
               in_quotes(array.attribute("type").value()));
  image.layout.type = type.value_or(ScalarType::uint8);
  image.layout.component_fastest = true;
  std::array<std::int64_t, 3> size{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t n_steps = extent[axis][1] - extent[axis][0];
    size[axis] = has_cells ? std::max(n_steps, std::int64_t{1}) : n_steps + 1;
  }
  const auto components = numbers<std::int64_t>(array, "NumberOfComponents", 1, false, faults);
  set_size(image.info, size, {"WholeExtent", "WholeExtent", "WholeExtent"},
           components ? components->front() : 1, "NumberOfComponents", faults);
  faults.throw_if_any();
}

} // namespace

OpenImage open_vti(const std::filesystem::path& file, std::int64_t largest_text, Faults& faults) {
  const auto vti = std::make_shared<VtiFile>();
  vti->file = file;
  read_text(file, largest_text, *vti, faults);
  parse_text(*vti, faults);
  const xml_node grid = read_encoding(*vti, {"ImageData"}, faults);
  const Extent extent = read_extent(grid, faults);
  const xml_node piece = only_piece(grid, faults);
  const xml_node array = values_of(piece, faults);
  const bool has_cells = std::string_view(array.parent().name()) == "CellData";
  OpenImage image;
  image.size_key = "WholeExtent";
  read_array(array, vti_array_name(array), extent, has_cells, image, faults);
  // Text is decoded into numbers of this machine.
  image.layout.swap_bytes = vti->swap_bytes && std::string_view(array.attribute("format").value()) != "ascii";
  FileGeometry geometry = read_geometry(grid, extent, has_cells, faults);
  geometry.units_per_metre = units_per_metre(vti, grid, faults);
  set_geometry(image.info, geometry, faults);
  check_vti_array(*vti, array, faults);
  faults.throw_if_any();
  const ScalarType type = image.layout.type;
  const std::int64_t bytes = image.info.n_voxels() * image.info.components * bytes_of(type);
  image.open_data = [vti, array, type, bytes, faults]() mutable {
    return open_vti_array(vti, array, type, bytes, faults);
  };
  return image;
}

} // namespace maille::image_formats

namespace maille {

std::vector<double> read_vtk_array(const std::filesystem::path& file, std::string_view name,
                                   std::int64_t tuples, std::int64_t components) {
  using namespace image_formats;
  constexpr std::int64_t largest_text = std::int64_t{16} << 20;
  Faults faults(file.string());
  const auto vti = std::make_shared<VtiFile>();
  vti->file = file;
  read_text(file, largest_text, *vti, faults);
  parse_text(*vti, faults);
  const xml_node grid = read_encoding(*vti, {"ImageData", "UnstructuredGrid"}, faults);
  const xml_node piece = grid.child("Piece"), points = piece.child("PointData");
  const auto of_name = [&](xml_node parent) {
    return parent.find_child_by_attribute("Name", std::string(name).c_str());
  };
  const xml_node array = tuples > 0 ? of_name(points) : of_name(grid.child("FieldData"));
  std::int64_t there = piece.attribute("NumberOfPoints").as_llong(-1);
  if (std::string_view(grid.name()) == "ImageData") {
    const Extent extent = read_extent(grid, faults);
    there = 1;
    for (const auto& [first, last] : extent)
      if (__builtin_mul_overflow(there, last - first + 1, &there))
        faults.fail("WholeExtent", "points that can be counted", "more");
  }
  if (tuples > 0 && there != tuples)
    faults.fail("", fmt::format("{} points, as the scene's body has", tuples), fmt::format("{}", there));
  if (!array || (tuples > 0 && array.attribute("NumberOfComponents").as_llong(1) != components))
    return {};
  const bool is_text = std::string_view(array.attribute("type").value()) == "String";
  const auto type = is_text ? ScalarType::int8 : vti_scalar_type(array.attribute("type").value());
  if (!type)
    faults.fail(vti_array_name(array) + " type", "a number or String",
                in_quotes(array.attribute("type").value()));
  const auto bytes = tuples > 0 ? std::optional(tuples * components * bytes_of(*type)) : std::nullopt;
  const ByteSourcePtr source = open_vti_array(vti, array, *type, bytes, faults);
  const auto decoded = [&]<class T>(T /*one*/) {
    const bool swap = vti->swap_bytes && std::string_view(array.attribute("format").value()) != "ascii";
    const std::int64_t wanted = std::max(tuples, std::int64_t{1}) * components;
    std::vector<double> values; // grows as the file fills it
    std::array<char, 1 << 16> part{};
    for (std::size_t got = part.size(); got == part.size() && std::ssize(values) < wanted;) {
      got = source->read(part);
      for (std::size_t at = 0; at + sizeof(T) <= got && std::ssize(values) < wanted; at += sizeof(T))
        values.push_back(static_cast<double>(number_at<T>(part.data() + at, swap)));
    }
    if (tuples > 0 && std::ssize(values) != wanted)
      faults.fail(vti_array_name(array), fmt::format("{} numbers", wanted), "the end of the data");
    return values;
  };
  switch (*type) {
  case ScalarType::int8:
    return decoded(std::int8_t{});
  case ScalarType::int32:
    return decoded(std::int32_t{});
  case ScalarType::float32:
    return decoded(float{});
  case ScalarType::float64:
    return decoded(double{});
  default:
    faults.fail(vti_array_name(array) + " type", "Int32, Float32 or Float64",
                in_quotes(array.attribute("type").value()));
  }
}

} // namespace maille
