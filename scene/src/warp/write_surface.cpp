// Writes STL, PLY and VTK polygons.
//
// Source: StereoLithography Interface Specification (3D Systems, 1989); "The PLY Polygon File Format"
// (Turk, 1994); VTK File Formats (Kitware). `SPACE=LPS` in comments is what 3D Slicer writes and reads.

#include "maille/images/written_file.hpp"
#include "maille/scene/warp/warp.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace maille {

namespace {

using image_formats::WrittenFile;

/// Points for a file: float32 in its unit, LPS for a patient's world.
class FilePoints {
public:
  FilePoints(const std::vector<BodySurface>& surfaces, LengthUnit unit)
      : scale_(unit == LengthUnit::millimetre ? 1e3 : 1), unit_(unit == LengthUnit::millimetre ? "mm" : "m") {
    for (const BodySurface& surface : surfaces)
      has_world_ = has_world_ && surface.world != WorldAxes::unknown;
  }
  std::array<float, 3> of(const BodySurface& surface, std::int32_t point) const {
    const Vec3& x = surface.points[point];
    const double turned = has_world_ && surface.world == WorldAxes::ras ? -scale_ : scale_;
    return {static_cast<float>(turned * x[0]), static_cast<float>(turned * x[1]),
            static_cast<float>(scale_ * x[2])};
  }
  /// `maille; SPACE=LPS; UNIT=mm`
  std::string in_words() const {
    return fmt::format("maille;{} UNIT={}", has_world_ ? " SPACE=LPS;" : "", unit_);
  }
  const char* unit() const { return unit_; }
  bool has_world() const { return has_world_; }

private:
  double scale_;
  const char* unit_;
  bool has_world_ = true;
};

/// Splits a quad into two triangles along its shorter diagonal.
std::array<std::array<std::int32_t, 3>, 2> triangles_of(const BodySurface& surface,
                                                        const std::array<std::int32_t, 4>& q) {
  const auto distance = [&](std::int32_t a, std::int32_t b) {
    const Vec3 &x = surface.points[a], &y = surface.points[b];
    return std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]);
  };
  if (distance(q[0], q[2]) <= distance(q[1], q[3]))
    return {{{q[0], q[1], q[2]}, {q[0], q[2], q[3]}}};
  return {{{q[0], q[1], q[3]}, {q[1], q[2], q[3]}}};
}

template<class T>
void append(std::string& bytes, const T& value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string stl_of(const std::vector<BodySurface>& surfaces, const FilePoints& points) {
  std::string bytes = points.in_words();
  bytes.resize(80, ' ');
  std::uint32_t n = 0;
  for (const BodySurface& surface : surfaces)
    n += static_cast<std::uint32_t>(2 * surface.quads.size());
  append(bytes, n);
  for (const BodySurface& surface : surfaces)
    for (const auto& quad : surface.quads)
      for (const auto& triangle : triangles_of(surface, quad)) {
        std::array<std::array<float, 3>, 3> x{};
        for (std::size_t c = 0; c < 3; ++c)
          x[c] = points.of(surface, triangle[c]);
        std::array<float, 3> normal{};
        for (std::size_t a = 0; a < 3; ++a) {
          const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
          normal[a] = (x[1][b] - x[0][b]) * (x[2][c] - x[0][c]) - (x[1][c] - x[0][c]) * (x[2][b] - x[0][b]);
        }
        const float length = std::hypot(normal[0], normal[1], normal[2]);
        for (float& component : normal)
          component = length > 0 ? component / length : 0;
        append(bytes, normal);
        append(bytes, x);
        append(bytes, std::uint16_t{0});
      }
  return bytes;
}

struct Counts {
  std::size_t points = 0, triangles = 0;
  explicit Counts(const std::vector<BodySurface>& surfaces) {
    for (const BodySurface& surface : surfaces) {
      points += surface.points.size();
      triangles += 2 * surface.quads.size();
    }
  }
};

std::string ply_of(const std::vector<BodySurface>& surfaces, const FilePoints& points) {
  const Counts n(surfaces);
  std::string bytes = fmt::format("ply\nformat binary_little_endian 1.0\ncomment {}\n", points.in_words());
  for (const BodySurface& surface : surfaces)
    bytes += fmt::format("comment part {} {}\n", surface.part, surface.name);
  bytes +=
      fmt::format("element vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\n"
                  "property list uchar int vertex_indices\nproperty int part\nend_header\n",
                  n.points, n.triangles);
  for (const BodySurface& surface : surfaces)
    for (std::size_t i = 0; i < surface.points.size(); ++i)
      append(bytes, points.of(surface, static_cast<std::int32_t>(i)));
  std::int32_t first = 0;
  for (const BodySurface& surface : surfaces) {
    for (const auto& quad : surface.quads)
      for (const auto& triangle : triangles_of(surface, quad)) {
        append(bytes, std::uint8_t{3});
        for (const std::int32_t corner : triangle)
          append(bytes, first + corner);
        append(bytes, surface.part);
      }
    first += static_cast<std::int32_t>(surface.points.size());
  }
  return bytes;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  return out;
}

std::string vtp_of(const std::vector<BodySurface>& surfaces, const FilePoints& points) {
  const Counts n(surfaces);
  std::string data, arrays;
  const auto add = [&](const std::string& attributes, const std::string& bytes) {
    arrays += fmt::format("<DataArray {} format=\"appended\" offset=\"{}\"/>\n", attributes, data.size());
    append(data, static_cast<std::uint64_t>(bytes.size()));
    data += bytes;
  };
  std::string xyz, corners, ends, parts;
  std::int32_t first = 0, end = 0;
  for (const BodySurface& surface : surfaces) {
    for (std::size_t i = 0; i < surface.points.size(); ++i)
      append(xyz, points.of(surface, static_cast<std::int32_t>(i)));
    for (const auto& quad : surface.quads)
      for (const auto& triangle : triangles_of(surface, quad)) {
        for (const std::int32_t corner : triangle)
          append(corners, first + corner);
        append(ends, end += 3);
        append(parts, surface.part);
      }
    first += static_cast<std::int32_t>(surface.points.size());
  }
  std::string names;
  for (const BodySurface& surface : surfaces)
    names += (names.empty() ? "" : "; ") + surface.name;
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n";
  const auto word = [&](const char* name, const std::string& value) {
    std::string codes;
    for (const unsigned char c : value)
      codes += fmt::format("{} ", int{c});
    text +=
        fmt::format("<Array type=\"String\" Name=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">{}0</Array>\n",
                    name, codes);
  };
  word("Units", points.unit());
  word("Provenance", "maille");
  word("Name", escaped(names));
  if (points.has_world())
    word("SPACE", "LPS");
  text += fmt::format("</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfPolys=\"{}\">\n", n.points,
                      n.triangles);
  const auto section = [&](const char* name) {
    text += fmt::format("<{0}>\n{1}</{0}>\n", name, arrays);
    arrays.clear();
  };
  add("type=\"Float32\" NumberOfComponents=\"3\" Name=\"Points\"", xyz);
  section("Points");
  add("type=\"Int32\" Name=\"connectivity\"", corners);
  add("type=\"Int32\" Name=\"offsets\"", ends);
  section("Polys");
  add("type=\"Int32\" Name=\"Part\"", parts);
  section("CellData");
  return text + "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_" + data +
         "\n</AppendedData>\n</VTKFile>\n";
}

} // namespace

void write_surfaces(const std::vector<BodySurface>& surfaces, const std::filesystem::path& file,
                    LengthUnit unit) {
  const FilePoints points(surfaces, unit);
  const std::string ending = file.extension().string();
  const std::string bytes = ending == ".stl"   ? stl_of(surfaces, points)
                            : ending == ".ply" ? ply_of(surfaces, points)
                            : ending == ".vtp" ? vtp_of(surfaces, points)
                                               : std::string();
  if (bytes.empty())
    throw std::invalid_argument("expected a name that ends in .stl, .ply or .vtp, found " + file.string());
  WrittenFile output(file, WrittenFile::Packing::none);
  output.write(bytes.data(), bytes.size());
  output.close();
}

} // namespace maille
