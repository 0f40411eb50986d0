// NRRD: a text header, and data after it (.nrrd), or in a file that the header names; segmentations
// of 3D Slicer (.seg.nrrd) are such files with keys that name their labels.
//
// Source: "Definition of NRRD File Format" (Kindlmann, Teem), versions 1 to 5; for .seg.nrrd the
// documentation of 3D Slicer, "Segmentations: file format". Departures: data as text, hex and bzip2,
// several data files, skipped lines and bytes, and axes of time are refused with a specific message; an
// axis of components is the first or the last one.

#include "image_formats.hpp"
#include "maille/base/vectors.hpp"
#include "maille/images/image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille::image_formats {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t largest_header = 1 << 18; // keys of segmentations name every segment
constexpr std::size_t most_axes = 16;

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// `field: value` and `key:=value` lines, up to an empty one or the end of the file.
TextHeader read_text_header(const fs::path& file, Faults& faults) {
  TextHeader header;
  bool is_first = true;
  const auto take = [&](std::string_view line) {
    if (is_first && (!line.starts_with("NRRD000") || line.size() < 8 || line[7] < '1' || line[7] > '5'))
      faults.fail("", "a NRRD file: NRRD0001 to NRRD0005 in its first line", in_quotes(line.substr(0, 16)));
    if (std::exchange(is_first, false) || line.starts_with('#'))
      return true;
    if (without_blanks(line).empty())
      return false;
    const std::size_t colon = line.find(':');
    const bool is_key = colon != std::string_view::npos && line.substr(colon).starts_with(":=");
    if (colon == std::string_view::npos)
      faults.fail("", "a NRRD header: `field: value` and `key:=value` lines up to an empty one",
                  in_quotes(line));
    const std::string name(without_blanks(line.substr(0, colon)));
    set_field(is_key ? header.keys : header.fields, is_key ? name : lower(name),
              without_blanks(line.substr(colon + (is_key ? 2 : 1))), faults);
    return true;
  };
  if (read_header_lines(header, file, largest_header, faults, take))
    return header;
  if (is_first)
    take("");
  if (header.bytes == std::int64_t{largest_header})
    faults.fail("", fmt::format("an empty line within the first {} bytes", largest_header), "none");
  return header; // a detached header
}

std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  while (true) {
    const std::size_t start = text.find_first_not_of(" \t");
    if (start == std::string_view::npos)
      return words;
    text.remove_prefix(start);
    const std::size_t end = text.front() == '(' ? std::min(text.find(')'), text.size() - 1) + 1
                                                : std::min(text.find_first_of(" \t"), text.size());
    words.emplace_back(text.substr(0, end));
    text.remove_prefix(end);
  }
}

/// `(x,y,z)`
std::optional<std::vector<double>> parse_vector(std::string word, std::size_t n) {
  if (word.size() < 2 || word.front() != '(' || word.back() != ')')
    return std::nullopt;
  word = word.substr(1, word.size() - 2);
  std::ranges::replace(word, ',', ' ');
  return parse_numbers<double>(word, n);
}

/// World of a `space`: its axes, and whether x must be reversed to obtain a known one.
struct World {
  WorldAxes axes = WorldAxes::unknown;
  bool flips_x = false;
};
std::optional<World> world_named(const std::string& name) {
  if (name == "left-posterior-superior" || name == "lps")
    return World{WorldAxes::lps, false};
  if (name == "right-anterior-superior" || name == "ras")
    return World{WorldAxes::ras, false};
  if (name == "left-anterior-superior" || name == "las")
    return World{WorldAxes::ras, true};
  if (name == "scanner-xyz" || name == "3d-right-handed" || name == "3d-left-handed")
    return World{};
  return std::nullopt;
}

class Reading {
public:
  Reading(const fs::path& file, Faults& faults)
      : file_(file), faults_(faults), header_(read_text_header(file, faults)) {}

  OpenImage open() {
    OpenImage image;
    image.size_key = "sizes";
    read_axes();
    read_layout(image.layout);
    set_sizes(image.info);
    const FileGeometry geometry = read_geometry();
    set_geometry(image.info, geometry, faults_);
    read_vectors(image.info);
    faults_.throw_if_any();
    const std::int64_t bytes = image.info.n_voxels() * image.info.components * bytes_of(image.layout.type);
    set_data(image, bytes);
    return image;
  }
  const TextHeader& header() const { return header_; }
  /// The file that holds the data.
  fs::path data_file() {
    const std::string name = field("data file").value_or(field("datafile").value_or(""));
    if (name.empty())
      return file_;
    return data_beside(file_, "data file", name, "one file in the header's folder or below it", faults_);
  }

private:
  std::optional<std::string> field(const char* name) const { return header_.field(name); }
  std::string required(const char* name, const char* expected) {
    const auto value = field(name);
    if (!value)
      faults_.add(name, expected, "nothing");
    return value.value_or("");
  }

  /// Reads sizes, and finds the axis of components, if there is one.
  void read_axes() {
    const auto n = parse_numbers<std::int64_t>(required("dimension", "2, 3 or 4"), 1);
    const std::size_t most = 4;
    if (!n || n->front() < 2 || n->front() > static_cast<std::int64_t>(most))
      faults_.fail("dimension", "2 or 3 axes, and one of components",
                   in_quotes(field("dimension").value_or("")));
    n_axes_ = static_cast<std::size_t>(n->front());
    const std::string sizes = required("sizes", "a number an axis");
    const auto parsed = parse_numbers<std::int64_t>(sizes, n_axes_);
    if (!parsed)
      faults_.fail("sizes", fmt::format("{} whole numbers", n_axes_), in_quotes(sizes));
    sizes_ = *parsed;
    directions_ = words_of(field("space directions").value_or(""));
    kinds_ = words_of(lower(field("kinds").value_or("")));
    if (!directions_.empty() && directions_.size() != n_axes_)
      faults_.fail("space directions", fmt::format("{} vectors, or none", n_axes_),
                   in_quotes(*field("space directions")));
    if (!kinds_.empty() && kinds_.size() != n_axes_)
      faults_.fail("kinds", fmt::format("{} words", n_axes_), in_quotes(*field("kinds")));
    std::vector<std::size_t> others;
    for (std::size_t axis = 0; axis < n_axes_; ++axis) {
      const bool is_domain = kinds_.empty() || kinds_[axis] == "domain" || kinds_[axis] == "space" ||
                             kinds_[axis] == "???" || kinds_[axis] == "none";
      if (!is_domain || (!directions_.empty() && directions_[axis] == "none"))
        others.push_back(axis);
    }
    if (others.empty() && n_axes_ == 4) // unspecified: an axis before or after
      others.push_back(sizes_[0] <= 4 ? 0 : 3);
    if (others.size() > 1 || (others.size() == 1 && others[0] != 0 && others[0] + 1 != n_axes_) ||
        n_axes_ - others.size() > 3 || n_axes_ - others.size() < 2)
      faults_.fail("kinds", "two or three axes of space, and before or behind them one of components at most",
                   in_quotes(field("kinds").value_or("") + " / " + field("space directions").value_or("")));
    if (!others.empty())
      components_axis_ = others[0];
  }

  bool is_space(std::size_t axis) const { return axis != components_axis_; }

  void read_layout(ValueLayout& layout) {
    layout.component_fastest = components_axis_ == 0;
    const std::string name = lower(required("type", "a type such as short"));
    const auto type = scalar_type_named(name);
    if (!type && field("type"))
      faults_.add("type", "integers of 8 to 64 bits, float or double", in_quotes(name));
    layout.type = type.value_or(ScalarType::uint8);
    const std::string endian = lower(field("endian").value_or("little"));
    if (endian != "little" && endian != "big")
      faults_.add("endian", "little or big", in_quotes(endian));
    if (bytes_of(layout.type) > 1 && !field("endian"))
      faults_.add("endian", "little or big", "nothing");
    layout.swap_bytes = must_swap(endian == "big");
    const std::string encoding = lower(required("encoding", "raw or gzip"));
    is_gzipped_ = encoding == "gzip" || encoding == "gz";
    if (!is_gzipped_ && encoding != "raw" && field("encoding"))
      faults_.add("encoding", "raw or gzip", in_quotes(encoding));
    for (const char* skip : {"line skip", "lineskip", "byte skip", "byteskip"})
      if (const auto value = field(skip); value && *value != "0")
        faults_.add(skip, "0", in_quotes(*value));
  }

  void set_sizes(ImageInfo& info) {
    std::array<std::int64_t, 3> size{1, 1, 1};
    std::size_t next = 0;
    for (std::size_t axis = 0; axis < n_axes_; ++axis)
      if (is_space(axis))
        size[next++] = sizes_[axis];
    set_size(info, size, {"sizes", "sizes", "sizes"},
             components_axis_ < n_axes_ ? sizes_[components_axis_] : 1, "sizes", faults_);
  }

  FileGeometry read_geometry() {
    FileGeometry geometry;
    geometry.origin_key = "space origin";
    geometry.direction_key = "space directions";
    geometry.spacing_keys.fill(directions_.empty() ? "spacings" : "space directions");
    World world;
    if (const auto space = field("space")) {
      const auto known = world_named(lower(*space));
      if (!known)
        faults_.add(
            "space",
            "left-posterior-superior, right-anterior-superior, left-anterior-superior, or scanner-xyz",
            in_quotes(*space));
      world = known.value_or(World{});
    }
    geometry.world = world.axes;
    const std::size_t n_space = components_axis_ < n_axes_ ? n_axes_ - 1 : n_axes_;
    read_units(geometry);
    if (directions_.empty())
      read_spacings(geometry);
    else
      read_directions(geometry, n_space);
    // Two axes may be in a space of three.
    const std::size_t n_world = field("space") ? 3 : n_space;
    if (const auto origin = field("space origin")) {
      const auto values = parse_vector(std::string(without_blanks(*origin)), n_world);
      if (!values)
        faults_.add("space origin", fmt::format("({} numbers)", n_world), in_quotes(*origin));
      else
        std::ranges::copy(*values, geometry.origin.begin());
    } else if (!field("space") && field("axis mins"))
      read_axis_mins(geometry);
    if (world.flips_x) {
      geometry.origin[0] = -geometry.origin[0];
      for (double& component : geometry.direction[0])
        component = -component;
    }
    return geometry;
  }

  void read_units(FileGeometry& geometry) {
    const auto units = field("space units");
    if (!units)
      return;
    // One quoted unit per axis; all lengths must have the same unit here.
    std::vector<std::string> named;
    for (std::size_t at = units->find('"'); at != std::string::npos; at = units->find('"', at + 1)) {
      const std::size_t end = std::min(units->find('"', at + 1), units->size());
      named.push_back(units->substr(at + 1, end - at - 1));
      at = end;
    }
    const std::string first = named.empty() ? "" : named.front();
    static const std::map<std::string, double> per_metre{{"", 1e3},   {"mm", 1e3}, {"millimeter", 1e3},
                                                         {"cm", 1e2}, {"m", 1},    {"um", 1e6}};
    const auto found = per_metre.find(first);
    if (found == per_metre.end() ||
        std::ranges::any_of(named, [&](const std::string& unit) { return unit != first; }))
      faults_.add("space units", "\"mm\", \"cm\", \"m\" or \"um\", the same for every axis",
                  in_quotes(*units));
    else
      geometry.units_per_metre = found->second;
  }

  /// Numbers of a field with one per axis; returns those of spatial axes.
  std::vector<double> of_axes_of_space(const char* name) {
    const std::vector<std::string> words = words_of(*field(name));
    std::vector<double> numbers;
    for (std::size_t axis = 0; axis < std::min(n_axes_, words.size()); ++axis)
      if (const auto value = parse_numbers<double>(words[axis], 1); is_space(axis))
        numbers.push_back(value ? value->front() : std::nan(""));
    if (words.size() != n_axes_)
      faults_.add(name, fmt::format("{} numbers", n_axes_), in_quotes(*field(name)));
    return numbers;
  }

  bool is_node(std::size_t axis) {
    const auto centers = words_of(lower(field("centers").value_or(field("centerings").value_or(""))));
    return centers.size() == n_axes_ && centers[axis] == "node";
  }

  /// Origin in old files, read as in ITK: the edge of the first voxel, unless voxels are nodes.
  void read_axis_mins(FileGeometry& geometry) {
    std::size_t next = 0;
    for (const double edge : of_axes_of_space("axis mins")) {
      geometry.origin[next] = edge + (is_node(axis_of_space(next)) ? 0 : geometry.spacing[next] / 2);
      ++next;
    }
    geometry.origin_key = "axis mins";
  }

  /// Vectors and tensors are along the axes of `space`, or of the measurement frame in it.
  void read_vectors(ImageInfo& info) {
    const auto text = field("measurement frame");
    const bool is_vector =
        components_axis_ < kinds_.size() && kinds_[components_axis_].find("vector") != std::string::npos;
    if (!info.states_world || info.components == 1 || (!text && !is_vector))
      return;
    std::array<Vec3, 3> rows{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const auto columns = words_of(text.value_or(""));
    for (std::size_t c = 0; text && c < 3; ++c) {
      const auto column = columns.size() == 3 ? parse_vector(columns[c], 3) : std::nullopt;
      if (!column)
        return faults_.add("measurement frame", "three vectors of three numbers", in_quotes(*text));
      for (std::size_t row = 0; row < 3; ++row)
        rows[row][c] = (*column)[row];
    }
    if (world_named(lower(field("space").value_or(""))).value_or(World{}).flips_x)
      for (double& component : rows[0])
        component = -component;
    info.vectors_to_world = rows;
  }

  std::size_t axis_of_space(std::size_t number) const { return number + (components_axis_ == 0 ? 1 : 0); }

  /// Reads `spacings`, else derives them from both ends of every axis.
  void read_spacings(FileGeometry& geometry) {
    std::size_t next = 0;
    if (field("spacings"))
      for (const double spacing : of_axes_of_space("spacings"))
        geometry.spacing[next++] = spacing;
    else if (field("axis mins") && field("axis maxs")) {
      geometry.spacing_keys.fill("axis maxs");
      const std::vector<double> low = of_axes_of_space("axis mins"), high = of_axes_of_space("axis maxs");
      for (; next < std::min(low.size(), high.size()); ++next) {
        const std::size_t axis = axis_of_space(next);
        geometry.spacing[next] =
            (high[next] - low[next]) / static_cast<double>(sizes_[axis] - (is_node(axis) ? 1 : 0));
      }
    } else
      geometry.states_spacing = false;
  }

  void read_directions(FileGeometry& geometry, std::size_t n_space) {
    const std::size_t n_world = field("space") ? 3 : n_space;
    std::vector<Vec3> axes;
    for (std::size_t axis = 0; axis < n_axes_; ++axis) {
      if (!is_space(axis))
        continue;
      const auto vector = parse_vector(directions_[axis], n_world);
      if (!vector) {
        faults_.add("space directions", fmt::format("({} numbers) an axis", n_world),
                    in_quotes(directions_[axis]));
        return;
      }
      Vec3 v{};
      std::ranges::copy(*vector, v.begin());
      axes.push_back(v);
    }
    if (axes.size() == 2) { // across the slice
      const double size = std::sqrt(norm(axes[0]) * norm(axes[1]));
      const Vec3 c = cross(axes[0], axes[1]);
      axes.push_back({c[0] / size, c[1] / size, c[2] / size});
    }
    geometry.set_axes({axes[0], axes[1], axes[2]});
  }

  void set_data(OpenImage& image, std::int64_t bytes) {
    const fs::path data = data_file();
    faults_.throw_if_any();
    const bool is_local = data == file_;
    const std::int64_t from = is_local ? header_.bytes : 0;
    const std::int64_t found = size_of_file(data, faults_) - from;
    if (!is_gzipped_ && found < bytes)
      faults_.fail("sizes", fmt::format("{} bytes of data", bytes), fmt::format("{}", found));
    image.open_data =
        data_in(data, from, is_gzipped_ ? std::optional(Compression::gzip) : std::nullopt, faults_);
  }

  fs::path file_;
  Faults& faults_;
  TextHeader header_;
  std::size_t n_axes_ = 0, components_axis_ = most_axes;
  std::vector<std::int64_t> sizes_;
  std::vector<std::string> directions_, kinds_;
  bool is_gzipped_ = false;
};

} // namespace

OpenImage open_nrrd(const fs::path& file, Faults& faults) {
  return Reading(file, faults).open();
}

fs::path data_file_of_nrrd(const fs::path& file, Faults& faults) {
  fs::path data = Reading(file, faults).data_file();
  faults.throw_if_any();
  return data;
}

} // namespace maille::image_formats

namespace maille {

std::vector<NamedSegment> named_segments(const std::filesystem::path& file) {
  std::vector<NamedSegment> segments;
  if (!file.filename().string().ends_with(".nrrd"))
    return segments;
  image_formats::Faults faults(file.string());
  const auto keys = image_formats::read_text_header(file, faults).keys;
  const auto whole = [&](const std::string& key, int otherwise) {
    const auto found = keys.find(key);
    const auto number =
        image_formats::parse_numbers<std::int64_t>(found == keys.end() ? "" : found->second, 1);
    return number && std::abs(number->front()) <= std::numeric_limits<int>::max()
               ? static_cast<int>(number->front())
               : otherwise;
  };
  constexpr int most_segments = 10'000;
  for (int i = 0; i < most_segments; ++i) {
    const std::string stem = fmt::format("Segment{}_", i);
    const auto name = keys.find(stem + "Name");
    if (name == keys.end())
      break;
    segments.push_back({name->second, whole(stem + "LabelValue", 1), whole(stem + "Layer", 0)});
  }
  return segments;
}

} // namespace maille
