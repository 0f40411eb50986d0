#include "world/read_object_body.hpp"

#include "world/object_shapes.hpp"

#include <fmt/format.h>

namespace maille::reader {

namespace {

using Cells = std::optional<std::vector<std::uint8_t>>;

/// A length > 0; a fault where it is absent.
std::optional<double> read_positive(TableReader& table, const char* key, const char* what) {
  table.require(key, fmt::format("{}: a length > 0", what));
  const auto length = table.quantity(key, Dimension::length);
  if (!length || *length > 0)
    return length;
  table.fault(key, fmt::format("{}: a length > 0", what), describe(*table.find(key)));
  return std::nullopt;
}

/// `thread = { radius, depth, pitch, play }`
std::optional<Thread> read_thread(TableReader& table) {
  table.require("thread", "a table { radius, depth, pitch }");
  const toml::table* section = table.subtable("thread");
  if (!section)
    return std::nullopt;
  TableReader reader(*section, table.path_of("thread"), table.faults());
  const auto radius = read_positive(reader, "radius", "of the bolt with its thread");
  const auto depth = read_positive(reader, "depth", "of the thread");
  const auto pitch = read_positive(reader, "pitch", "the height of one turn");
  const auto play = reader.quantity("play", Dimension::length);
  reader.finish();
  if (!radius || !depth || !pitch)
    return std::nullopt;
  if (*depth >= *radius)
    reader.fault("depth", "less than the radius", describe(*reader.find("depth")));
  if (play && (*play < 0 || *play >= *pitch / 4))
    reader.fault("play", "from 0 to a quarter of the pitch", describe(*reader.find("play")));
  return Thread{*radius, *depth, *pitch, play.value_or(0)};
}

bool is_solid(TableReader& table, const Grid& grid) {
  if (grid.dimension() == 3)
    return true;
  table.fault("cells", "three numbers: the shape is a solid", describe(*table.find("cells")));
  return false;
}

Cells read_bolt(TableReader& table, const std::optional<Grid>& grid) {
  const auto thread = read_thread(table);
  const auto head = read_positive(table, "head", "the height of the head");
  return thread && head && grid && is_solid(table, *grid) ? Cells(bolt_cells(*grid, *thread, *head))
                                                          : std::nullopt;
}

Cells read_nut(TableReader& table, const std::optional<Grid>& grid) {
  const auto thread = read_thread(table);
  return thread && grid && is_solid(table, *grid) ? Cells(nut_cells(*grid, *thread)) : std::nullopt;
}

Cells read_washer(TableReader& table, const std::optional<Grid>& grid) {
  const auto hole = read_positive(table, "hole", "the radius of the hole");
  return hole && grid && is_solid(table, *grid) ? Cells(washer_cells(*grid, *hole)) : std::nullopt;
}

/// Two whole numbers, each from `least` and below `below`.
std::optional<std::array<int, 2>> read_pair(TableReader& table, const char* key, int least,
                                            const std::array<int, 2>& below) {
  const std::string wanted =
      fmt::format("two whole numbers from {} to {} and {}", least, below[0] - 1, below[1] - 1);
  const toml::node* node = table.require(key, wanted);
  const auto* list = node ? node->as_array() : nullptr;
  std::array<int, 2> pair{};
  bool is_good = list && list->size() == 2;
  for (std::size_t a = 0; is_good && a < 2; ++a) {
    const auto* number = list->get(a)->as_integer();
    is_good = number && number->get() >= least && number->get() < below[a];
    pair[a] = is_good ? static_cast<int>(number->get()) : 0;
  }
  if (is_good)
    return pair;
  if (node)
    table.fault(key, wanted, describe(*node));
  return std::nullopt;
}

Cells read_puzzle_piece(TableReader& table, const std::optional<Grid>& grid) {
  const auto pieces = read_pair(table, "pieces", 1, {101, 101});
  const auto piece = read_pair(table, "piece", 0, pieces.value_or(std::array<int, 2>{101, 101}));
  if (!pieces || !piece || !grid)
    return std::nullopt;
  if (grid->dimension() != 2) {
    table.fault("cells", "two numbers: a puzzle is flat", describe(*table.find("cells")));
    return std::nullopt;
  }
  return puzzle_piece_cells(*grid, {*pieces, *piece});
}

/// `rows = ["##", "#."]`: the grid and its matter.
Cells read_rows(TableReader& table, const BodyDefaults& defaults, std::optional<Grid>& grid) {
  constexpr const char* wanted = "lines of text of one length, the first on top; blanks and dots are empty";
  const toml::node* node = table.require("rows", wanted);
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
    table.fault("rows", wanted, describe(*node));
  if (!is_good || !spacing)
    return std::nullopt;
  grid = Grid(2, {static_cast<int>(lines[0].size()), static_cast<int>(lines.size()), 1}, *spacing);
  return drawn_cells(lines);
}

/// Shapes that a specimen cannot have.
bool read_shape_of_worlds(TableReader& table, const std::string& shape, const BodyDefaults& defaults,
                          const std::filesystem::path& folder, Scene& scene) {
  const std::size_t faults_before = table.faults().size();
  MaterialTable materials(folder);
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
  if (!scene.materials.empty()) // a picture's shades are numbers of no material
    std::ranges::replace_if(
        body.material_id, [](std::uint8_t id) { return id != no_material; }, std::uint8_t{0});
  if (body.n_matter_cells() == 0) {
    table.fault("shape", "a shape with at least one cell of matter", "none");
    return false;
  }
  crop_to_matter(body);
  place_fibres(*fibre, body);
  return true;
}

} // namespace

bool read_object_body(TableReader& table, const BodyDefaults& defaults, const std::filesystem::path& folder,
                      Scene& scene) {
  const std::vector<std::string_view> shapes{"box",  "ellipsoid", "muscle", "image",       "rows",
                                             "bolt", "nut",       "washer", "puzzle_piece"};
  table.require("shape", fmt::format("one of: {}", fmt::join(shapes, ", ")));
  const auto shape = table.choice("shape", shapes);
  if (!shape) {
    for (const char* key : {"cells", "spacing", "material", "fibre", "tendon", "plane", "image", "labels",
                            "threshold", "coarsen", "thread", "head", "hole", "pieces", "piece", "rows"})
      table.find(key); // of a shape that nobody knows, no key is wrong
    return false;
  }
  if (*shape == "box" || *shape == "ellipsoid" || *shape == "muscle" || *shape == "image")
    return read_body(table, *shape, defaults, folder, scene, nullptr);
  return read_shape_of_worlds(table, *shape, defaults, folder, scene);
}

} // namespace maille::reader
