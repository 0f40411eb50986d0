#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "explain_parts.hpp"
#include "json_parts.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/plan.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/memory.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "maille/studies/methods.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace maille::studies {

namespace {

/// What the question itself holds.
deform::Footprint memory_of_scene(const Scene& scene) {
  const Specimen& body = scene.specimen;
  const auto bytes_of_list = [](const auto& list) {
    return static_cast<std::int64_t>(list.size() * sizeof(list[0]));
  };
  return {
      {"material numbers", bytes_of_list(body.material_id),
       body.material_id.empty() ? "one material, no mask" : "1 byte a cell of the grid"},
      {"fibres", bytes_of_list(body.fibres),
       body.fibres.empty() ? "one direction" : "12 bytes a cell of the grid"},
      {"labels", bytes_of_list(body.label),
       body.label.empty() ? "the body is no segmentation" : "4 bytes a cell of the grid"},
      {"prescribed", bytes_of_list(scene.prescribed), fmt::format("{} components", scene.prescribed.size())},
      {"active stress", bytes_of_list(scene.active_stress),
       scene.contracts() ? "8 bytes a cell of the grid" : "no contraction"},
      {"tractions", bytes_of_list(scene.tractions),
       plural(static_cast<std::int64_t>(scene.tractions.size()), "face")},
  };
}

/// One method, and the way that it takes.
struct Way {
  std::string method, words;
  std::int64_t bytes = 0; ///< at most; 0: not known before it runs
};

/// The way of a lattice method.
std::string way_of(std::string_view method, const Scene& scene, const deform::Plan& plan) {
  const bool is_elastic = scene.relaxation.mode == RelaxationMode::elastic;
  if (scene.contracts() && method != "coupled")
    return "refuses: its fibres cannot pull";
  if (method == "relaxed" && is_elastic)
    return "multigrid in conjugate gradients, component by component; multipliers where limits are active";
  if (method == "coupled" && in_blocks(scene))
    return "full elasticity on the lattice in a frame for every cell, quasi-Newton around multigrid";
  if (method == "coupled")
    return "full elasticity on the lattice, conjugate gradients around multigrid";
  if (scene.has_loads())
    return "refuses: it carries no loads";
  if (method == "limits")
    return plan.algorithm;
  if (method == "dijkstra")
    return "shortest paths node by node, per component";
  if (method == "literal")
    return "candidate lists, first moved, first processed";
  if (method == "relaxed")
    return "least movement, as limits";
  return is_elastic ? "node by node to the mean of the neighbours, within the limits"
                    : "node by node as little as the limits ask";
}

std::vector<Way> ways_of(const Scene& scene, const deform::Plan& plan) {
  std::vector<Way> ways;
  for (const std::string_view method : deform::methods()) {
    Way way{std::string(method), way_of(method, scene, plan), 0};
    if (!way.words.starts_with("refuses"))
      way.bytes = method == "limits" ? plan.bytes : deform::bytes_needed(scene, method);
    ways.push_back(std::move(way));
  }
  for (const std::string& method : all_methods())
    if (std::ranges::find(deform::methods(), method) == deform::methods().end())
      ways.push_back({method,
                      method == "calculix" ? "CalculiX, another program: C3D8 bricks, SPOOLES"
                                           : "deal.II; which solver shows when the matrix is there",
                      0});
  return ways;
}

/// All that `explain` says about memory, under the name of what holds it.
struct Holder {
  std::string name, title;
  deform::Footprint arrays;
};

std::vector<Holder> holders_of(const Scene& scene, const LinkLimits& limits, const deform::Plan& plan) {
  std::vector<Holder> holders{{"scene", "the scene", memory_of_scene(scene)}};
  if (scene.has_loads())
    return holders;
  holders.push_back({"limits", "an answer by limits: " + plan.algorithm, plan.arrays});
  holders.push_back({"drag", "a body to be dragged, at rest", deform::Drag::footprint(scene, limits)});
  return holders;
}

nlohmann::ordered_json in_json(const deform::Footprint& arrays, std::int64_t nodes) {
  auto list = nlohmann::ordered_json::array();
  for (const deform::ArrayBytes& array : arrays)
    list.push_back({{"name", array.name},
                    {"bytes", array.bytes},
                    {"bytes_per_node", static_cast<double>(array.bytes) / static_cast<double>(nodes)},
                    {"why", array.why}});
  return list;
}

std::string in_words(const Holder& holder, std::int64_t nodes) {
  const auto line = [nodes](const std::string& name, std::int64_t bytes, const std::string& why) {
    return fmt::format("{:<20}{:>14}{:>12.2f}  {}\n", name, bytes,
                       static_cast<double>(bytes) / static_cast<double>(nodes), why);
  };
  std::string text =
      fmt::format("\n{}\n{:<20}{:>14}{:>12}  {}\n", holder.title, "array", "bytes", "a node", "why");
  for (const deform::ArrayBytes& array : holder.arrays)
    text += line(array.name, array.bytes, array.why);
  const std::int64_t sum = deform::bytes_of(holder.arrays);
  return text + line("total", sum, bytes_in_words(static_cast<double>(sum)));
}

std::string in_words(const std::vector<Way>& ways, const deform::Plan& plan, int dimension) {
  std::string text = "\nmethods\n";
  for (const Way& way : ways) {
    const std::string bytes =
        way.bytes > 0 ? fmt::format(", at most {}", bytes_in_words(static_cast<double>(way.bytes))) : "";
    text += fmt::format("{:<10}{}{}\n", way.method, way.words, bytes);
    if (way.method == "limits" && way.bytes > 0)
      for (int b = 0; b < dimension; ++b)
        text += fmt::format("{:<10}  {}: {}\n", "", "xyz"[b],
                            deform::to_string(plan.of_component[static_cast<std::size_t>(b)]));
  }
  return text;
}

/// Plans do not depend on how much slack taut links have, and to find that out may take longer than an
/// answer.
Scene with_some_slack(Scene scene) {
  if (!scene.limits_bind_relaxed())
    scene.limits.taut_scale = 1;
  return scene;
}

/// What there is to say about a scene.
struct Explanation {
  explicit Explanation(const Scene& of)
      : scene(of), planned(with_some_slack(of)), limits(planned), frame(object_frame(of)),
        parts(parts_of(of, limits, frame)),
        plan(deform::plan_limits(frame.is_turned ? in_object(planned, frame) : planned, limits)),
        ways(ways_of(of, plan)), holders(holders_of(of, limits, plan)) {}

  const Scene& scene;
  Scene planned; ///< outlives its limits
  LinkLimits limits;
  Frame frame;
  std::vector<ModelPart> parts;
  deform::Plan plan;
  std::vector<Way> ways;
  std::vector<Holder> holders;
};

std::string in_words(const Explanation& about) {
  const Scene& scene = about.scene;
  const Specimen& body = scene.specimen;
  const Index3& size = body.grid.cells();
  std::string text = fmt::format(
      "{}\n{}, {}D, grid of {} x {} x {} cells: {}, {}, {}\n", scene.title, body.shape, scene.dimension(),
      size[0], size[1], size[2], plural(body.n_matter_cells(), "cell") + " of matter",
      plural(body.n_matter_nodes(), "node"), plural(body.n_matter_links(), "link"));
  const Plausibility proportions = plausibility(scene);
  text += maille::in_words(scene, proportions) + "\n";
  for (const std::string& warning : proportions.warnings)
    text += fmt::format("warning: {}\n", warning);
  text += "\n";
  for (const ModelPart& part : about.parts)
    text += fmt::format("{:<4}{:<22}{}\n", part.on ? "on" : "off", part.name, part.why);
  text += in_words(about.ways, about.plan, scene.dimension());
  for (const Holder& holder : about.holders)
    text += in_words(holder, body.n_matter_nodes());
  for (const LeftOutPiece& piece : scene.left_out)
    text += fmt::format("left out: {}\n", piece.name);
  return text;
}

nlohmann::ordered_json in_json(const Explanation& about) {
  const Scene& scene = about.scene;
  const Specimen& body = scene.specimen;
  const std::int64_t nodes = body.n_matter_nodes();
  nlohmann::ordered_json out{{"scene", scene.name},
                             {"dimension", scene.dimension()},
                             {"shape", body.shape},
                             {"grid", body.grid.cells()},
                             {"cells", body.n_matter_cells()},
                             {"nodes", nodes},
                             {"links", body.n_matter_links()},
                             {"taut_scale_pa", nullptr}};
  if (scene.limits.from == LimitSource::taut)
    out["taut_scale_pa"] = about.limits.taut_scale();
  out.update(studies::in_json(plausibility(scene)));
  for (const ModelPart& part : about.parts)
    out["parts"].push_back({{"name", part.name}, {"on", part.on}, {"why", part.why}});
  if (!body.fibre_report.source.empty())
    out["fibres"] = studies::in_json(body.fibre_report);
  for (const Way& way : about.ways) {
    out["methods"].push_back({{"method", way.method}, {"way", way.words}});
    if (way.bytes > 0)
      out["methods"].back()["bytes_at_most"] = way.bytes;
  }
  for (int b = 0; b < scene.dimension() && !scene.has_loads(); ++b)
    out["limits_route"].push_back(deform::to_string(about.plan.of_component[static_cast<std::size_t>(b)]));
  for (const Holder& holder : about.holders)
    out["memory"][holder.name] = {{"bytes", deform::bytes_of(holder.arrays)},
                                  {"arrays", in_json(holder.arrays, nodes)}};
  for (const LeftOutPiece& piece : scene.left_out)
    out["left_out"].push_back({{"cells", piece.cells}, {"name", piece.name}});
  return out;
}

} // namespace

std::string explanation(const Scene& scene) {
  return in_words(Explanation(scene));
}

int explain_command(const CommonOptions& options) {
  keep_inputs({options.scene});
  prepare_file("--json", options.json);
  if (is_world_scene(options.scene)) {
    const WorldScene scene = read_world_scene(options.scene);
    const deform::World world = world_of(scene, options.scene);
    deliver(options.json ? json_text(explanation_in_json(scene, world)) : explanation(scene, world),
            options.json);
    return exit_done;
  }
  const Scene scene = read_scene(options.scene);
  const Explanation about(scene);
  deliver(options.json ? json_text(in_json(about)) : in_words(about), options.json);
  return exit_done;
}

} // namespace maille::studies
