#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "cli/worlds.hpp"
#include "compare/methods.hpp"
#include "explain_parts.hpp"
#include "maille/base/arena.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/plan.hpp"
#include "maille/deform/solve.hpp"
#include "maille/images/image.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/look.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "picture/question_picture.hpp"
#include "picture/read_picture.hpp"
#include "trade/lattices.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <sstream>
#include <utility>

namespace maille::studies {

namespace {

/// Memory of the scene itself.
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

/// One method and its algorithm.
struct Way {
  std::string method, words;
  std::int64_t bytes = 0; ///< upper bound; 0: unknown before it runs
  double seconds = 0;     ///< approximate; 0: unknown
};

/// Algorithm of a lattice method, in words.
std::string way_of(std::string_view method, const Scene& scene, const deform::Plan& plan) {
  const bool is_elastic = scene.relaxation.mode == RelaxationMode::elastic;
  if (scene.contracts() && method != "coupled")
    return "refuses: its fibres cannot pull";
  if (method == "relaxed" && is_elastic)
    return "multigrid in conjugate gradients, component by component; multipliers where limits are active";
  if (method == "coupled" && scene.strain == Strain::finite)
    return "finite strain on the lattice, Newton steps around multigrid";
  if (method == "coupled")
    return std::string("full elasticity on the lattice, conjugate gradients around multigrid") +
           (scene.dimension() == 3 && !scene.specimen.material_id.empty()
                ? " (around a factor if very slender)"
                : "");
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
    Way way{std::string(method), way_of(method, scene, plan)};
    if (!way.words.starts_with("refuses"))
      way.bytes = method == "limits" ? plan.bytes : deform::bytes_needed(scene, method);
    if (method == "coupled" && way.bytes > 0)
      way.seconds = seconds_of_coupled(scene);
    ways.push_back(std::move(way));
  }
  for (const std::string& method : all_methods())
    if (std::ranges::find(deform::methods(), method) == deform::methods().end())
      ways.push_back({method, method == "calculix" ? "CalculiX, another program: C3D8 bricks, SPOOLES"
                                                   : "deal.II; which solver shows when the matrix is there"});
  return ways;
}

/// Memory entries of `explain`, grouped by owner.
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

/// One array, or the sum of all arrays of an owner.
struct ArrayOfBody {
  deform::ArrayBytes of;
  std::int64_t nodes = 1; ///< nodes of the body
};

std::vector<ArrayOfBody> arrays_of(const Holder& holder, std::int64_t nodes) {
  std::vector<ArrayOfBody> rows;
  for (const deform::ArrayBytes& array : holder.arrays)
    rows.push_back({array, nodes});
  return rows;
}

const ResultTable<ArrayOfBody>& columns_of_arrays() {
  static const ResultTable<ArrayOfBody> table([](ResultTable<ArrayOfBody>& columns) {
    constexpr auto array = &ArrayOfBody::of;
    const auto in_two = [](double bytes) { return fmt::format("{:.2f}", bytes); };
    columns.add({"", "name", "", "of the array"}, {"array", -20}, array, &deform::ArrayBytes::name);
    columns.add({"", "bytes", "B", "that it holds"}, {"bytes", 13}, array, &deform::ArrayBytes::bytes);
    columns.add({"", "bytes_per_node", "B", "over the body's nodes"}, {"a node", 11, in_two},
                [](const ArrayOfBody& row) {
                  return static_cast<double>(row.of.bytes) / static_cast<double>(row.nodes);
                });
    columns.add({"", "why", "", "it is there, in words"}, {"why"}, array, &deform::ArrayBytes::why);
  });
  return table;
}

std::string in_words(const Holder& holder, std::int64_t nodes) {
  std::vector<ArrayOfBody> rows = arrays_of(holder, nodes);
  const std::int64_t sum = deform::bytes_of(holder.arrays);
  rows.push_back({{"total", sum, bytes_in_words(static_cast<double>(sum))}, nodes});
  return fmt::format("\n{}\n{}", holder.title, columns_of_arrays().text(rows));
}

const ResultTable<Way>& columns_of_ways() {
  static const ResultTable<Way> table([](ResultTable<Way>& columns) {
    columns.add({"", "method", "", "its name"}, &Way::method);
    columns.add({"", "way", "", "that it takes, in words"}, &Way::words);
    columns.add({"", "bytes_at_most", "B", "where that is known before it runs"}, &Way::bytes)
        .json_where([](const Way& way) { return way.bytes > 0; });
    columns
        .add({"", "seconds", "s", "on one thread, within a factor of three, where that is known"},
             &Way::seconds)
        .json_where([](const Way& way) { return way.seconds > 0; });
  });
  return table;
}

std::string in_words(const std::vector<Way>& ways, const deform::Plan& plan, int dimension) {
  std::string text = "\nmethods\n";
  for (const Way& way : ways) {
    const std::string bytes =
        way.bytes > 0 ? fmt::format(", at most {}", bytes_in_words(static_cast<double>(way.bytes))) : "";
    const std::string seconds =
        way.seconds > 0
            ? fmt::format(", about {:.2g} s on one thread (a third to three times that)", way.seconds)
            : "";
    text += fmt::format("{:<10}{}{}{}\n", way.method, way.words, bytes, seconds);
    if (way.method == "limits" && way.bytes > 0)
      for (int b = 0; b < dimension; ++b)
        text += fmt::format("{:<10}  {}: {}\n", "", "xyz"[b], deform::to_string(plan.of_component[b]));
  }
  return text;
}

/// Copy with some slack for taut links: plans do not depend on its size, and computing it may take longer
/// than an answer.
Scene with_some_slack(Scene scene) {
  if (!scene.limits_bind_relaxed())
    scene.limits.taut_scale = 1;
  return scene;
}

/// Data of `explain` for a scene.
struct Explanation {
  explicit Explanation(const Scene& of)
      : scene(&of), planned(with_some_slack(of)), limits(planned), frame(object_frame(of)),
        parts(parts_of(of, limits, frame)),
        plan(frame.is_turned ? deform::plan_limits(in_object(planned, frame), limits)
                             : deform::plan_limits(planned, limits)),
        proportions(plausibility(of)), ways(ways_of(of, plan)), holders(holders_of(of, limits, plan)) {
    const std::vector<std::string> of_files = file_warnings();
    proportions.warnings.insert(proportions.warnings.begin(), of_files.begin(), of_files.end());
  }

  const Scene* scene;
  Scene planned; ///< must outlive its limits
  LinkLimits limits;
  Frame frame;
  std::vector<ModelPart> parts;
  deform::Plan plan;
  Plausibility proportions;
  std::vector<Way> ways;
  std::vector<Holder> holders;
};

/// Memory of `run --out` by `coupled`: the scene, and the answer's fields or data derived from them.
std::int64_t bytes_of_run(const Scene& scene) {
  constexpr std::int64_t of_grid_node = 24, of_grid_cell = 8, of_cell = 70, of_cell_in_file = 300,
                         file_at_most = 1 << 30;
  const Grid& grid = scene.specimen.grid;
  const std::int64_t made = of_grid_node * grid.n_nodes() + of_grid_cell * grid.n_cells() +
                            of_cell * scene.specimen.n_matter_cells() +
                            std::min(file_at_most, of_cell_in_file * grid.n_cells());
  return deform::bytes_of(memory_of_scene(scene)) + std::max(deform::bytes_needed(scene, "coupled"), made);
}

/// Blocks of voxels per cell with which a run fits into memory.
struct Fit {
  std::int64_t run = 0, available = 0; ///< [bytes]
  std::optional<int> merged;           ///< voxels per cell along each axis, times the scene's, that fit
  std::int64_t of_merged = 0;
};

/// The scene of a file, with `times` as many image voxels merged along each axis.
Scene merged_scene(const std::filesystem::path& file, int times) {
  toml::table table = toml::parse_file(file.string());
  coarsen_image(*table["specimen"].as_table(), times);
  std::ostringstream text;
  text << table;
  return parse_scene(text.view(), file);
}

/// Merging that fits into memory; nothing if a run fits already.
std::optional<Fit> fit_of(const Scene& scene, const std::filesystem::path& file) {
  constexpr int most_merged = 8;
  Fit fit{bytes_of_run(scene), available_memory(), {}, 0};
  if (fit.run <= fit.available)
    return std::nullopt;
  try {
    for (int times = 2; times <= most_merged && !fit.merged && scene.specimen.shape == "image"; ++times)
      if (const std::int64_t bytes = bytes_of_run(merged_scene(file, times)); bytes <= fit.available) {
        fit.merged = times;
        fit.of_merged = bytes;
      }
  } catch (const std::exception&) {
    // Blocks this large lose the body or its holds: no merging is reported.
  }
  return fit;
}

std::string in_words(const Fit& fit) {
  const auto words = [](std::int64_t bytes) { return bytes_in_words(static_cast<double>(bytes)); };
  std::string text = fmt::format("run by coupled needs up to {} in all, {} are available", words(fit.run),
                                 words(fit.available));
  if (fit.merged)
    text += fmt::format("; with {} times the scene's `coarsen` it needs up to {}, and fits", *fit.merged,
                        words(fit.of_merged));
  return text + "\n";
}

std::string in_words(const Explanation& about) {
  const Scene& scene = *about.scene;
  const Specimen& body = scene.specimen;
  const Index3& size = body.grid.cells();
  std::string text = fmt::format(
      "{}\n{}, {}D, grid of {} x {} x {} cells: {}, {}, {}\n", scene.title, body.shape, scene.dimension(),
      size[0], size[1], size[2], plural(body.n_matter_cells(), "cell") + " of matter",
      plural(body.n_matter_nodes(), "node"), plural(body.n_matter_links(), "link"));
  text += maille::in_words(scene, about.proportions) + "\n";
  for (const std::string& warning : about.proportions.warnings)
    text += fmt::format("warning: {}\n", warning);
  text += "\n";
  text += columns_of_model().text(about.parts);
  text += in_words(about.ways, about.plan, scene.dimension());
  for (const Holder& holder : about.holders)
    text += in_words(holder, body.n_matter_nodes());
  return text;
}

std::optional<double> taut_scale_of(const Explanation& about) {
  return about.scene->limits.from == LimitSource::taut ? std::optional(about.limits.taut_scale())
                                                       : std::nullopt;
}

/// Algorithms, one word per displacement component.
Value algorithms_of(const Explanation& about) {
  Value words = Value::array();
  for (int b = 0; b < about.scene->dimension(); ++b)
    words.push_back(deform::to_string(about.plan.of_component[b]));
  return words;
}

Value memory_of(const Explanation& about) {
  Value all = Value::object();
  for (const Holder& holder : about.holders)
    all[holder.name] = {
        {"bytes", deform::bytes_of(holder.arrays)},
        {"arrays", columns_of_arrays().json_rows(arrays_of(holder, about.scene->specimen.n_matter_nodes()))}};
  return all;
}

const ResultTable<Explanation>& columns_of_explanation() {
  static const ResultTable<Explanation> table([](ResultTable<Explanation>& columns) {
    constexpr auto scene = &Explanation::scene;
    constexpr auto body = &Scene::specimen;
    columns.add({"", "scene", "", "its name"}, scene, &Scene::name);
    columns.add({"", "dimension", "", "of the scene"}, scene, &Scene::dimension);
    columns.add({"", "shape", "", "as the scene has it"}, scene, body, &Specimen::shape);
    columns.add({"", "grid", "", "cells along x, y and z"}, scene, body, &Specimen::grid, &Grid::cells);
    columns.add({"", "cells", "", "of matter"}, scene, body, &Specimen::n_matter_cells);
    columns.add({"", "nodes", "", "of matter"}, scene, body, &Specimen::n_matter_nodes);
    columns.add({"", "links", "", "of matter"}, scene, body, &Specimen::n_matter_links);
    columns.add({"", "taut_scale_pa", "Pa", "of limits that are taut"}, taut_scale_of);
    add_plausibility(columns, {}, &Explanation::proportions);
    columns.add_rows({"", "parts", "", "of the model"}, columns_of_model(), &Explanation::parts);
    columns
        .add_row({"", "fibres", "", "where directions differ from cell to cell"}, columns_of_fibres(), scene,
                 body, &Specimen::fibre_report)
        .json_where([](const Explanation& of) { return !of.scene->specimen.fibre_report.source.empty(); });
    columns.add_rows({"", "methods", "", "a row each"}, columns_of_ways(), &Explanation::ways);
    columns.add({"", "limits_route", "", "how limits propagate, a word a component"}, algorithms_of)
        .json_where([](const Explanation& of) { return !of.scene->has_loads(); });
    columns.add({"", "memory", "B", "of the scene, an answer by limits, a drag: bytes and arrays"},
                memory_of);
    columns.add_rows({"", "left_out", "", "pieces that were"}, columns_of_left_out(), scene, &Scene::left_out)
        .json_where([](const Explanation& of) { return !of.scene->left_out.empty(); });
  });
  return table;
}

/// Data of `explain` for a world.
struct WorldExplanation {
  const WorldScene* scene;
  std::int64_t map = 0, objects = 0; ///< [bytes]
};

std::int64_t places_of(const WorldObject& object) {
  const Specimen& body = object.scene.specimen;
  return object.kind == ObjectKind::deformable ? body.n_matter_nodes() : body.n_matter_cells();
}

const ResultTable<WorldObject>& columns_of_objects() {
  static const ResultTable<WorldObject> table([](ResultTable<WorldObject>& columns) {
    constexpr auto scene = &WorldObject::scene;
    constexpr auto body = &Scene::specimen;
    columns.add({"", "name", "", "of the object"}, {"object", -19}, &WorldObject::name);
    columns.add({"", "kind", "", "fixed, rigid or deformable"}, {"kind", -11}, &WorldObject::kind, name_of);
    columns.add({"", "shape", "", "as the scene has it"}, {"shape", -13}, scene, body, &Specimen::shape);
    columns.add({}, {"voxels", 10}, places_of);
    columns.add({"", "cells", "", "of matter"}, scene, body, &Specimen::n_matter_cells);
    columns.add({"", "nodes", "", "of matter"}, scene, body, &Specimen::n_matter_nodes);
  });
  return table;
}

const ResultTable<WorldExplanation>& columns_of_world() {
  static const ResultTable<WorldExplanation> table([](ResultTable<WorldExplanation>& columns) {
    constexpr auto scene = &WorldExplanation::scene;
    columns.add({"", "scene", "", "its name"}, scene, &WorldScene::name);
    columns.add({"", "dimension", "", "of the world"}, scene, &WorldScene::dimension);
    columns.add({"", "cells", "", "along x, y and z"}, scene, &WorldScene::cells);
    columns.add({"", "method", "", "that moves deformable objects"}, scene, &WorldScene::method);
    columns.add_rows({"", "parts", "", "of the model"}, columns_of_model(), scene,
                     [](const WorldScene& of) { return parts_of(of); });
    columns.add_rows({"", "objects", "", "a row each"}, columns_of_objects(), scene, &WorldScene::objects);
    columns.add({"", "memory.map", "B", "of occupied cells"}, &WorldExplanation::map);
    columns.add({"", "memory.objects", "B", "all together"}, &WorldExplanation::objects);
  });
  return table;
}

std::string in_words(const WorldExplanation& about) {
  const WorldScene& scene = *about.scene;
  return fmt::format("{}\n{}\n\n{}\n{}\noccupancy map {} bytes, objects {} bytes\n", scene.title,
                     studies::in_words(scene), columns_of_model().text(parts_of(scene)),
                     columns_of_objects().text(scene.objects), about.map, about.objects);
}

} // namespace

std::string explanation(const Scene& scene) {
  return in_words(Explanation(scene));
}

namespace {

/// Bytes of grey values and colours of the looks of a scene; nothing without looks.
std::optional<std::int64_t> bytes_of_looks(const std::filesystem::path& file) {
  const auto of_picture = [](const std::string& name) {
    const ColourPicture picture = read_picture(name);
    return std::int64_t{4} * picture.width * picture.height; // as stored
  };
  std::optional<std::int64_t> bytes;
  for (const auto& seen : read_looks(file))
    if (seen)
      bytes = bytes.value_or(0) + seen->bytes() +
              (seen->look.picture.empty() ? 0 : of_picture(seen->look.picture));
  return bytes;
}

/// Prints the explanation, with the memory of volume pictures.
void deliver_with_looks(const CheckOptions& options, nlohmann::ordered_json json, std::string text) {
  if (const auto bytes = bytes_of_looks(options.scene)) {
    json["looks_bytes"] = *bytes;
    text += fmt::format(
        "looks: {} bytes of grey values and colours, where pictures are rendered and nowhere else\n", *bytes);
  }
  deliver(options.json ? json_text(json) : text, options.json);
}

} // namespace

int explain_command(const CheckOptions& options) {
  keep_inputs({options.scene});
  prepare_file("--json", options.json);
  prepare_file("--picture", options.picture);
  if (is_world_scene(options.scene)) {
    if (options.picture)
      throw UsageError("--picture: expected a scene with a [specimen], found a [world]: play draws those");
    const WorldScene scene = read_world_scene(options.scene);
    const PlacedWorld world = placed(scene, options.scene);
    const WorldExplanation about{&scene, world.map, world.objects};
    deliver_with_looks(options, columns_of_world().json(about), in_words(about));
    return exit_done;
  }
  const Scene scene = read_scene(options.scene);
  const Explanation about(scene);
  nlohmann::ordered_json json = columns_of_explanation().json(about);
  std::string text = in_words(about);
  if (const std::optional<Fit> fit = fit_of(scene, options.scene)) {
    json["run_bytes_at_most"] = fit->run;
    json["available_bytes"] = fit->available;
    if (fit->merged)
      json["coarsen_times_that_fits"] = *fit->merged;
    text += in_words(*fit);
  }
  deliver_with_looks(options, std::move(json), std::move(text));
  if (!options.picture)
    return exit_done;
  QuestionPictureSettings settings;
  settings.is_anatomical = is_of_a_patient(options.scene);
  tell_of_picture(render_question(scene, *options.picture, settings), *options.picture);
  return exit_done;
}

} // namespace maille::studies
