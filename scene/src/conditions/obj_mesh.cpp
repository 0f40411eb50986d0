// Surfaces in Wavefront OBJ: reads `v x y z` and `f a b c ...`; everything else concerns rendering.

#include "conditions/places_in_files.hpp"
#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

constexpr std::int64_t largest_obj_bytes = std::int64_t{1} << 31;
constexpr double largest_coordinate = 1e9; ///< larger than any body, in any unit

class ObjReading {
public:
  explicit ObjReading(const std::filesystem::path& file) : file_(file) {}

  SurfaceMesh read() {
    std::string bytes = read_text_file(file_, "a surface, an OBJ file", largest_obj_bytes);
    // Joins continued lines; a form feed replaces each inner line end.
    for (std::size_t at = bytes.find('\\'); at != std::string::npos; at = bytes.find('\\', at + 1)) {
      const std::size_t end = at + (bytes.compare(at + 1, 1, "\r") == 0 ? 2 : 1);
      if (end >= bytes.size() || bytes[end] != '\n')
        continue;
      bytes.replace(at, end - at, end - at, ' ');
      bytes[end] = '\f';
    }
    std::string_view text = bytes;
    while (!text.empty()) {
      ++line_;
      const std::size_t end = std::min(text.find('\n'), text.size());
      row_ = text.substr(0, end);
      line_ += static_cast<int>(std::ranges::count(row_, '\f'));
      text.remove_prefix(std::min(end + 1, text.size()));
      take_row();
    }
    if (mesh_.triangles.empty())
      fail("at least one face", "none");
    return std::move(mesh_);
  }

private:
  [[noreturn]] void fail(std::string expected, std::string found) const {
    throw InputError({{file_.string(), line_, "", std::move(expected), std::move(found)}});
  }
  std::string_view next_word() {
    row_.remove_prefix(std::min(row_.find_first_not_of(" \t\r\f"), row_.size()));
    const std::string_view word = row_.substr(0, std::min(row_.find_first_of(" \t\r\f"), row_.size()));
    row_.remove_prefix(word.size());
    return word;
  }
  void take_row() {
    const std::string_view whole = row_, what = next_word();
    if (what.starts_with('#')) {
      if (whole.find("SPACE=LPS") != std::string_view::npos)
        mesh_.frame = CoordinateFrame::lps;
      else if (whole.find("SPACE=RAS") != std::string_view::npos)
        mesh_.frame = CoordinateFrame::ras;
    } else if (what == "v") {
      take_vertex();
    } else if (what == "f") {
      take_face();
    }
  }
  void take_vertex() {
    Vec3 x{};
    for (double& component : x) {
      const std::string_view word = next_word();
      const char* const from = word.data() + (word.starts_with('+') ? 1 : 0);
      const auto [end, error] = std::from_chars(from, word.data() + word.size(), component);
      if (error != std::errc{} || end != word.data() + word.size() ||
          !(std::abs(component) <= largest_coordinate))
        fail(fmt::format("v and three numbers of at most {:g} in size", largest_coordinate),
             "\"" + std::string(word.substr(0, 40)) + "\"");
    }
    vertices_.push_back(x);
  }
  /// A corner is a vertex number, from 1, or backwards from -1; text after a slash concerns rendering.
  void take_face() {
    std::vector<std::size_t> corners;
    for (std::string_view word = next_word(); !word.empty(); word = next_word()) {
      std::int64_t number = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
      const auto n = static_cast<std::int64_t>(vertices_.size());
      const bool is_whole = error == std::errc{} && (end == word.data() + word.size() || *end == '/');
      const std::int64_t at = number < 0 ? n + number : number - 1;
      if (!is_whole || at < 0 || at >= n)
        fail(fmt::format("numbers of vertices above, 1 to {}", n),
             "\"" + std::string(word.substr(0, 40)) + "\"");
      corners.push_back(static_cast<std::size_t>(at));
    }
    if (corners.size() < 3)
      fail("a face of three corners or more", fmt::format("{}", corners.size()));
    for (std::size_t i = 2; i < corners.size(); ++i)
      mesh_.triangles.push_back({vertices_[corners[0]], vertices_[corners[i - 1]], vertices_[corners[i]]});
  }

  std::filesystem::path file_;
  int line_ = 0;
  std::string_view row_;
  std::vector<Vec3> vertices_;
  SurfaceMesh mesh_;
};

} // namespace

SurfaceMesh read_obj(const std::filesystem::path& file) {
  return ObjReading(file).read();
}

SurfaceMesh read_surface_mesh(const std::filesystem::path& file, double metres) {
  SurfaceMesh mesh =
      file.extension() == ".obj" || file.extension() == ".OBJ" ? read_obj(file) : read_stl(file);
  for (Triangle& triangle : mesh.triangles)
    for (Vec3& corner : triangle)
      for (double& component : corner)
        component *= metres;
  return mesh;
}

} // namespace maille::reader
