#include "mechanics/mechanics_report.hpp"

#include "text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

namespace maille::studies {

namespace {

std::string part_in_words(const PartMechanics& part) {
  if (part.label)
    return fmt::format("{} {}", *part.label, part.material);
  return part.material.empty() ? "whole body" : part.material;
}

using Parts = ResultTable<PartMechanics>;
using SpreadOfPart = std::optional<Spread> PartMechanics::*;

/// All of its figures in JSON, one of them in the table for people.
void add_spread(Parts& columns, const std::string& key, const std::string& unit, const std::string& meaning,
                SpreadOfPart spread, double Spread::*shown = nullptr, const Shown& as = {}) {
  struct Figure {
    const char *key, *meaning;
    double Spread::*value;
  };
  constexpr std::array<Figure, 6> figures{{{"mean", "mean", &Spread::mean},
                                           {"min", "least", &Spread::least},
                                           {"max", "most", &Spread::most},
                                           {"p5", "5 % percentile", &Spread::percentile_5},
                                           {"p50", "50 % percentile", &Spread::median},
                                           {"p95", "95 % percentile", &Spread::percentile_95}}};
  for (const Figure& figure : figures)
    columns.add({"", key + "." + figure.key, unit, fmt::format("{}: {}", meaning, figure.meaning)},
                figure.value == shown ? as : Shown{}, spread, figure.value);
}

/// Figures that are rounding beside the largest of their kind are 0, for people.
void drop_rounding(PartMechanics& part) {
  constexpr double rounding = 1e-6;
  const auto drop = [](std::initializer_list<std::optional<Spread>*> figures, double* other) {
    double largest = 0;
    for (const auto* figure : figures)
      if (*figure)
        largest = std::max({largest, std::abs((*figure)->least), std::abs((*figure)->most)});
    for (auto* figure : figures)
      if (*figure)
        for (double* value : {&(*figure)->mean, &(*figure)->most})
          *value = std::abs(*value) < rounding * largest ? 0 : *value;
    if (other != nullptr && std::abs(*other) < rounding * largest)
      *other = 0;
  };
  double change = part.volume_change();
  drop({&part.fibre_strain, &part.largest_strain, &part.smallest_strain}, &change);
  if (change == 0)
    part.volume = part.volume_at_rest;
  drop({&part.fibre_stress, &part.von_mises, &part.pressure}, nullptr);
}

} // namespace

const Parts& columns_of_parts() {
  static const Parts table([](Parts& columns) {
    columns.add({"", "", "", ""}, {"part", -26}, part_in_words);
    columns.add({"", "label", "", "grey value of the image"}, &PartMechanics::label).omitted();
    columns.add({"", "material", "", "its name, of a label that of its first cell"}, &PartMechanics::material)
        .json_where([](const PartMechanics& part) { return !part.material.empty(); });
    columns.add({"", "cells", "", "of matter"}, {"cells", 9}, &PartMechanics::cells);
    columns.add({"", "volume_at_rest", "m^3", "m^2 in 2D, m in 1D"}, &PartMechanics::volume_at_rest);
    columns.add({"", "volume", "m^3", "deformed"}, &PartMechanics::volume);
    columns.add({"", "volume_change", "", "over the volume at rest"}, {"volume change", 13, in_percent},
                &PartMechanics::volume_change);
    add_spread(columns, "fibre_strain", "", "strain along the fibre", &PartMechanics::fibre_strain,
               &Spread::mean, {"fibre strain", 13, in_percent, true});
    add_spread(columns, "largest_strain", "", "largest principal strain", &PartMechanics::largest_strain);
    add_spread(columns, "smallest_strain", "", "smallest principal strain", &PartMechanics::smallest_strain);
    add_spread(columns, "fibre_stress", "Pa", "stress along the fibre", &PartMechanics::fibre_stress,
               &Spread::mean, {"fibre stress", 13, in_pascals, true});
    add_spread(columns, "von_mises", "Pa", "von Mises stress", &PartMechanics::von_mises, &Spread::most,
               {"most von Mises", 15, in_pascals, true});
    add_spread(columns, "pressure", "Pa", "minus the mean normal stress", &PartMechanics::pressure);
    columns
        .add({"", "strain_energy", "J", "J/m in 2D"},
             {"energy", 13, [](double joules) { return fmt::format("{:.4g} J", joules); }, true},
             &PartMechanics::strain_energy)
        .omitted();
  });
  return table;
}

const ResultTable<Resultant>& columns_of_resultants() {
  static const ResultTable<Resultant> table([](ResultTable<Resultant>& columns) {
    columns.add({"", "name", "", "hold[1], move[1], load[1], ... in the scene's order"}, &Resultant::name);
    columns.add({"", "where", "", "as the scene has it"}, &Resultant::where);
    columns.add({"", "centroid", "m", "of its region, x y z of the world"}, &Resultant::centroid);
    columns.add({"", "force", "N", "on the body, N/m in 2D"}, &Resultant::force);
    columns.add({"", "moment", "N m", "on the body about the centroid, N in 2D"}, &Resultant::moment);
  });
  return table;
}

nlohmann::ordered_json in_json(const Mechanics& mechanics) {
  const Parts& parts = columns_of_parts();
  const auto& resultants = columns_of_resultants();
  return {{"conventions", mechanics_conventions()},
          {"energy", mechanics.energy_is_of_means ? "half of the cells' mean stress by their mean strain"
                                                  : "what the method minimises"},
          {"holds", resultants.json_rows(mechanics.holds)},
          {"moves", resultants.json_rows(mechanics.moves)},
          {"loads", resultants.json_rows(mechanics.loads)},
          {"labels", parts.json_rows(mechanics.labels)},
          {"materials", parts.json_rows(mechanics.materials)},
          {"body", parts.json(mechanics.body)}};
}

std::string in_words(const Mechanics& mechanics) {
  std::vector<PartMechanics> rows = mechanics.labels.empty() ? mechanics.materials : mechanics.labels;
  if (rows.size() > 1)
    rows.push_back(mechanics.body);
  std::ranges::for_each(rows, drop_rounding);
  return columns_of_parts().text(rows);
}

} // namespace maille::studies
