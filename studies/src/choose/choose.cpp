#include "choose/choose.hpp"

#include "maille/deform/solve.hpp"
#include "maille/fem_ref/solve.hpp"
#include "results/result_table.hpp"
#include "trade/measure.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace maille::studies {

namespace {

/// Upper bound of cells for lattices that are built only to forecast the cost of finite elements.
constexpr double most_cells = 2e6;

std::int64_t bytes_for(const Scene& scene, const std::string& method) {
  if (!is_finite_elements(method))
    return deform::bytes_needed(scene, method);
  fem_ref::Options options;
  options.degree = method == "fem_q2" ? 2 : 1;
  return static_cast<std::int64_t>(fem_ref::estimate(scene, options).bytes);
}

/// Reason that a method has no forecast on any lattice; empty if it has.
std::string why_left_out(const Probes& probes, const std::string& method) {
  if (is_finite_elements(method) && !probes.quantity.empty())
    return fmt::format("of finite elements the table alone knows, and it holds no errors of {}",
                       probes.quantity);
  if (is_finite_elements(method))
    return probes.growth ? "of finite elements the table alone knows, and the scene is unlike its own" : "";
  const auto probed = probes.of.find(method);
  return probed == probes.of.end() ? "it is not probed" : probed->second.why_not;
}

bool is_too_large(const Scene& scene, int halvings) {
  return halvings > 0 &&
         static_cast<double>(scene.specimen.grid.n_cells()) * std::exp2(halvings * scene.dimension()) >
             most_cells;
}

/// Fills the entry. @return reason of a missing forecast, or empty
std::string fill(nlohmann::ordered_json& entry, Lattices& lattices, const Probes& probes, const Way& way) {
  if (const auto lost = probes.lost.find(way.halvings); lost != probes.lost.end())
    return lost->second;
  if (std::string reason = why_left_out(probes, way.method); !reason.empty())
    return reason;
  if (is_too_large(lattices.scene(), way.halvings))
    return "its lattice is too large to look at";
  const LatticeScene lattice = lattices.at(way.halvings);
  if (!lattice.scene)
    return lattice.why_not;
  const Grid& grid = lattice.scene->specimen.grid;
  const std::int64_t nodes = lattice.scene->specimen.n_matter_nodes();
  const RawPrediction raw = predict_raw(probes, way, lattice.scene.get(), nodes);
  if (!raw.error || !raw.seconds)
    return "nothing is known about it";
  const auto along_axes = [&](const auto& list) {
    return std::vector(list.begin(), list.begin() + grid.dimension());
  };
  entry["cells"] = along_axes(grid.cells());
  entry["spacing"] = along_axes(grid.spacing());
  entry["nodes"] = nodes;
  entry["error"] = *raw.error;
  entry["seconds"] = *raw.seconds;
  entry["bytes"] = bytes_for(*lattice.scene, way.method);
  return {};
}

const ResultTable<Probes::OfMethod>& columns_of_probed() {
  static const ResultTable<Probes::OfMethod> table([](ResultTable<Probes::OfMethod>& columns) {
    using Probed = Probes::OfMethod;
    const auto answers = [](const Probed& of) { return of.why_not.empty(); };
    columns.add({"", "model_error", "", "relative L2 distance from coupled"}, &Probed::model_error)
        .json_where(answers);
    columns.add({"", "seconds", "s", "of an answer"}, &Probed::seconds).json_where(answers);
    columns.add({"", "message", "", "why the method has no answer"}, &Probed::why_not)
        .json_where([=](const Probed& of) { return !answers(of); });
  });
  return table;
}

Value methods_of(const Probes& probes) {
  Value methods = Value::object();
  for (const auto& [method, probed] : probes.of)
    methods[method] = columns_of_probed().json(probed);
  return methods;
}

const ResultTable<Probes>& columns_of_probes() {
  static const ResultTable<Probes> table([](ResultTable<Probes>& columns) {
    columns.add({"", "seconds", "s", "of all probes"}, &Probes::seconds);
    columns.add({"", "spacing_factor", "", "of the finer lattice over the scene's"},
                [](const Probes& probes) { return std::exp2(-probes.halvings); });
    columns.add({"", "nodes", "", "of the finer lattice"}, &Probes::nodes);
    columns.add({"", "difference", "", "relative L2, between the two lattices"}, &Probes::difference);
    columns.add({"", "unlike_the_table", "", "in what the scene is"}, &Probes::unlike)
        .json_where([](const Probes& of) { return !of.unlike.empty(); });
    columns.add({"", "growth", "", "of that difference with the spacing"}, &Probes::growth).omitted();
    columns.add({"", "methods", "", "model_error and seconds, or message, of each"}, methods_of)
        .json_where([](const Probes& of) { return !of.of.empty(); });
  });
  return table;
}

} // namespace

nlohmann::ordered_json json(const Probes& probes) {
  return columns_of_probes().json(probes);
}

nlohmann::ordered_json prospects(Lattices& lattices, const Probes& probes, int coarsest, int finest) {
  auto list = nlohmann::ordered_json::array();
  for (int halvings = coarsest; halvings <= finest; ++halvings)
    for (const char* method : {"limits", "relaxed", "coupled", "fem_q1", "fem_q2"}) {
      nlohmann::ordered_json& entry =
          list.emplace_back(nlohmann::ordered_json{{"method", method}, {"halvings", halvings}});
      if (const std::string why_not = fill(entry, lattices, probes, {method, halvings, {}}); !why_not.empty())
        entry["why_not"] = why_not;
    }
  return list;
}

} // namespace maille::studies
