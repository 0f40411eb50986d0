// MetaImage: a text header, and data after it (.mha) or in a file beside it (.mhd).
//
// Source: MetaIO documentation (ITK wiki) and, where it is silent, MetaIO's metaObject.cxx and metaImage.cxx
// and ITK's itkMetaImageIO.cxx. TransformMatrix is written axis by axis: its first NDims numbers are the
// direction of the image's x axis in the world, that is, the first *column* of ITK's direction matrix and of
// ours. Departures: text data (BinaryData = False), lists of slices, more than three axes, intensity
// functions other than the identity, and data files outside the header's folder are refused with a specific
// message. As in ITK, CenterOfRotation is ignored; AnatomicalOrientation, for any TransformMatrix, only
// states that the world is ITK's.

#include "image_formats.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace maille::image_formats {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t largest_header = 1 << 16;

/// Reads `Key = Value` lines; ElementDataFile is the last one, and the data may follow it directly.
TextHeader read_text_header(const fs::path& file, Faults& faults) {
  TextHeader header;
  const auto take = [&](std::string_view line) {
    if (without_blanks(line).empty())
      return true;
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos)
      faults.fail("", "a MetaImage header: `Key = Value` lines up to ElementDataFile", in_quotes(line));
    const std::string key(without_blanks(line.substr(0, equals)));
    set_field(header.fields, key, without_blanks(line.substr(equals + 1)), faults);
    return key != "ElementDataFile";
  };
  if (!read_header_lines(header, file, largest_header, faults, take))
    faults.fail("ElementDataFile", fmt::format("this field within the first {} bytes", largest_header),
                fmt::format("none in {} bytes", header.bytes));
  return header;
}

/// Typed access to the fields; an invalid field is a fault.
class Fields {
public:
  Fields(const TextHeader& header, Faults& faults) : header_(header), faults_(faults) {}

  /// The value of the first of several synonymous names.
  std::optional<std::string> text(std::initializer_list<const char*> names,
                                  std::string* name_found = nullptr) {
    std::optional<std::string> value;
    for (const char* name : names) {
      const auto field = header_.field(name);
      if (!field)
        continue;
      if (value && *value != *field)
        faults_.add(name, "the same as " + in_quotes(*value) + " under its other name", in_quotes(*field));
      if (!value && name_found != nullptr)
        *name_found = name;
      value = value.value_or(*field);
    }
    return value;
  }
  template<class T>
  std::optional<std::vector<T>> numbers(std::initializer_list<const char*> names, std::size_t count,
                                        std::string* name_found = nullptr) {
    std::string name = *names.begin();
    const std::optional<std::string> value = text(names, &name);
    if (name_found != nullptr)
      *name_found = name;
    if (!value)
      return std::nullopt;
    auto parsed = parse_numbers<T>(*value, count);
    if (!parsed)
      faults_.add(name, fmt::format("{} number{}", count, count == 1 ? "" : "s"), in_quotes(*value));
    return parsed;
  }
  std::int64_t integer(const char* name, std::int64_t otherwise) {
    const auto values = numbers<std::int64_t>({name}, 1);
    return values ? values->front() : otherwise;
  }
  bool truth(std::initializer_list<const char*> names, bool otherwise) {
    std::string name;
    const std::optional<std::string> value = text(names, &name);
    if (!value)
      return otherwise;
    if (*value == "True" || *value == "true" || *value == "T" || *value == "1")
      return true;
    if (!(*value == "False" || *value == "false" || *value == "F" || *value == "0"))
      faults_.add(name, "True or False", in_quotes(*value));
    return false;
  }
  void require(const char* name, const std::string& expected) {
    if (!header_.field(name))
      faults_.add(name, expected, "nothing");
  }

private:
  const TextHeader& header_;
  Faults& faults_;
};

ValueLayout read_layout(Fields& fields, Faults& faults) {
  ValueLayout layout;
  layout.component_fastest = true;
  layout.swap_bytes = must_swap(fields.truth({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"}, false));
  fields.require("ElementType", "a type such as MET_SHORT");
  if (const auto name = fields.text({"ElementType"})) {
    const auto type = scalar_type_named(*name);
    if (!type)
      faults.add("ElementType",
                 "MET_CHAR, _SHORT, _INT, _LONG, _LONG_LONG, one of these with U, MET_FLOAT or MET_DOUBLE",
                 in_quotes(*name));
    layout.type = type.value_or(ScalarType::uint8);
  }
  if (!fields.truth({"BinaryData"}, true))
    faults.add("BinaryData", "True", "False: numbers as text");
  for (const auto& [name, identity] : {std::pair{"ElementToIntensityFunctionSlope", 1.0},
                                       std::pair{"ElementToIntensityFunctionOffset", 0.0}}) {
    const auto value = fields.numbers<double>({name}, 1);
    if (value && value->front() != identity) // readers disagree on whether it is applied
      faults.add(name, fmt::format("{}: stored values that are the values", identity),
                 fmt::format("{}", value->front()));
  }
  return layout;
}

void read_size(Fields& fields, std::size_t n_axes, ImageInfo& info, Faults& faults) {
  fields.require("DimSize", fmt::format("{} numbers", n_axes));
  const auto size = fields.numbers<std::int64_t>({"DimSize"}, n_axes);
  if (!size)
    return;
  set_size(info, {(*size)[0], (*size)[1], n_axes == 3 ? (*size)[2] : 1}, {"DimSize", "DimSize", "DimSize"},
           fields.integer("ElementNumberOfChannels", 1), "ElementNumberOfChannels", faults);
}

FileGeometry read_geometry(Fields& fields, std::size_t n_axes, Faults& faults) {
  FileGeometry geometry;
  // ElementSize is the voxel's extent; MetaIO uses it without ElementSpacing.
  const bool has_spacing = fields.text({"ElementSpacing"}).has_value();
  const char* spacing_name = has_spacing ? "ElementSpacing" : "ElementSize";
  geometry.spacing_keys.fill(spacing_name);
  if (const auto spacing = fields.numbers<double>({spacing_name}, n_axes))
    std::copy(spacing->begin(), spacing->end(), geometry.spacing.begin());
  else
    geometry.states_spacing = fields.text({spacing_name}).has_value();
  const auto origin = fields.numbers<double>({"Offset", "Position", "Origin"}, n_axes, &geometry.origin_key);
  if (origin)
    std::copy(origin->begin(), origin->end(), geometry.origin.begin());
  const auto matrix = fields.numbers<double>({"TransformMatrix", "Rotation", "Orientation"}, n_axes * n_axes,
                                             &geometry.direction_key);
  if (matrix)
    for (std::size_t axis = 0; axis < n_axes; ++axis)
      for (std::size_t row = 0; row < n_axes; ++row)
        geometry.direction[row][axis] = (*matrix)[axis * n_axes + row];
  const std::string unit = fields.text({"DistanceUnits"}).value_or("?");
  if (unit == "um")
    geometry.units_per_metre = 1e6;
  else if (unit == "cm")
    geometry.units_per_metre = 1e2;
  else if (unit != "mm" && unit != "?")
    faults.add("DistanceUnits", "mm, cm or um", in_quotes(unit));
  return geometry;
}

/// AnatomicalOrientation repeats the matrix in letters: ITK writes the side that an axis comes from, others
/// the side that it points to. The matrix is used; letters that match neither are reported.
void warn_of_orientation(const std::string& letters, const FileGeometry& geometry, const fs::path& file) {
  std::string from, to;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::size_t main = 0;
    for (std::size_t row = 1; row < 3; ++row)
      if (std::abs(geometry.direction[row][axis]) > std::abs(geometry.direction[main][axis]))
        main = row;
    const bool is_up = geometry.direction[main][axis] > 0;
    from += (is_up ? "RAI" : "LPS")[main];
    to += (is_up ? "LPS" : "RAI")[main];
  }
  if (const auto has = [&](const std::string& all) { return all.starts_with(letters); };
      !letters.empty() && !has(from) && !has(to))
    warn_of_file(file, fmt::format("AnatomicalOrientation is {}, and the axes of its matrix come from {} and "
                                   "point to {}: the matrix counts, in LPS as ITK takes it",
                                   letters, from, to));
}

/// The file that holds the data: this one, or one in its folder or below.
fs::path data_file(Fields& fields, const fs::path& file, bool& is_local, Faults& faults) {
  const std::string name = fields.text({"ElementDataFile"}).value_or("");
  is_local = name == "LOCAL" || name == "Local" || name == "local";
  return is_local ? file
                  : data_beside(file, "ElementDataFile", name,
                                "LOCAL, or one file in the header's folder or below it", faults);
}

struct DataPlace {
  fs::path file;
  std::int64_t from = 0;
  bool is_compressed = false;
};

/// @param bytes size of the decoded data
DataPlace find_data(Fields& fields, const fs::path& file, std::int64_t header_bytes, std::int64_t bytes,
                    Faults& faults) {
  DataPlace data;
  bool is_local = false;
  data.file = data_file(fields, file, is_local, faults);
  data.is_compressed = fields.truth({"CompressedData"}, false);
  const std::int64_t skipped = fields.integer("HeaderSize", 0);
  const std::int64_t compressed_bytes = fields.integer("CompressedDataSize", 0);
  faults.throw_if_any();
  const std::int64_t file_bytes = size_of_file(data.file, faults);
  data.from = is_local && skipped == 0 ? header_bytes : skipped;
  if (skipped == -1 && !data.is_compressed) // the data are at the end of the file
    data.from = std::max(file_bytes - bytes, is_local ? header_bytes : 0);
  else if (data.from < (is_local ? header_bytes : 0) || data.from > file_bytes)
    faults.add(
        "HeaderSize",
        fmt::format("{} to {}, or -1 if the data is not compressed", is_local ? header_bytes : 0, file_bytes),
        fmt::format("{}", skipped));
  else if (data.is_compressed && compressed_bytes != 0 && compressed_bytes != file_bytes - data.from)
    faults.add("CompressedDataSize",
               fmt::format("{} bytes, which are left in the file", file_bytes - data.from),
               fmt::format("{}", compressed_bytes));
  faults.throw_if_any();
  return data;
}

} // namespace

fs::path data_file_of_meta_image(const fs::path& file, Faults& faults) {
  const TextHeader header = read_text_header(file, faults);
  Fields fields(header, faults);
  bool is_local = false;
  fs::path data = data_file(fields, file, is_local, faults);
  faults.throw_if_any();
  return data;
}

OpenImage open_meta_image(const fs::path& file, Faults& faults) {
  const TextHeader header = read_text_header(file, faults);
  Fields fields(header, faults);
  if (const auto type = fields.text({"ObjectType"}); type && *type != "Image")
    faults.add("ObjectType", "Image", in_quotes(*type));
  fields.require("NDims", "2 or 3");
  const std::int64_t n_axes = fields.integer("NDims", 3);
  if (n_axes != 2 && n_axes != 3)
    faults.fail("NDims", "2 or 3", fmt::format("{}", n_axes));
  OpenImage image;
  image.size_key = "DimSize";
  read_size(fields, static_cast<std::size_t>(n_axes), image.info, faults);
  image.layout = read_layout(fields, faults);
  FileGeometry geometry = read_geometry(fields, static_cast<std::size_t>(n_axes), faults);
  if (const auto orientation = fields.text({"AnatomicalOrientation"});
      orientation && orientation->find('?') == std::string::npos) {
    geometry.world = WorldAxes::lps;
    warn_of_orientation(*orientation, geometry, file);
  }
  set_geometry(image.info, geometry, faults);
  faults.throw_if_any();
  const std::int64_t bytes = image.info.n_voxels() * image.info.components * bytes_of(image.layout.type);
  const DataPlace data = find_data(fields, file, header.bytes, bytes, faults);
  image.open_data = data_in(data.file, data.from,
                            data.is_compressed ? std::optional(Compression::zlib) : std::nullopt, faults);
  return image;
}

} // namespace maille::image_formats
