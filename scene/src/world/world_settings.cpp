#include "world/trajectory_rows.hpp"

#include "maille/base/csv.hpp"
#include "maille/materials/quantity.hpp"
#include "maille/materials/toml_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace maille {

namespace reader {

namespace {

/// Numbers separated by blanks; empty for other text.
std::vector<double> numbers_of(std::string_view text) {
  std::vector<double> numbers;
  for (const char *at = text.data(), *const end = at + text.size(); at != end;) {
    if (*at == ' ') {
      ++at;
      continue;
    }
    double number = 0;
    const auto [rest, error] = std::from_chars(at, end, number);
    if (error != std::errc() || (rest != end && *rest != ' ') || !std::isfinite(number))
      return {};
    numbers.push_back(number);
    at = rest;
  }
  return numbers;
}

std::optional<NeighbourLimits> limits_of(std::string_view text) {
  const std::vector<double> ratios = numbers_of(text);
  if (ratios.size() != 3)
    return std::nullopt;
  NeighbourLimits limits;
  limits.stretch.fill(ratios[0]);
  limits.compress.fill(ratios[1]);
  for (auto& row : limits.shear)
    row.fill(ratios[2]);
  return broken_rules(limits).empty() ? std::optional(limits) : std::nullopt;
}

/// Gives an open world cells and a border: half the body's size of space on every side, nodes at cell
/// centres. @return shift of all positions [m]
Vec3 close(WorldScene& world) {
  WorldObject& object = world.objects.front();
  const Specimen& body = object.scene.specimen;
  Vec3 shift{};
  world.is_open = false;
  world.spacing = body.grid.spacing();
  for (std::size_t a = 0; a < static_cast<std::size_t>(world.dimension); ++a) {
    const int margin = std::max(8, body.grid.nodes()[a] / 2);
    world.cells[a] = body.grid.nodes()[a] + 2 * margin;
    shift[a] = (margin + 0.5) * world.spacing[a] - body.origin[a];
    object.position[a] += shift[a];
  }
  return shift;
}

void add_tool(const std::vector<double>& numbers, WorldScene& world) {
  const Vec3 shift = world.is_open ? close(world) : Vec3{};
  WorldObject tool;
  tool.name = tool_name;
  tool.kind = ObjectKind::rigid;
  Index3 cells{1, 1, 1};
  Vec3 spacing{1, 1, 1};
  for (std::size_t a = 0; a < static_cast<std::size_t>(world.dimension); ++a) {
    spacing[a] = world.spacing[a];
    cells[a] = std::max(1, static_cast<int>(std::lround(2 * numbers[0] / spacing[a])));
    tool.position[a] = numbers[a + 1] + shift[a] - 0.5 * cells[a] * spacing[a];
  }
  Specimen& body = tool.scene.specimen;
  body.shape = "ellipsoid";
  body.grid = Grid(world.dimension, cells, spacing);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    const Index3 at = body.grid.cell_at(cell);
    double squared = 0;
    for (std::size_t a = 0; a < static_cast<std::size_t>(world.dimension); ++a)
      squared += std::pow((at[a] + 0.5 - 0.5 * cells[a]) / (0.5 * cells[a]), 2);
    body.material_id.push_back(squared <= 1 ? std::uint8_t{0} : no_material);
  }
  tool.scene.materials.emplace_back().name = "tool";
  tool.scene.materials.back().elasticity = ElasticConstants::isotropic(1e9, 0.3);
  world.objects.push_back(std::move(tool));
}

} // namespace

std::optional<std::string> expected_of(const WorldSetting& setting, const WorldScene& world) {
  const bool is_soft = setting.object && world.objects[*setting.object].kind == ObjectKind::deformable;
  const std::vector<double> numbers = numbers_of(setting.value);
  if (setting.name == "method")
    return !setting.object &&
                   (setting.value == "limits" || setting.value == "relaxed" || setting.value == "coupled")
               ? std::nullopt
               : std::optional<std::string>("limits, relaxed or coupled, of no object");
  if (setting.name == "tool") {
    const bool is_there =
        std::ranges::any_of(world.objects, [](const WorldObject& o) { return o.name == tool_name; });
    return !setting.object && numbers.size() == 4 && numbers[0] >= 0 && !is_there
               ? std::nullopt
               : std::optional<std::string>(
                     "a radius >= 0 and a place, four lengths, of a world without one");
  }
  if (setting.name == "stiffness")
    return is_soft && numbers.size() == 1 && numbers[0] > 0
               ? std::nullopt
               : std::optional<std::string>("a factor > 0, of a deformable object");
  if (setting.name == "limits")
    return is_soft && (setting.value == "material" || setting.value == "none" || limits_of(setting.value))
               ? std::nullopt
               : std::optional<std::string>("material, none, or stretch >= 1, compress from 0 to 1 and "
                                            "shear >= 0, of a deformable object");
  return "method, stiffness, limits or tool";
}

void apply(const WorldSetting& setting, WorldScene& world) {
  if (setting.name == "method") {
    world.method = setting.value;
    return;
  }
  if (setting.name == "tool") {
    add_tool(numbers_of(setting.value), world);
    return;
  }
  Scene& scene = world.objects[*setting.object].scene;
  if (setting.name == "limits") {
    scene.limits.from = setting.value == "material" ? LimitSource::material
                        : setting.value == "none"   ? LimitSource::none
                                                    : LimitSource::given;
    if (scene.limits.from == LimitSource::given)
      scene.limits.given = *limits_of(setting.value);
    return;
  }
  const double factor = numbers_of(setting.value).front();
  for (Material& material : scene.materials) {
    ElasticConstants& constants = material.elasticity;
    for (double& modulus : constants.youngs_modulus)
      modulus *= factor;
    for (double* modulus : {&constants.G12, &constants.G13, &constants.G23})
      *modulus *= factor;
  }
}

} // namespace reader

void apply_settings(const std::vector<WorldSetting>& settings, WorldScene& world) {
  FaultList faults("");
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const WorldSetting& setting = settings[i];
    const bool is_last = std::none_of(settings.begin() + static_cast<std::ptrdiff_t>(i) + 1, settings.end(),
                                      [&](const WorldSetting& other) {
                                        return other.name == setting.name && other.object == setting.object;
                                      });
    if (!is_last)
      continue;
    if (const auto expected = reader::expected_of(setting, world))
      faults.add(0, setting.name, *expected, "\"" + setting.value + "\"");
    else
      reader::apply(setting, world);
  }
  faults.throw_if_any();
}

std::string trajectory_header() {
  return "frame,object,nodes,dx [m],dy [m],dz [m],x [m],y [m],z [m],angle [rad],axis_x,axis_y,axis_z,slide,"
         "release,set,value\n";
}

namespace {

std::string list_of(const std::vector<std::int64_t>& nodes) {
  std::string text;
  for (std::size_t i = 0; i < nodes.size();) {
    std::size_t end = i + 1;
    while (end < nodes.size() && nodes[end] == nodes[end - 1] + 1)
      ++end;
    text += fmt::format("{}{}", text.empty() ? "" : " ", nodes[i]);
    if (end - i > 1)
      text += fmt::format("-{}", nodes[end - 1]);
    i = end;
  }
  return text;
}

/// Three table cells for a vector, or empty ones.
std::string three(const std::optional<Vec3>& v) {
  return v ? fmt::format("{},{},{}", (*v)[0], (*v)[1], (*v)[2]) : ",,";
}

} // namespace

std::string trajectory_row(const DriveSpan& span, const WorldScene& world) {
  const WorldObject& object = world.objects[span.object];
  const std::string begin = fmt::format("{},{},", span.first_frame, csv_text(object.name));
  if (span.release)
    return begin + ",,,,,,,,,,,,true,,\n";
  const bool is_turned = span.angle != 0;
  return begin + list_of(span.nodes) + "," + three(span.to ? std::nullopt : std::optional(span.by)) + "," +
         three(span.to) + "," + (is_turned ? fmt::format("{},", span.angle) : std::string(",")) +
         three(is_turned ? std::optional(span.axis) : std::nullopt) +
         (object.kind == ObjectKind::rigid && span.slide ? ",true" : ",") + ",,,\n";
}

std::string trajectory_row(std::int64_t frame) {
  return fmt::format("{},,,,,,,,,,,,,,,,\n", frame);
}

std::string trajectory_row(const WorldSetting& setting, const WorldScene& world) {
  return fmt::format("0,{},,,,,,,,,,,,,,{},{}\n",
                     setting.object ? csv_text(world.objects[*setting.object].name) : std::string(),
                     setting.name, csv_text(setting.value));
}

WorldScene world_of_body(const Scene& scene, std::string method, std::vector<std::string>& left_out) {
  WorldScene world;
  world.name = scene.name;
  world.title = scene.title;
  world.dimension = scene.dimension();
  world.spacing = scene.specimen.grid.spacing();
  world.method = std::move(method);
  world.is_open = true;
  WorldObject object;
  object.name = "body";
  object.kind = ObjectKind::deformable;
  object.scene = scene.limit_source() == LimitSource::taut ? with_limits(scene) : scene;
  object.scene.limits.from = scene.limits.from;
  std::erase_if(object.scene.prescribed, [](const Prescribed& p) { return !p.held; });
  object.scene.turns.clear();
  if (object.scene.prescribed.size() < scene.prescribed.size())
    left_out.emplace_back("the scene's moves: the hand moves the body");
  if (scene.has_loads())
    left_out.emplace_back(scene.contracts() ? "its loads and contracting fibres" : "its loads");
  object.scene.tractions.clear();
  object.scene.gravity = {0, 0, 0};
  object.scene.active_stress.clear();
  world.objects.push_back(std::move(object));
  return world;
}

} // namespace maille
