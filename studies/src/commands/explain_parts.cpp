#include "explain_parts.hpp"

#include "maille/scene/block_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace maille::studies {

std::string plural(std::int64_t count, const std::string& thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

namespace {

std::string source_words(const Scene& scene, const LinkLimits& limits) {
  const std::string spread =
      limits.is_homogeneous() ? "one table for all links" : "a table for each kind of cell";
  switch (scene.limit_source()) {
  case LimitSource::none:
  case LimitSource::taut:
    if (!scene.limits_bind_relaxed())
      return "taut ones, at the stress at which the moves use the slack up; " + spread;
    if (limits.taut_scale() == 0)
      return "taut, but no two prescribed values differ: nothing says how much slack there is";
    return fmt::format("taut at {:.4g} Pa, the stress at which the moves use the slack up; {}",
                       limits.taut_scale(), spread);
  case LimitSource::material:
    return "the materials' own; " + spread;
  case LimitSource::failure:
    return "at which the materials fail; " + spread;
  case LimitSource::given:
    break;
  }
  return "given in the scene; " + spread;
}

std::string tissue_words(const Specimen& body) {
  if (body.tissue.empty())
    return "every cell of matter is all tissue";
  std::int64_t in_part = 0;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    in_part += body.is_matter(cell) && body.tissue_of(cell) < 1 ? 1 : 0;
  return fmt::format("{} that the surface runs through count for their part", plural(in_part, "cell"));
}

std::string stiffness_words(const Specimen& body) {
  double least = INFINITY, most = 0;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell)) {
      least = std::min(least, body.stiffness_ratio_of(cell));
      most = std::max(most, body.stiffness_ratio_of(cell));
    }
  if (body.stiffness_ratio.empty())
    return "as the materials say";
  return fmt::format("{:.4g} to {:.4g} times the materials' own", least, most);
}

std::string sliding_words(const Scene& scene) {
  if (scene.sliding.empty())
    return "labels that touch are joined";
  std::string pairs;
  bool rubs = false;
  for (const SlidingBorder& pair : scene.sliding) {
    pairs += fmt::format("{}{} on {}", pairs.empty() ? "" : ", ", pair.one, pair.other);
    if (pair.friction > 0)
      pairs += fmt::format(" (friction {:.4g})", pair.friction);
    rubs = rubs || pair.friction > 0;
  }
  return pairs + ": tied along their normals alone" +
         (rubs ? ", and sticking to each other as far as friction holds" : "");
}

/// Limits in words, with the methods that use them.
std::string limit_words(const Scene& scene, const LinkLimits& limits) {
  const std::string source = source_words(scene, limits);
  if (!scene.limits_bind_relaxed())
    return "none asked for: relaxed, coupled and finite elements are unbounded; limits, dijkstra, literal "
           "and sweep take " +
           source;
  const std::string cut = scene.limits.cut_is_allowed ? "; prescribed values may be cut" : "";
  return (scene.limits_bind_coupled() ? source + "; relaxed and coupled stay within them"
                                      : source + "; relaxed stays within them, coupled does not need to") +
         cut;
}

} // namespace

std::vector<ModelPart> parts_of(const Scene& scene, const LinkLimits& limits, const Frame& frame) {
  const Specimen& body = scene.specimen;
  const bool masked = body.n_matter_cells() != body.grid.n_cells();
  const bool anisotropic = std::any_of(scene.materials.begin(), scene.materials.end(),
                                       [](const Material& m) { return !m.elasticity.is_isotropic(); });
  std::set<std::int64_t> held, moved;
  for (const Prescribed& p : scene.prescribed)
    (p.held ? held : moved).insert(p.node);
  std::vector<ModelPart> parts{
      {"mask of matter", masked, masked ? "the body does not fill its grid" : "the body fills its grid"},
      {"several materials", scene.materials.size() > 1,
       plural(static_cast<std::int64_t>(scene.materials.size()), "material")},
      {"anisotropy", anisotropic,
       anisotropic         ? "stiffness depends on the fibre's direction"
       : scene.contracts() ? "isotropic stiffness"
                           : "isotropic: fibres play no part"},
      {"fibres cell by cell", !body.fibres.empty(), fibre_words(body)},
      {"limits", scene.limits_bind_relaxed(), limit_words(scene, limits)},
      {"turned frame", frame.is_turned,
       frame.is_turned
           ? fmt::format("the moves turn the body by {:.4g} deg", frame.angle() * 180 / std::numbers::pi)
           : "limits are measured along the grid"},
      {"finite strain", scene.strain == Strain::finite,
       scene.strain == Strain::finite
           ? "coupled and finite elements: energy of each cell's deformation, by the laws of its matter"
           : "small strain, in one frame for the whole body"},
      {"holds", !held.empty(), plural(static_cast<std::int64_t>(held.size()), "node")},
      {"moves", !moved.empty(), plural(static_cast<std::int64_t>(moved.size()), "node")},
      {"loads", scene.has_loads(),
       scene.has_loads() ? "elastic methods only: limits, literal and sweep refuse"
                         : "no traction, no gravity, no contraction"},
      {"contraction", scene.contracts(), contraction_words(scene)},
      {"springs to the ground", !scene.springs.empty(),
       scene.springs.empty()
           ? "no foundation"
           : plural(static_cast<std::int64_t>(scene.springs.size()), "face") + ": elastic methods only"},
      {"partial volume", !body.tissue.empty(), tissue_words(body)},
      {"stiffness map", !body.stiffness_ratio.empty(), stiffness_words(body)},
      {"sliding borders", !scene.sliding.empty(), sliding_words(scene)},
      {"drives", !scene.drives.empty(),
       scene.drives.empty() ? "nothing follows a course"
                            : plural(static_cast<std::int64_t>(scene.drives.size()), "rigid motion") +
                                  " over the time of a run"},
      {"relaxation", true,
       scene.relaxation.mode == RelaxationMode::elastic
           ? "elastic: sweep to the mean of the neighbours within its limits, relaxed to the least energy"
           : "deformable: nothing moves inside the dead zone"},
      {"placement", !body.placement.is_identity(),
       body.placement.is_identity()
           ? "the object's frame is the world's"
           : "of the image or the turned lattice in the world; files for ParaView are in the world's frame"},
  };
  if (scene.dimension() == 2)
    parts.push_back({"plane stress", scene.plane == PlaneAssumption::stress,
                     scene.plane == PlaneAssumption::stress ? "the third direction is free"
                                                            : "plane strain: the third direction is held"});
  return parts;
}

std::vector<ModelPart> parts_of(const WorldScene& scene) {
  const auto has = [&](ObjectKind kind) {
    return std::ranges::find(scene.objects, kind, &WorldObject::kind) != scene.objects.end();
  };
  const bool is_deformable = has(ObjectKind::deformable);
  return {{"rigid objects", has(ObjectKind::rigid), "exact first contacts, no limits, no method"},
          {"deformable objects", is_deformable,
           is_deformable ? "their nodes are followed from cell to cell; " + scene.method + " relaxes them"
                         : "no links, no limits, no method"},
          {"friction", scene.friction > 0,
           scene.friction > 0 ? fmt::format("coefficient {}", scene.friction) : "contacts slide freely"},
          {"frame_budget", scene.frame_budget.has_value(),
           scene.frame_budget ? fmt::format("a frame ends after {} s, settled or not", *scene.frame_budget)
                              : "frames end when they have settled"}};
}

std::string fibre_words(const Specimen& body) {
  if (body.fibres.empty())
    return "one direction everywhere";
  return body.fibre_report.source.empty() ? "a direction for each cell" : in_words(body.fibre_report);
}

const ResultTable<FibreReport>& columns_of_fibres() {
  static const ResultTable<FibreReport> table([](ResultTable<FibreReport>& columns) {
    using Report = FibreReport;
    columns.add({"", "source", "", "of the directions"}, &Report::source);
    columns.add({"", "cells", "", "with a direction of their own"}, &Report::cells);
    columns.add({"", "without_direction.no_tensor", "", "cells: zero, or no number"}, &Report::no_tensor);
    columns.add({"", "without_direction.not_positive", "", "cells: noise"}, &Report::not_positive);
    columns.add({"", "without_direction.isotropic", "", "cells: none stands out"}, &Report::isotropic);
    columns.add({"", "filled.from_neighbours", "", "cells"}, &Report::from_neighbours);
    columns.add({"", "filled.from_label", "", "cells: no neighbour had one"}, &Report::from_label);
    columns.add({"", "filled.from_body", "", "cells: nothing in their label had one"}, &Report::from_body);
    columns.add({"", "smoothing_radius_m", "m", "0: not smoothed"}, &Report::smoothing_radius);
    columns.add({"", "smoothing_turn_deg", "deg", "mean turn by smoothing"},
                [](const Report& of) { return of.smoothing_turn * 180 / std::numbers::pi; });
  });
  return table;
}

std::string contraction_words(const Scene& scene) {
  double least = INFINITY, most = 0;
  std::int64_t count = 0;
  for (const double stress : scene.active_stress)
    if (stress > 0) {
      least = std::min(least, stress);
      most = std::max(most, stress);
      ++count;
    }
  if (count == 0)
    return "no fibre pulls";
  const std::string range =
      least == most ? fmt::format("{:.4g} Pa", most) : fmt::format("{:.4g} to {:.4g} Pa", least, most);
  return fmt::format("fibres of {} pull with {}: coupled and finite elements only",
                     count == 1 ? "1 cell" : fmt::format("{} cells", count), range);
}

double seconds_of_coupled(const Scene& scene) {
  constexpr double of_box = 6e-8, of_body = 1e-6, more_a_digit = 0.25; // per unknown, to 1e-3
  if (scene.dimension() < 3 || scene.limits_bind_coupled() || !scene.sliding.empty() || in_blocks(scene) ||
      scene.relaxation.extrapolation != Extrapolation::none)
    return 0;
  const Specimen& body = scene.specimen;
  const double digits = -3 - std::log10(scene.relaxation.tolerance),
               unknowns = 3.0 * static_cast<double>(body.n_matter_nodes());
  return unknowns * (body.material_id.empty() ? of_box : of_body) * std::max(0.5, 1 + more_a_digit * digits);
}

} // namespace maille::studies
