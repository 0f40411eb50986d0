#include "conditions/places_in_files.hpp"
#include "maille/base/csv.hpp"
#include "maille/images/image.hpp"
#include "maille/materials/json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace maille::reader {

namespace {

using json = nlohmann::ordered_json;

constexpr double metres_per_millimetre = 1e-3;
constexpr double largest_coordinate = 1e9; ///< [mm]

[[noreturn]] void fail(const std::filesystem::path& file, int line, std::string key, std::string expected,
                       std::string found) {
  throw InputError({{file.string(), line, std::move(key), std::move(expected), std::move(found)}});
}

/// `LPS` and `RAS`, which files before 2019 wrote as 1 and 0.
std::optional<CoordinateFrame> frame_named(std::string_view name) {
  if (name == "LPS" || name == "1")
    return CoordinateFrame::lps;
  if (name == "RAS" || name == "0")
    return CoordinateFrame::ras;
  return std::nullopt;
}

constexpr std::string_view blanks = " \t\r"; // includes \r of other systems

/// Value after `# name = ` in a header line; empty without such a line.
std::string_view head_entry(std::string_view text, std::string_view name) {
  while (text.starts_with('#')) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(1, end - 1);
    const std::size_t equals = line.find('=');
    if (equals != std::string_view::npos && trimmed(line.substr(0, equals), blanks) == name)
      return trimmed(line.substr(equals + 1), blanks);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {};
}

void warn_not_placed(const std::filesystem::path& file, const std::string& name, const std::string& status) {
  warn_of_file(file, fmt::format("point \"{}\" is not placed ({}) and is left out", name, status));
}

Landmarks read_fcsv(const std::filesystem::path& file) {
  const std::string text = read_text_file(file, "landmarks, a .fcsv file");
  Landmarks landmarks;
  landmarks.frame = frame_named(head_entry(text, "CoordinateSystem"));
  std::string columns(head_entry(text, "columns"));
  if (columns.empty())
    columns = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label";
  CsvRecords head(columns);
  head.next();
  const std::vector<std::string> names = head.cells();
  const auto column = [&](std::string_view name) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  };
  const std::array<std::size_t, 3> of_axis{column("x"), column("y"), column("z")};
  CsvRecords records(text, CsvComments::lines);
  while (records.next()) {
    const auto& cells = records.cells();
    if (cells.size() == 1 && trimmed(cells[0], blanks).empty())
      continue;
    // 3D Slicer 5 writes a position's status after the named columns: 2 means placed.
    const std::size_t status = column("associatedNodeID") + 1, label = column("label");
    if (status < cells.size() && (cells[status] == "0" || cells[status] == "1" || cells[status] == "3")) {
      warn_not_placed(file, label < cells.size() ? cells[label] : "", "status " + cells[status]);
      continue;
    }
    Vec3 x{};
    for (std::size_t a = 0; a < 3; ++a) {
      std::string_view cell =
          of_axis[a] < cells.size() ? trimmed(cells[of_axis[a]], blanks) : std::string_view();
      cell.remove_prefix(cell.starts_with('+') ? 1 : 0);
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), x[a]);
      if (error != std::errc{} || end != cell.data() + cell.size() || !(std::abs(x[a]) <= largest_coordinate))
        fail(file, records.line(), std::string{"xyz"[a]}, "a number, in millimetres",
             "\"" + std::string(cell) + "\"");
      x[a] *= metres_per_millimetre;
    }
    landmarks.points.push_back(x);
    landmarks.names.push_back(label < cells.size() ? cells[label] : "");
  }
  return landmarks;
}

/// One of `markups`.
void add_markup(const std::filesystem::path& file, const json& markup, Landmarks& landmarks, bool& is_first) {
  const json& named = json_entry(markup, "coordinateSystem");
  const auto frame = named.is_string() ? frame_named(named.get_ref<const std::string&>()) : std::nullopt;
  if (is_first)
    landmarks.frame = frame;
  else if (landmarks.frame != frame)
    landmarks.frame.reset();
  is_first = false;
  const json& unit = json_entry(markup, "coordinateUnits");
  if (!unit.is_null() && unit != json("mm") && !(unit.is_array() && !unit.empty() && unit[0] == json("mm")))
    fail(file, 0, "coordinateUnits", "\"mm\"", unit.dump().substr(0, 60));
  for (const json& point : json_entry(markup, "controlPoints")) {
    const json& place = json_entry(point, "position");
    const json& state = json_entry(point, "positionStatus");
    const json& label = json_entry(point, "label");
    const std::string name = label.is_string() ? label.get<std::string>() : "";
    const std::string status = state.is_string() ? state.get<std::string>() : "defined";
    if (status != "defined" || place == json("")) {
      warn_not_placed(file, name, status == "defined" ? "no position" : status);
      continue;
    }
    if (!place.is_array() || place.size() != 3)
      fail(file, 0, "position", "[x, y, z] in millimetres", place.dump().substr(0, 60));
    Vec3 x{};
    for (std::size_t a = 0; a < 3; ++a) {
      if (!place[a].is_number() || !(std::abs(place[a].get<double>()) <= largest_coordinate))
        fail(file, 0, "position", "three finite numbers in millimetres", place.dump().substr(0, 60));
      x[a] = metres_per_millimetre * place[a].get<double>();
    }
    landmarks.points.push_back(x);
    landmarks.names.push_back(name);
  }
}

Landmarks read_markups(const std::filesystem::path& file) {
  constexpr const char* wanted = "{ \"markups\": [{ \"coordinateSystem\", \"controlPoints\": [{ \"label\", "
                                 "\"position\": [x, y, z] }] }] } "
                                 "in millimetres, as 3D Slicer writes it";
  Landmarks landmarks;
  const json document = parse_json(read_text_file(file, "landmarks, a .mrk.json file"), file);
  const json& markups = json_entry(document, "markups");
  if (!markups.is_array())
    fail(file, 0, "markups", wanted, markups.is_null() ? "none" : "another form");
  bool is_first = true;
  for (const json& markup : markups)
    add_markup(file, markup, landmarks, is_first);
  return landmarks;
}

} // namespace

Landmarks read_landmarks(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  Landmarks landmarks;
  if (name.ends_with(".fcsv"))
    landmarks = read_fcsv(file);
  else if (name.ends_with(".mrk.json"))
    landmarks = read_markups(file);
  else
    fail(file, 0, "", "landmarks of 3D Slicer: .fcsv or .mrk.json", "\"" + name + "\"");
  if (landmarks.points.empty())
    fail(file, 0, "", "at least one point", "none");
  return landmarks;
}

} // namespace maille::reader
