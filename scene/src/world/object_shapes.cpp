

#include "world/object_shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::reader {

namespace {

using std::numbers::pi;

/// Cells whose centre is inside. @param is_inside function of x and y from the box's axis along z, and of z
/// from its floor [m]
template<class IsInside>
std::vector<std::uint8_t> cells_inside(const Grid& box, IsInside&& is_inside) {
  std::vector<std::uint8_t> cells(box.n_cells(), no_material);
  for (std::int64_t cell = 0; cell < box.n_cells(); ++cell) {
    const Index3 at = box.cell_at(cell);
    const Vec3& h = box.spacing();
    const double x = (at[0] + 0.5 - 0.5 * box.cells()[0]) * h[0],
                 y = (at[1] + 0.5 - 0.5 * box.cells()[1]) * h[1];
    if (is_inside(x, y, (at[2] + 0.5) * h[2]))
      cells[cell] = 0;
  }
  return cells;
}

/// Half of the distance between two opposite corners of the hexagon in the box.
double half_width(const Grid& box) {
  return 0.5 * std::min(box.cells()[0] * box.spacing()[0], box.cells()[1] * box.spacing()[1]);
}

/// A regular hexagon with two of its corners on the x axis.
bool is_in_hexagon(double x, double y, double corner) {
  const double side = std::sqrt(3.0) / 2 * corner;
  return std::abs(y) <= side && std::abs(std::sqrt(3.0) / 2 * x + y / 2) <= side &&
         std::abs(std::sqrt(3.0) / 2 * x - y / 2) <= side;
}

/// Phase of a point within one turn of the thread, 0 to 1: the ridges of the bolt are below one half.
double phase(double x, double y, double z, const Thread& thread) {
  const double turns = z / thread.pitch - std::atan2(y, x) / (2 * pi);
  return turns - std::floor(turns);
}

/// A reproducible pseudo-random number: the last step of MurmurHash3 (A. Appleby; public domain).
std::uint32_t scattered(std::uint32_t number) {
  number ^= number >> 16;
  number *= 0x85ebca6bu;
  number ^= number >> 13;
  number *= 0xc2b2ae35u;
  return number ^ (number >> 16);
}

/// Height of the bulge over the straight edge, relative to the edge length. @param along 0 to 1
double bulge(double along, std::uint32_t edge) {
  const std::uint32_t lot = scattered(edge);
  const double middle = 0.36 + 0.28 * ((lot >> 8) % 256) / 255.0, half = 0.24;
  const double off = (along - middle) / half;
  if (std::abs(off) >= 1)
    return 0;
  const double height = 0.18 + 0.08 * ((lot >> 16) % 256) / 255.0;
  return ((lot >> 24) % 2 == 0 ? 1 : -1) * height * std::pow(std::cos(0.5 * pi * off), 2);
}

/// The piece that contains the centre of a cell.
std::array<int, 2> piece_at(double x, double y, double width, double height,
                            const std::array<int, 2>& pieces) {
  const int column = std::clamp(static_cast<int>(x / width), 0, pieces[0] - 1);
  std::array<int, 2> piece{0, 0};
  const double unit = std::min(width, height);
  for (int k = 1; k < pieces[1]; ++k)
    piece[1] +=
        y > k * height + unit * bulge(x / width - column, static_cast<unsigned>(49 + 13 * k + 101 * column));
  for (int k = 1; k < pieces[0]; ++k)
    piece[0] +=
        x > k * width + (piece[1] == 0 ? unit * bulge(y / height, static_cast<unsigned>(56 + 53 * k)) : 0);
  return piece;
}

/// The same with a round tab on every edge, wider than its neck.
std::array<int, 2> undercut_piece_at(double x, double y, double width, double height,
                                     const std::array<int, 2>& pieces) {
  constexpr double radius = 0.16, off = 0.12; // of the tab; of its centre from the edge; in parts of a piece
  const double unit = std::min(width, height);
  const std::array<int, 2> piece{std::clamp(static_cast<int>(x / width), 0, pieces[0] - 1),
                                 std::clamp(static_cast<int>(y / height), 0, pieces[1] - 1)};
  const std::array<double, 2> at{x, y}, size{width, height};
  for (std::size_t a = 0; a < 2; ++a)
    for (int side = 0; side < 2; ++side) { // the piece's edges across axis a: before it, behind it
      const std::size_t b = 1 - a;
      const int edge = piece[a] + side;
      if (edge == 0 || edge == pieces[a])
        continue;
      const std::uint32_t lot =
          scattered(static_cast<std::uint32_t>(7 + 2 * (edge + 128 * piece[b])) + static_cast<unsigned>(a));
      const int owner = (lot >> 24) % 2 == 0 ? edge - 1 : edge; // piece that owns the tab
      const double outwards = owner == edge - 1 ? 1 : -1;
      const double along = (piece[b] + 0.45 + 0.1 * ((lot >> 8) % 256) / 255.0) * size[b];
      if (std::hypot(at[a] - edge * size[a] - outwards * off * unit, at[b] - along) <= radius * unit) {
        std::array<int, 2> of = piece;
        of[a] = owner;
        return of;
      }
    }
  return piece;
}

/// Rings about two points, in 16 shades.
std::uint8_t shade_at(double x, double y) {
  const double near = std::hypot(x - 0.3, y - 0.6), far = std::hypot(x - 0.8, y - 0.2);
  const double value = 0.5 + 0.25 * std::cos(16 * near) + 0.25 * std::cos(11 * far);
  return static_cast<std::uint8_t>(std::clamp(static_cast<int>(16 * value), 0, 15));
}

} // namespace

std::vector<std::uint8_t> bolt_cells(const Grid& box, const Thread& thread, double head) {
  const double corner = half_width(box);
  return cells_inside(box, [&](double x, double y, double z) {
    if (z < head)
      return is_in_hexagon(x, y, corner);
    const double r = std::hypot(x, y);
    return r <= thread.radius - thread.depth || (r <= thread.radius && phase(x, y, z, thread) < 0.5);
  });
}

std::vector<std::uint8_t> nut_cells(const Grid& box, const Thread& thread) {
  const double corner = half_width(box), play = thread.play / thread.pitch;
  return cells_inside(box, [&](double x, double y, double z) {
    const double r = std::hypot(x, y), turn = phase(x, y, z, thread);
    const bool is_ridge = turn >= 0.5 + play && turn < 1 - play;
    return is_in_hexagon(x, y, corner) && r > thread.radius + thread.play - (is_ridge ? thread.depth : 0);
  });
}

std::vector<std::uint8_t> washer_cells(const Grid& box, double hole_radius) {
  return cells_inside(box, [&](double x, double y, double) {
    const double r = std::hypot(x, y);
    return r <= half_width(box) && r > hole_radius;
  });
}

std::vector<std::uint8_t> drawn_cells(const std::vector<std::string>& lines) {
  std::vector<std::uint8_t> cells;
  for (auto line = lines.rbegin(); line != lines.rend(); ++line)
    for (const char c : *line)
      cells.push_back(c == ' ' || c == '.' ? no_material : std::uint8_t{0});
  return cells;
}

std::vector<std::uint8_t> puzzle_piece_cells(const Grid& picture, const PuzzleCut& cut) {
  std::vector<std::uint8_t> cells(picture.n_cells(), no_material);
  const Index3& n = picture.cells();
  const double width = static_cast<double>(n[0]) / cut.pieces[0],
               height = static_cast<double>(n[1]) / cut.pieces[1];
  for (std::int64_t cell = 0; cell < picture.n_cells(); ++cell) {
    const Index3 at = picture.cell_at(cell);
    const double x = at[0] + 0.5, y = at[1] + 0.5;
    if ((cut.is_undercut ? undercut_piece_at : piece_at)(x, y, width, height, cut.pieces) == cut.piece)
      cells[cell] = shade_at(x / n[0], y / n[0]);
  }
  return cells;
}

namespace {

using Cells = std::optional<std::vector<std::uint8_t>>;

/// `thread = { radius, depth, pitch, play }`
std::optional<Thread> read_thread(TableReader& table) {
  table.require("thread");
  auto reader = table.open("thread");
  if (!reader)
    return std::nullopt;
  Thread thread;
  reader->read("radius", thread.radius);
  reader->read("depth", thread.depth);
  reader->read("pitch", thread.pitch);
  reader->read("play", thread.play);
  reader->finish();
  if (!(thread.radius > 0) || !(thread.depth > 0) || !(thread.pitch > 0))
    return std::nullopt;
  if (thread.depth >= thread.radius)
    reader->fault("depth", "less than the radius");
  if (thread.play < 0 || thread.play >= thread.pitch / 4)
    reader->fault("play", "from 0 to a quarter of the pitch");
  return thread;
}

bool is_solid(TableReader& table, const Grid& grid) {
  if (grid.dimension() == 3)
    return true;
  table.fault("cells", "three numbers: the shape is a solid");
  return false;
}

Cells read_bolt(TableReader& table, const std::optional<Grid>& grid) {
  const auto thread = read_thread(table);
  const auto head = table.require("head") ? table.number("head") : std::nullopt;
  return thread && head && grid && is_solid(table, *grid) ? Cells(bolt_cells(*grid, *thread, *head))
                                                          : std::nullopt;
}

Cells read_nut(TableReader& table, const std::optional<Grid>& grid) {
  const auto thread = read_thread(table);
  return thread && grid && is_solid(table, *grid) ? Cells(nut_cells(*grid, *thread)) : std::nullopt;
}

Cells read_washer(TableReader& table, const std::optional<Grid>& grid) {
  const auto hole = table.require("hole") ? table.number("hole") : std::nullopt;
  return hole && grid && is_solid(table, *grid) ? Cells(washer_cells(*grid, *hole)) : std::nullopt;
}

/// Two whole numbers, each from `least` and below `below`.
std::optional<std::array<int, 2>> read_pair(TableReader& table, const char* key, int least,
                                            const std::array<int, 2>& below) {
  const std::string wanted =
      fmt::format("two whole numbers from {} to {} and {}", least, below[0] - 1, below[1] - 1);
  const toml::node* node = table.require(key, wanted);
  const std::vector<int> n = node ? whole_numbers(*node, least, std::ranges::max(below)) : std::vector<int>{};
  if (n.size() == 2 && n[0] < below[0] && n[1] < below[1])
    return std::array{n[0], n[1]};
  if (node)
    table.fault(key, wanted);
  return std::nullopt;
}

Cells read_puzzle_piece(TableReader& table, const std::optional<Grid>& grid) {
  const auto pieces = read_pair(table, "pieces", 1, {101, 101});
  const auto piece = read_pair(table, "piece", 0, pieces.value_or(std::array<int, 2>{101, 101}));
  const auto tabs = table.choice("tabs");
  if (!pieces || !piece || !grid)
    return std::nullopt;
  if (grid->dimension() == 1) {
    table.fault("cells", "two numbers, or three with the puzzle's thickness");
    return std::nullopt;
  }
  return puzzle_piece_cells(*grid, {*pieces, *piece, tabs == "undercut"});
}

/// `rows = ["##", "#."]`: the grid and its matter.
Cells read_rows(TableReader& table, const BodyDefaults& defaults, std::optional<Grid>& grid) {
  const toml::node* node = table.require("rows");
  const auto spacing = read_spacing(table, 2, defaults.spacing);
  const auto* list = node ? node->as_array() : nullptr;
  std::vector<std::string> lines;
  if (list)
    for (const toml::node& line : *list)
      lines.push_back(line.value_or(std::string()));
  const bool is_good =
      !lines.empty() && !lines[0].empty() && lines[0].size() <= 32767 && lines.size() <= 32767 &&
      std::ranges::all_of(lines, [&](const std::string& line) { return line.size() == lines[0].size(); });
  if (node && !is_good)
    table.fault("rows", table.missing("rows"));
  if (!is_good || !spacing)
    return std::nullopt;
  grid = Grid(2, {static_cast<int>(lines[0].size()), static_cast<int>(lines.size()), 1}, *spacing);
  return drawn_cells(lines);
}

/// Reads the shapes that only worlds have.
bool read_shape_of_worlds(TableReader& table, const std::string& shape, const BodyDefaults& defaults,
                          Scene& scene) {
  const std::size_t faults_before = table.faults().size();
  MaterialTable materials;
  read_material(table, defaults.has_material, materials);
  scene.materials = materials.take();
  const auto fibre = read_fibre(table);
  if (fibre && !fibre->tensor_image.empty())
    table.fault("fibre", "a direction: tensor images go with shape = \"image\"", "tensor_image");
  std::optional<Grid> grid;
  if (shape != "rows")
    grid = read_grid(table, defaults.spacing);
  const Cells cells = shape == "rows"     ? read_rows(table, defaults, grid)
                      : shape == "bolt"   ? read_bolt(table, grid)
                      : shape == "nut"    ? read_nut(table, grid)
                      : shape == "washer" ? read_washer(table, grid)
                                          : read_puzzle_piece(table, grid);
  if (!cells || !fibre || table.faults().size() > faults_before)
    return false;
  Specimen& body = scene.specimen;
  body.shape = shape;
  body.grid = *grid;
  body.material_id = *cells;
  if (!scene.materials.empty()) // shades are no material numbers
    std::ranges::replace_if(
        body.material_id, [](std::uint8_t id) { return id != no_material; }, std::uint8_t{0});
  if (body.n_matter_cells() == 0) {
    table.fault("shape", "a shape with at least one cell of matter", "none");
    return false;
  }
  crop_to_matter(body);
  return place_fibres(*fibre, body, table.faults());
}

} // namespace

bool read_object_body(TableReader& table, const BodyDefaults& defaults, Scene& scene) {
  const auto shape = table.choice("shape");
  if (!shape) {
    for (const char* key :
         {"cells", "spacing", "material", "fibre", "tendon", "plane", "image", "labels", "threshold",
          "coarsen", "thread", "head", "hole", "pieces", "piece", "tabs", "rows"})
      table.find(key); // accept every key of an unknown shape
    return false;
  }
  if (*shape == "box" || *shape == "ellipsoid" || *shape == "muscle" || *shape == "image")
    return read_body(table, *shape, defaults, scene, nullptr);
  return read_shape_of_worlds(table, *shape, defaults, scene);
}

} // namespace maille::reader
