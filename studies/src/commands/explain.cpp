#include "commands.hpp"

#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>

namespace maille::studies {

namespace {

/// One part of the model, switched on by the scene or not.
struct Part {
  std::string name;
  bool on = false;
  std::string why;
};

/// What one part holds in memory.
struct Memory {
  std::string name;
  std::int64_t bytes = 0;
  std::string why;
};

std::int64_t n_links(const Specimen& body) {
  const Grid& grid = body.grid;
  std::int64_t links = 0;
  for (int axis = 0; axis < grid.dimension(); ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (body.material_id.empty()) {
      links += grid.n_nodes() / grid.nodes()[a] * grid.cells()[a];
      continue;
    }
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      bool borders = false;
      body.for_each_cell_at_link(grid.node_at(node), axis, [&](std::int64_t) { borders = true; });
      links += borders;
    }
  }
  return links;
}

std::string plural(std::int64_t count, const std::string& thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

std::string limit_words(const Scene& scene, const LinkLimits& limits) {
  const std::string spread =
      limits.is_homogeneous() ? "one table for all links" : "a table for each kind of cell";
  switch (scene.limits.from) {
  case LimitSource::taut:
    if (limits.taut_scale() == 0)
      return "taut, but no two prescribed values differ: nothing says how much slack there is";
    return fmt::format("taut at {:.4g} Pa, the stress at which the moves use the slack up; {}",
                       limits.taut_scale(), spread);
  case LimitSource::material:
    return "the materials' own; " + spread;
  case LimitSource::given:
    break;
  }
  return "given in the scene; " + spread;
}

std::vector<Part> parts_of(const Scene& scene, const LinkLimits& limits) {
  const Specimen& body = scene.specimen;
  const bool masked = body.n_matter_cells() != body.grid.n_cells();
  const bool anisotropic = std::any_of(scene.materials.begin(), scene.materials.end(),
                                       [](const Material& m) { return !m.elasticity.is_isotropic(); });
  std::set<std::int64_t> held, moved;
  for (const Prescribed& p : scene.prescribed)
    (p.held ? held : moved).insert(p.node);
  std::vector<Part> parts{
      {"mask of matter", masked, masked ? "the body does not fill its grid" : "the body fills its grid"},
      {"several materials", scene.materials.size() > 1,
       plural(static_cast<std::int64_t>(scene.materials.size()), "material")},
      {"anisotropy", anisotropic,
       anisotropic ? "stiffness depends on the fibre's direction" : "isotropic: fibres play no part"},
      {"fibres cell by cell", !body.fibres.empty(),
       body.fibres.empty() ? "one direction everywhere" : "a direction for each cell"},
      {"limits", true, limit_words(scene, limits)},
      {"holds", !held.empty(), plural(static_cast<std::int64_t>(held.size()), "node")},
      {"moves", !moved.empty(), plural(static_cast<std::int64_t>(moved.size()), "node")},
      {"loads", scene.has_loads(),
       scene.has_loads() ? "elastic methods only: limits, literal and sweep refuse"
                         : "no traction, no gravity"},
      {"relaxation", true,
       scene.relaxation.mode == RelaxationMode::elastic
           ? "elastic, within the limits: sweep to the mean of the neighbours, relaxed to the least energy"
           : "deformable: nothing moves inside the dead zone"},
      {"placement", !body.placement.is_identity(),
       body.placement.is_identity() ? "the object's frame is the world's" : "from the image's header"},
  };
  if (scene.dimension() == 2)
    parts.push_back({"plane stress", scene.plane == PlaneAssumption::stress,
                     scene.plane == PlaneAssumption::stress ? "the third direction is free"
                                                            : "plane strain: the third direction is held"});
  return parts;
}

std::vector<Memory> memory_of(const Scene& scene, const LinkLimits& limits) {
  const Specimen& body = scene.specimen;
  const auto bytes_of = [](const auto& list) {
    return static_cast<std::int64_t>(list.size() * sizeof(list[0]));
  };
  return {
      {"displacement", scene.dimension() * body.grid.n_nodes() * std::int64_t{sizeof(double)},
       fmt::format("{} components of float64 at {} grid points", scene.dimension(), body.grid.n_nodes())},
      {"material numbers", bytes_of(body.material_id),
       body.material_id.empty() ? "one material, no mask" : "1 byte a cell of the grid"},
      {"fibres", bytes_of(body.fibres),
       body.fibres.empty() ? "one direction" : "12 bytes a cell of the grid"},
      {"link limits", limits.bytes(),
       limits.is_homogeneous() ? "one table" : "a table for each kind of cell and 4 bytes a cell"},
      {"prescribed", bytes_of(scene.prescribed), fmt::format("{} components", scene.prescribed.size())},
      {"tractions", bytes_of(scene.tractions),
       plural(static_cast<std::int64_t>(scene.tractions.size()), "face")},
  };
}

} // namespace

int explain_command(const CommonOptions& options) {
  const Scene scene = read_scene(options.scene);
  const Specimen& body = scene.specimen;
  const LinkLimits limits(scene);
  const auto parts = parts_of(scene, limits);
  const auto memory = memory_of(scene, limits);
  const std::int64_t nodes = body.n_matter_nodes(), cells = body.n_matter_cells(), links = n_links(body);
  const Index3& size = body.grid.cells();

  if (options.json) {
    nlohmann::ordered_json out{{"scene", scene.name}, {"dimension", scene.dimension()},
                               {"shape", body.shape}, {"grid", size},
                               {"cells", cells},      {"nodes", nodes},
                               {"links", links},      {"taut_scale_pa", limits.taut_scale()}};
    for (const Part& part : parts)
      out["parts"].push_back({{"name", part.name}, {"on", part.on}, {"why", part.why}});
    for (const Memory& part : memory)
      out["memory"].push_back(
          {{"name", part.name},
           {"bytes", part.bytes},
           {"bytes_per_node", static_cast<double>(part.bytes) / static_cast<double>(nodes)},
           {"why", part.why}});
    for (const LeftOutPiece& piece : scene.left_out)
      out["left_out"].push_back({{"cells", piece.cells}, {"name", piece.name}});
    deliver(out.dump(2) + "\n", options.json);
    return exit_done;
  }
  std::string text =
      fmt::format("{}\n{}, {}D, grid of {} x {} x {} cells: {}, {}, {}\n\n", scene.title, body.shape,
                  scene.dimension(), size[0], size[1], size[2], plural(cells, "cell") + " of matter",
                  plural(nodes, "node"), plural(links, "link"));
  for (const Part& part : parts)
    text += fmt::format("{:<4}{:<22}{}\n", part.on ? "on" : "off", part.name, part.why);
  text += fmt::format("\n{:<20}{:>14}{:>12}  {}\n", "memory", "bytes", "a node", "why");
  for (const Memory& part : memory)
    text += fmt::format("{:<20}{:>14}{:>12.2f}  {}\n", part.name, part.bytes,
                        static_cast<double>(part.bytes) / static_cast<double>(nodes), part.why);
  for (const LeftOutPiece& piece : scene.left_out)
    text += fmt::format("left out: {}\n", piece.name);
  deliver(text, std::nullopt);
  return exit_done;
}

} // namespace maille::studies
