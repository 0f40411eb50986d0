#include "conditions/places_in_files.hpp"
#include "geometry/box_tree.hpp"
#include "maille/materials/text_file.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

namespace maille::reader {

namespace {

constexpr std::int64_t largest_stl_bytes = std::int64_t{1} << 31;
constexpr double largest_coordinate = 1e9; ///< larger than any body, in any unit

[[noreturn]] void fail(const std::filesystem::path& file, int line, std::string expected, std::string found) {
  throw InputError({{file.string(), line, "", std::move(expected), std::move(found)}});
}

std::optional<CoordinateFrame> stated_frame(std::string_view header) {
  if (header.find("SPACE=LPS") != std::string_view::npos)
    return CoordinateFrame::lps;
  if (header.find("SPACE=RAS") != std::string_view::npos)
    return CoordinateFrame::ras;
  return std::nullopt;
}

constexpr std::size_t header_bytes = 80, triangle_bytes = 50;

/// Number of triangles that the file states and contains; nothing if it is no binary STL.
std::optional<std::size_t> n_binary_triangles(std::string_view bytes) {
  if (bytes.size() < header_bytes + 4)
    return std::nullopt;
  std::uint32_t n = 0;
  std::memcpy(&n, bytes.data() + header_bytes, 4);
  return bytes.size() == header_bytes + 4 + triangle_bytes * std::size_t{n} ? std::optional<std::size_t>(n)
                                                                            : std::nullopt;
}

/// The size that the header of a truncated binary file implies.
std::string count_in_words(std::string_view bytes) {
  std::uint32_t n = 0;
  if (bytes.size() < header_bytes + 4)
    return "";
  std::memcpy(&n, bytes.data() + header_bytes, 4);
  return fmt::format(": {} triangles take {}", n, header_bytes + 4 + triangle_bytes * std::size_t{n});
}

void read_binary(std::string_view bytes, std::size_t n, SurfaceMesh& mesh) {
  mesh.triangles.resize(n);
  for (std::size_t t = 0; t < n; ++t) {
    std::array<float, 9> values{};
    std::memcpy(values.data(), bytes.data() + header_bytes + 4 + triangle_bytes * t + 12, sizeof values);
    for (std::size_t i = 0; i < 9; ++i)
      mesh.triangles[t][i / 3][i % 3] = double{values[i]};
  }
}

/// Reads `vertex x y z`, three per facet; ignores all other words.
void read_text(const std::filesystem::path& file, std::string_view text, SurfaceMesh& mesh) {
  std::vector<Vec3> vertices;
  int line = 0;
  bool is_closed = false;
  while (!text.empty()) {
    ++line;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view row = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto skip = [&] { row.remove_prefix(std::min(row.find_first_not_of(" \t\r"), row.size())); };
    skip();
    is_closed = is_closed || row.starts_with("endsolid");
    if (!row.starts_with("vertex"))
      continue;
    row.remove_prefix(6);
    Vec3 x{};
    for (double& component : x) {
      skip();
      row.remove_prefix(row.starts_with('+') ? 1 : 0);
      const auto [rest, error] = std::from_chars(row.data(), row.data() + row.size(), component);
      if (error != std::errc{})
        fail(file, line, "vertex and three numbers", "\"" + std::string(row.substr(0, 40)) + "\"");
      row.remove_prefix(static_cast<std::size_t>(rest - row.data()));
    }
    vertices.push_back(x);
  }
  if (!is_closed || vertices.size() % 3 != 0)
    fail(file, line, "facets of three vertices and, at the end, `endsolid`",
         is_closed ? fmt::format("{} vertices", vertices.size()) : "the end of the file");
  for (std::size_t i = 0; i < vertices.size(); i += 3)
    mesh.triangles.push_back({vertices[i], vertices[i + 1], vertices[i + 2]});
}

Eigen::Vector3d eigen(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

double distance_from_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double squared = (b - a).squaredNorm();
  const double s = squared > 0 ? std::clamp((p - a).dot(b - a) / squared, 0.0, 1.0) : 0;
  return (p - a - s * (b - a)).norm();
}

} // namespace

SurfaceMesh read_stl(const std::filesystem::path& file) {
  const std::string bytes = read_text_file(file, "a surface, an STL file", largest_stl_bytes);
  SurfaceMesh mesh;
  if (const auto n = n_binary_triangles(bytes)) {
    mesh.frame = stated_frame(std::string_view(bytes).substr(0, header_bytes));
    read_binary(bytes, *n, mesh);
  } else if (bytes.starts_with("solid") && bytes.find('\0') == std::string::npos) {
    mesh.frame = stated_frame(std::string_view(bytes).substr(0, bytes.find('\n')));
    read_text(file, bytes, mesh);
  } else {
    const bool is_ply = bytes.starts_with("ply"), is_vtk = bytes.starts_with("# vtk"),
               is_xml = bytes.starts_with("<");
    fail(file, 0, "a surface, STL or OBJ",
         is_ply   ? "a PLY file"
         : is_vtk ? "a VTK file (.vtk)"
         : is_xml
             ? "an XML file such as .vtp"
             : fmt::format("{} bytes that are neither text (`solid` ...) nor 80 bytes, a number of triangles "
                           "and 50 bytes of each{}",
                           bytes.size(), count_in_words(bytes)));
  }
  if (mesh.triangles.empty())
    fail(file, 0, "at least one triangle", "none");
  for (const Triangle& triangle : mesh.triangles)
    for (const Vec3& corner : triangle)
      if (!std::ranges::all_of(corner, [](double c) { return std::abs(c) <= largest_coordinate; }))
        fail(file, 0, fmt::format("coordinates of at most {:g} in size", largest_coordinate),
             "one that is larger, or none");
  return mesh;
}

double distance(const Vec3& point, const Triangle& triangle) {
  const Eigen::Vector3d p = eigen(point), a = eigen(triangle[0]), b = eigen(triangle[1]),
                        c = eigen(triangle[2]);
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  const bool is_above = normal.squaredNorm() > 0 && normal.dot((b - a).cross(p - a)) >= 0 &&
                        normal.dot((c - b).cross(p - b)) >= 0 && normal.dot((a - c).cross(p - c)) >= 0;
  if (is_above)
    return std::abs(normal.dot(p - a)) / normal.norm();
  return std::min(
      {distance_from_segment(p, a, b), distance_from_segment(p, b, c), distance_from_segment(p, c, a)});
}

std::vector<std::int64_t> nodes_near(const std::vector<Triangle>& triangles, double within,
                                     const Specimen& body) {
  const Grid& grid = body.grid;
  const BoxTree tree(triangles);
  const double reach = within + place_tolerance(body);
  std::vector<std::int64_t> nodes;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Vec3 at = body.position(grid.node_at(node));
    bool is_near = false;
    tree.near(at, reach * reach, [&](std::size_t triangle) {
      is_near = is_near || distance(at, triangles[triangle]) <= reach;
      return is_near ? -1 : reach * reach;
    });
    if (is_near)
      nodes.push_back(node);
  }
  return nodes;
}

} // namespace maille::reader
