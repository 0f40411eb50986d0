// VTK's XML image data (.vti): finds the geometry and the array of values. A shared object reads the data by
// VTK itself. Departures: one Piece only; header numbers that VTK would replace by defaults are refused.

#include "plugin_readers.hpp"

#include <pugixml.hpp>

#include <algorithm>
#include <cctype>
#include <map>
#include <utility>

namespace maille::image_formats {
namespace {

using pugi::xml_node;

constexpr std::size_t largest_header = std::size_t{1} << 24;
constexpr std::ptrdiff_t largest_markup = 200000; // characters < and quotes: bounds the parser's memory

const VtkReaders& vtk(Faults& faults) {
  return opened<VtkReaders>("maille-vtk-readers.so", "VTK image data (VTK)", "libvtk9-dev",
                            vtk_readers_layout, faults);
}

/// The element ImageData. @param text that the document points into
xml_node parse_header(std::string& text, pugi::xml_document& document, Faults& faults) {
  const std::ptrdiff_t markup =
      std::count_if(text.begin(), text.end(), [](char c) { return c == '<' || c == '"' || c == '\''; });
  if (text.size() > largest_header || markup > largest_markup)
    faults.fail(
        "", fmt::format("a header of at most {} bytes, {} tags and quotes", largest_header, largest_markup),
        fmt::format("{} and {}", text.size(), markup));
  document.load_buffer_inplace(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  return document.first_child();
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

/// First and last point index along each axis.
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

/// Arrays of voxels, without internal arrays of VTK.
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

/// The active scalars, else the only array; for several a fault that lists them.
xml_node values_of(xml_node piece, Faults& faults) {
  const std::vector<xml_node> all = arrays_in(piece, false), active = arrays_in(piece, true);
  std::vector<xml_node> found = active.empty() ? all : active;
  if (!active.empty()) { // cell data take precedence over point data
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

/// True if a text such as `m`, `length: m` or `lengths: m; Stress: Pa` sets lengths to metres.
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

/// World in files of Maille, stated after the units.
WorldAxes world_in(std::string_view units) {
  return units.ends_with("world: RAS")   ? WorldAxes::ras
         : units.ends_with("world: LPS") ? WorldAxes::lps
                                         : WorldAxes::unknown;
}

/// Voxel 0 is at the first point, or half a spacing further if voxels are cells.
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
  static const std::map<std::string_view, ScalarType> types = {
      {"Int8", ScalarType::int8},       {"UInt8", ScalarType::uint8},   {"Int16", ScalarType::int16},
      {"UInt16", ScalarType::uint16},   {"Int32", ScalarType::int32},   {"UInt32", ScalarType::uint32},
      {"Int64", ScalarType::int64},     {"UInt64", ScalarType::uint64}, {"Float32", ScalarType::float32},
      {"Float64", ScalarType::float64},
  };
  const auto type = types.find(array.attribute("type").value());
  if (type == types.end())
    faults.fail(name + " type", "Int8 to Int64, UInt8 to UInt64, Float32 or Float64",
                in_quotes(array.attribute("type").value()));
  image.layout.type = type->second;
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

/// Values of one array as bytes; adds faults of the file.
class ArraySource final : public ByteSource {
public:
  ArraySource(std::function<std::string(std::span<char>)> values, std::int64_t bytes, std::string key,
              Faults faults)
      : values_(std::move(values)), left_(bytes), key_(std::move(key)), faults_(std::move(faults)) {}
  std::size_t read(std::span<char> to) override {
    const std::int64_t count = std::min(std::ssize(to), left_);
    if (const std::string fault = values_(to.first(count)); !fault.empty())
      faults_.fail(key_, "an array that VTK reads", fault);
    left_ -= count;
    return count;
  }

private:
  std::function<std::string(std::span<char>)> values_;
  std::int64_t left_;
  std::string key_;
  Faults faults_;
};

} // namespace

OpenImage open_vti(const std::filesystem::path& file, Faults& faults) {
  size_of_file(file, faults);
  const VtkReaders& readers = vtk(faults);
  std::string xml, units;
  const std::string fault = readers.header(file.string(), xml, units);
  pugi::xml_document document;
  const xml_node grid = parse_header(xml, document, faults);
  if (!grid)
    faults.fail("", "VTK image data", fault.empty() ? "none" : fault);
  const Extent extent = read_extent(grid, faults);
  const xml_node array = values_of(only_piece(grid, faults), faults);
  const std::string name = array.attribute("Name").value(),
                    key = fmt::format("{} {}", array.name(), in_quotes(name));
  const bool has_cells = std::string_view(array.parent().name()) == "CellData";
  OpenImage image;
  image.size_key = "WholeExtent";
  read_array(array, key, extent, has_cells, image, faults);
  FileGeometry geometry = read_geometry(grid, extent, has_cells, faults);
  geometry.units_per_metre = says_metres(units) ? 1 : 1000;
  geometry.world = world_in(units);
  set_geometry(image.info, geometry, faults);
  faults.throw_if_any();
  if (!fault.empty())
    faults.fail("", "VTK image data", fault);
  const std::int64_t n = image.info.n_voxels() * image.info.components;
  image.open_data = [&readers, file = file.string(), has_cells, name, n, type = image.layout.type, key,
                     faults] {
    return std::make_shared<ArraySource>(readers.values(file, has_cells, name, n), n * bytes_of(type), key,
                                         faults);
  };
  return image;
}

} // namespace maille::image_formats

namespace maille {

VtkArrays read_vtk_arrays(const std::filesystem::path& file, const std::vector<std::string>& names,
                          std::int64_t nodes) {
  image_formats::Faults faults(file.string());
  image_formats::size_of_file(file, faults);
  VtkArrays arrays;
  if (const std::string fault = image_formats::vtk(faults).arrays(file.string(), names, nodes, arrays);
      !fault.empty())
    faults.fail("", "a file of VTK", fault);
  return arrays;
}

} // namespace maille
