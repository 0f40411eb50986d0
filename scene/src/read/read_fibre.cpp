#include "read/reader.hpp"

#include "maille/scene/fibre/fibre_field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <variant>

namespace maille::reader {

namespace {

/// `{ direction = [x, y, z] }`
bool read_direction(TableReader& table, FibreRequest& request) {
  const toml::node& node = *table.find("direction");
  const auto direction = direction_of(node, 3);
  if (!direction)
    table.fault("direction", "three numbers, not all 0");
  request.direction = direction.value_or(request.direction);
  return direction.has_value();
}

/// `bipennate = true`, or the position of the seam along the plane's second axis.
void read_bipennate(TableReader& table, std::size_t second, FibreRequest& request) {
  const toml::node* node = table.find("bipennate");
  if (!node)
    return;
  if (const auto* flag = node->as_boolean()) {
    if (flag->get())
      request.bipennate = Bipennate{second, std::nullopt};
  } else if (const auto middle = table.number("bipennate")) {
    request.bipennate = Bipennate{second, *middle};
  }
}

/// `{ angle = "20 deg", plane = "xz", bipennate }`: rotated from the first axis of the plane to the second.
bool read_angle(TableReader& table, FibreRequest& request) {
  table.require("angle");
  table.require("plane");
  const auto angle = table.number("angle");
  const auto plane = table.choice("plane");
  read_bipennate(table, plane ? static_cast<std::size_t>((*plane)[1] - 'x') : 0, request);
  if (!angle || !plane)
    return false;
  request.direction = {};
  request.direction[(*plane)[0] - 'x'] = std::cos(*angle);
  request.direction[(*plane)[1] - 'x'] = std::sin(*angle);
  return true;
}

/// Checks that a line has a direction everywhere.
bool turns_evenly(const std::vector<Vec3>& points, const toml::array& list, const std::string& path,
                  FaultList& faults) {
  const std::size_t before = faults.size();
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i] == points[i - 1])
      faults.add(line_of(*list.get(i)), path, "points that differ from the ones before them",
                 describe(*list.get(i)));
  if (faults.size() > before)
    return false;
  for (std::size_t i = 2; i < points.size(); ++i)
    if (FibreCurve::doubles_back(points[i - 2], points[i - 1], points[i]))
      faults.add(line_of(*list.get(i)), path, "a line that does not double back on itself",
                 describe(*list.get(i)));
  if (faults.size() == before && points.front() == points.back() &&
      FibreCurve::doubles_back(points[points.size() - 2], points[0], points[1]))
    faults.add(line_of(list), path, "a line that does not double back on itself", describe(list));
  return faults.size() == before;
}

/// `{ curve = [[x, y, z], ...] }`
bool read_curve(TableReader& table, FibreRequest& request) {
  const toml::node& node = *table.find("curve");
  const std::string path = table.path_of("curve");
  const auto* list = node.as_array();
  if (!list || list->size() < 2) {
    table.fault("curve", "at least two points, each with a length for each axis");
    return false;
  }
  for (const toml::node& entry : *list)
    if (const auto point = read_point(entry, path, 0, "the coordinates of a point: one length for each axis",
                                      table.faults()))
      request.curve.push_back(*point);
  return request.curve.size() == list->size() && turns_evenly(request.curve, *list, path, table.faults());
}

/// `{ tensor_image = FILE, smooth = "4 mm" }`
bool read_tensor_image(TableReader& table, FibreRequest& request) {
  request.tensor_image = table.text("tensor_image").value_or("");
  if (request.tensor_image.empty() && table.find("tensor_image")->is_string())
    table.fault("tensor_image", "the name of an image");
  table.read("smooth", request.smoothing_radius);
  return !request.tensor_image.empty();
}

} // namespace

std::optional<Vec3> unit_vector(Vec3 v) {
  double largest = 0;
  for (const double c : v) {
    if (!std::isfinite(c))
      return std::nullopt;
    largest = std::max(largest, std::abs(c));
  }
  if (largest == 0)
    return std::nullopt;
  for (double& c : v)
    c /= largest; // prevents overflow and underflow of squares
  const double length = std::hypot(v[0], v[1], v[2]);
  for (double& c : v)
    c /= length;
  return v;
}

std::optional<Vec3> direction_of(const toml::node& node, std::size_t n) {
  const auto* list = node.as_array();
  Vec3 v{};
  if (!list || (list->size() != n && list->size() != 3))
    return std::nullopt;
  for (std::size_t a = 0; a < list->size(); ++a) {
    const auto number = list->get(a)->value<double>();
    if (!number)
      return std::nullopt;
    v[a] = *number;
  }
  return unit_vector(v);
}

bool lacks_fibre(const toml::table& specimen) {
  const auto shape = specimen["shape"].value<std::string>().value_or("image");
  return !specimen.contains("fibre") && (shape == "image" || shape == "surface");
}

void add_lack_of_fibre(int line, const std::string& needed_by, FaultList& faults) {
  faults.add(line, "specimen.fibre",
             "how fibres run, for " + needed_by +
                 ": a direction along the grid such as [0, 0, 1], { angle, plane }, { curve } or { "
                 "tensor_image }",
             "no `fibre`");
}

std::optional<FibreRequest> read_fibre(TableReader& table) {
  constexpr const char* wanted =
      "three numbers, { direction }, { angle, plane }, { curve } or { tensor_image }";
  FibreRequest request;
  const toml::node* node = table.find("fibre");
  if (!node)
    return request;
  request.line = line_of(*node);
  request.path = table.path_of("fibre");
  if (node->is_array()) {
    if (const auto v = direction_of(*node, 3)) {
      request.direction = *v;
      return request;
    }
  } else if (const auto* values = node->as_table()) {
    constexpr std::array forms{"tensor_image", "curve", "direction", "angle", "plane"};
    if (std::ranges::none_of(forms, [&](const char* form) { return values->contains(form); })) {
      table.fault("fibre", wanted);
      return std::nullopt;
    }
    TableReader reader(*values, table.path_of("fibre"), table.faults(), "fibre");
    bool good = reader.has("tensor_image") ? read_tensor_image(reader, request)
                : reader.has("curve")      ? read_curve(reader, request)
                : reader.has("direction")  ? read_direction(reader, request)
                                           : read_angle(reader, request);
    if (request.tensor_image.empty()) {
      const auto frame = read_frame(reader, CoordinateFrame::grid);
      good = good && frame;
      request.frame = frame.value_or(CoordinateFrame::grid);
      if (request.bipennate && request.frame != CoordinateFrame::grid)
        reader.fault("frame", "\"grid\" with `bipennate`, whose halves lie along an axis of the grid",
                     describe(*reader.find("frame")));
    }
    reader.finish();
    return good ? std::optional(request) : std::nullopt;
  }
  table.fault("fibre", wanted);
  return std::nullopt;
}

bool place_fibres(FibreRequest request, Specimen& body, FaultList& faults) {
  if (request.frame != CoordinateFrame::grid) {
    const auto placement = placement_in(body, request.frame);
    const auto* fault = std::get_if<RegionFault>(&placement);
    if (fault || body.grid.dimension() < 3) {
      faults.add(request.line, request.path + ".frame",
                 fault ? fault->expected : "\"grid\", as the scene is not three-dimensional",
                 fault
                     ? fault->found
                     : "\"" + std::string(coordinate_frames[static_cast<std::size_t>(request.frame)]) + "\"");
      return false;
    }
    Placement turned = std::get<Placement>(placement);
    for (Vec3& point : request.curve)
      point = point_in_object(turned, point);
    turned.origin = {};
    request.direction = point_in_object(turned, request.direction);
  }
  body.fibre = request.direction;
  if (!request.bipennate && request.curve.empty())
    return true;
  const Grid& grid = body.grid;
  const std::optional<FibreCurve> curve =
      request.curve.empty() ? std::nullopt : std::optional<FibreCurve>(request.curve);
  Bipennate halves = request.bipennate.value_or(Bipennate{});
  const std::size_t n = grid.n_cells();
  const std::size_t across = halves.axis;
  const double length = grid.spacing()[across] * grid.cells()[across];
  const double meet = halves.at.value_or(body.origin[across] + length / 2);
  if (halves.at && !(meet > body.origin[across] && meet < body.origin[across] + length)) {
    faults.add(request.line, request.path + ".bipennate",
               fmt::format("a place within the body, {:.4g} to {:.4g} m along {}", body.origin[across],
                           body.origin[across] + length, "xyz"[across]),
               fmt::format("{:.4g} m", meet));
    return false;
  }
  body.fibres.assign(n, {0, 0, 0});
  for (std::size_t cell = 0; cell < n; ++cell) {
    if (!body.is_matter(static_cast<std::int64_t>(cell)))
      continue;
    Vec3 middle = body.position(grid.cell_at(static_cast<std::int64_t>(cell)));
    for (int a = 0; a < grid.dimension(); ++a)
      middle[a] += grid.spacing()[a] / 2;
    Vec3 direction = request.direction;
    if (curve)
      direction = curve->direction_at(middle);
    else if (std::abs(middle[across] - meet) <= 1e-9 * length) // on the seam: mean of both sides
      direction[across] = 0;
    else if (middle[across] < meet)
      direction[across] = -direction[across];
    for (std::size_t a = 0; a < 3; ++a)
      body.fibres[cell][a] = static_cast<float>(direction[a]);
  }
  body.fibre_report.source = curve ? "curve" : "bipennate";
  body.fibre_report.cells = body.n_matter_cells();
  return true;
}

} // namespace maille::reader
