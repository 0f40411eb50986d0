#include "cli/commands.hpp"
#include "results/scene_tables.hpp"

#include "maille/materials/elasticity.hpp"
#include "maille/materials/library.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <vector>

namespace maille::studies {

namespace {

Eigen::Matrix<double, 6, 1> eigenvalues(const Matrix6& C) {
  return Eigen::SelfAdjointEigenSolver<Matrix6>(C, Eigen::EigenvaluesOnly).eigenvalues();
}

/// Bulk modulus of a uniform stress, 1 / sum of the 3 x 3 compliance block (Reuss).
double bulk_modulus(const ElasticConstants& constants) {
  return 1 / compliance(constants).topLeftCorner<3, 3>().sum();
}

/// Data of all derived tables: Poisson's ratios of a nearly incompressible tissue with these moduli.
struct NearlyIncompressible {
  double bulk_modulus = 0; ///< [Pa]
  std::array<double, 3> poisson_ratio{};
};

/// Values for bulk moduli suited to linear elements (20 times the largest shear modulus) and to elements
/// without locking (100 times). Omitted if the material would be invalid: its moduli do not permit such a
/// stiff volume.
std::vector<NearlyIncompressible> nearly_incompressible(const ElasticConstants& e) {
  std::vector<NearlyIncompressible> sets;
  for (const double factor : {20.0, 100.0}) {
    const double K = factor * std::max({e.G12, e.G13, e.G23});
    const std::array<double, 3> nu = poisson_ratios_at(e.youngs_modulus, K);
    if (violated_inequalities({e.youngs_modulus, nu[0], nu[1], nu[2], e.G12, e.G13, e.G23}).empty())
      sets.push_back({K, nu});
  }
  return sets;
}

const ResultTable<NearlyIncompressible>& columns_of_incompressible() {
  static const ResultTable<NearlyIncompressible> table([](ResultTable<NearlyIncompressible>& columns) {
    using Set = NearlyIncompressible;
    columns.add({"", "bulk_modulus_pa", "Pa", "20 and 100 times the largest G"}, &Set::bulk_modulus);
    columns.add({"", "poisson_ratio", "", "nu12, nu13, nu23 at the same E"}, &Set::poisson_ratio);
  });
  return table;
}

/// Failure data, and the resulting limits of links.
const ResultTable<Damage>& columns_of_damage() {
  static const ResultTable<Damage> table([](ResultTable<Damage>& columns) {
    const auto add = [&](const char* key, const char* meaning, auto limit) {
      columns.add({"", key, "", meaning}, limits_before_failure, limit);
    };
    add("stretch", "length over that at rest, axes 1 2 3", &NeighbourLimits::stretch);
    add("compress", "length over that at rest", &NeighbourLimits::compress);
    add("shear", "over the length at rest, by axis of the link and of the displacement",
        &NeighbourLimits::shear);
    columns.add({"", "compress_is_derived", "", "from the stretch"},
                [](const Damage& of) { return !of.compress; });
    columns.add({"", "shear_is_derived", "", "from the stretch"}, [](const Damage& of) { return !of.shear; });
    columns.add({"", "of", "", "what was pulled, and what failed"}, &Damage::of);
    columns.add({"", "source", "", "author, year, identifier"}, &Damage::source);
    columns.add({"", "verified", "", "the numbers were read in the source"}, &Damage::verified);
  });
  return table;
}

std::vector<std::vector<double>> rows_of(const ElasticConstants& constants) {
  const Matrix6 C = stiffness(constants);
  std::vector<std::vector<double>> rows;
  for (int i = 0; i < 6; ++i)
    rows.push_back({C(i, 0), C(i, 1), C(i, 2), C(i, 3), C(i, 4), C(i, 5)});
  return rows;
}

double anisotropy_of(const ElasticConstants& constants) {
  return constants.youngs_modulus[0] / constants.youngs_modulus[1];
}

void add_constants(ResultTable<LibraryEntry>& columns) {
  using Constants = ElasticConstants;
  const auto add = [&](FigureName name, Shown shown, auto... path) {
    columns.add(std::move(name), std::move(shown), &LibraryEntry::material, &Material::elasticity, path...);
  };
  add({"", "youngs_modulus_pa", "Pa", "E1, E2, E3"}, {}, &Constants::youngs_modulus);
  for (const std::size_t axis : {0u, 1u})
    add({}, {fmt::format("E{}", axis + 1), 11, in_pascals},
        [axis](const Constants& of) { return of.youngs_modulus[axis]; });
  add({}, {"G12", 11, in_pascals}, &Constants::G12);
  add({}, {"nu12", 7}, &Constants::nu12);
  add({}, {"nu23", 7}, &Constants::nu23);
  add({"", "poisson_ratio", "", "nu12, nu13, nu23"}, {}, [](const Constants& of) {
    return std::array{of.nu12, of.nu13, of.nu23};
  });
  add({"", "shear_modulus_pa", "Pa", "G12, G13, G23"}, {}, [](const Constants& of) {
    return std::array{of.G12, of.G13, of.G23};
  });
  add({"", "bulk_modulus_pa", "Pa", "of uniform stress"}, {}, bulk_modulus);
  add({"", "anisotropy", "", "E1 over E2"},
      {"E1/E2", 9, [](double ratio) { return fmt::format("{:.3g}", ratio); }}, anisotropy_of);
  columns.add_rows({"", "nearly_incompressible", "", "where that is valid"}, columns_of_incompressible(),
                   &LibraryEntry::material, &Material::elasticity, nearly_incompressible);
  add({"", "stiffness_pa", "Pa", "order 11 22 33 23 13 12"}, {}, rows_of);
  add({"", "stiffness_eigenvalues_pa", "Pa", "of that matrix"}, {}, [](const Constants& of) {
    const auto values = eigenvalues(stiffness(of));
    return std::vector<double>(values.begin(), values.end());
  });
}

const ResultTable<LibraryEntry>& columns_of_library() {
  static const ResultTable<LibraryEntry> table([](ResultTable<LibraryEntry>& columns) {
    using Entry = LibraryEntry;
    constexpr auto material = &Entry::material;
    columns.add({"", "name", "", "of the tissue; axis 1 is the fibre"}, {"material (axis 1 = fibre)", -32},
                material, &Material::name);
    columns.add({"", "title", "", "what it is"}, &Entry::title);
    columns.add({"", "state", "", "passive, active, excised, ..."}, &Entry::state);
    columns.add({"", "species", "", "whose it was"}, &Entry::species);
    columns.add({"", "source", "", "author, year, identifier"}, &Entry::source);
    columns.add({"", "uncertainty", "", "as the source states it"}, &Entry::uncertainty);
    columns.add({"", "note", "", "what was derived, assumed or left out"}, &Entry::note);
    columns.add({"", "verified", "", "the numbers were read in the source"}, &Entry::verified);
    columns.add({"", "density_kg_m3", "kg/m^3", "at rest"}, material, &Material::density);
    add_constants(columns);
    columns
        .add_row({"", "limits", "", "of links, where the source has them"}, columns_of_limits(), material,
                 &Material::limits)
        .omitted();
    columns
        .add_row({"", "damage", "", "limits beyond which it fails"}, columns_of_damage(), material,
                 &Material::damage)
        .omitted();
    columns.add({}, {"source"},
                [](const Entry& of) { return (of.verified ? "" : "UNVERIFIED; ") + of.source; });
  });
  return table;
}

/// A label followed by text, wrapped to the screen.
std::string wrapped(std::string_view label, std::string_view words) {
  constexpr std::size_t indent = 13, width = 110;
  std::string text = fmt::format("{:<{}}", label, indent);
  for (std::size_t line = indent; !words.empty();) {
    const std::string_view word = words.substr(0, words.find(' '));
    words.remove_prefix(std::min(words.size(), word.size() + 1));
    if (line > indent && line + 1 + word.size() > width) {
      text += fmt::format("\n{:{}}", "", indent);
      line = indent;
    }
    text += (line > indent ? " " : "") + std::string(word);
    line += word.size() + (line > indent ? 1 : 0);
  }
  return text + "\n";
}

/// One number if all axes are equal, else three.
std::string ratios(const std::array<double, 3>& values) {
  return values[0] == values[1] && values[0] == values[2] ? fmt::format("{:.4g}", values[0])
                                                          : fmt::format("{:.4g}", fmt::join(values, " "));
}

/// The law and its parameters, in SI units.
std::string law_in_words(Law law) {
  std::string text;
  for (const auto& [name, value] : parameters(law))
    text += fmt::format("{}{} {:.4g}", text.empty() ? "" : ", ", name, *value);
  return wrapped("law", fmt::format("{}: {} (Pa or ratios); at rest:", name_of(law), text));
}

/// Failure data, and the result for `[limits] from = "failure"`.
std::string damage_in_words(const Damage& damage) {
  const NeighbourLimits limits = limits_before_failure(damage);
  const auto how = [](bool is_known) { return is_known ? "" : " (follows from the stretch)"; };
  return wrapped("damage", fmt::format("stretch {}{}: {} ({})", ratios(limits.stretch),
                                       damage.verified ? "" : " (UNVERIFIED)", damage.of, damage.source)) +
         fmt::format("{:13}compress {}{}, shear 12 {:.4g}{}: limits by from = \"failure\"\n", "",
                     ratios(limits.compress), how(damage.compress.has_value()), limits.shear[0][1],
                     how(damage.shear.has_value()));
}

std::string details(const LibraryEntry& entry) {
  const Material& m = entry.material;
  const ElasticConstants& e = m.elasticity;
  const Matrix6 C = stiffness(e);
  std::string text = fmt::format("{}\n{}\n\n", m.name, entry.title);
  for (const auto& [label, value] :
       {std::pair{"state", &entry.state}, std::pair{"species", &entry.species},
        std::pair{"source", &entry.source}, std::pair{"uncertainty", &entry.uncertainty},
        std::pair{"note", &entry.note}})
    if (!value->empty())
      text += wrapped(label, *value);
  text += fmt::format("{:<12} {}\n", "verified",
                      entry.verified ? "yes" : "NO: do not quote these numbers as fact");
  text += m.law ? "\n" + law_in_words(*m.law) : "\n";
  text += fmt::format("E1 E2 E3     {}  {}  {}\n", in_pascals(e.youngs_modulus[0]),
                      in_pascals(e.youngs_modulus[1]), in_pascals(e.youngs_modulus[2]));
  text += fmt::format("nu12 13 23   {:.4g}  {:.4g}  {:.4g}\n", e.nu12, e.nu13, e.nu23);
  text += fmt::format("G12 13 23    {}  {}  {}\n", in_pascals(e.G12), in_pascals(e.G13), in_pascals(e.G23));
  text += fmt::format("density      {:.4g} kg/m^3\n\nderived\n", m.density);
  text += fmt::format("bulk modulus {} (uniform stress)\nE1 / E2      {:.4g}\n", in_pascals(bulk_modulus(e)),
                      anisotropy_of(e));
  for (const NearlyIncompressible& set : nearly_incompressible(e))
    text += fmt::format("nu12 13 23   {:.4g}  at a bulk modulus of {}, the same E\n",
                        fmt::join(set.poisson_ratio, "  "), in_pascals(set.bulk_modulus));
  text += "stiffness [Pa], order 11 22 33 23 13 12\n";
  for (int i = 0; i < 6; ++i)
    text += fmt::format("  {:>11.4g}{:>12.4g}{:>12.4g}{:>12.4g}{:>12.4g}{:>12.4g}\n", C(i, 0), C(i, 1),
                        C(i, 2), C(i, 3), C(i, 4), C(i, 5));
  const auto values = eigenvalues(C);
  text += fmt::format("its eigenvalues [Pa]  {:.4g}\n", fmt::join(values.begin(), values.end(), "  "));
  if (m.limits)
    text += fmt::format("limits       stretch {}, compress {}, shear 12 {} (ratios to rest; axes 1, 2, 3)\n",
                        fmt::join(m.limits->stretch, " "), fmt::join(m.limits->compress, " "),
                        m.limits->shear[0][1]);
  return text + (m.damage ? damage_in_words(*m.damage) : "");
}

} // namespace

int materials_command(const MaterialsOptions& options) {
  const ResultTable<LibraryEntry>& columns = columns_of_library();
  prepare_file("--json", options.json);
  if (options.name == "library") {
    deliver(options.json ? json_text(columns.json_rows(material_library()))
                         : columns.text(material_library()),
            options.json);
    return exit_done;
  }
  const LibraryEntry* entry = find_material(options.name);
  if (!entry && similar_material_names(options.name).empty())
    throw UsageError(fmt::format(
        "expected a file, or a tissue of the library (maille check library lists them), found \"{}\"",
        options.name));
  if (!entry)
    throw UsageError(fmt::format("expected a file, or a tissue of the library, found \"{}\"; the nearest: {}",
                                 options.name, fmt::join(similar_material_names(options.name), ", ")));
  deliver(options.json ? json_text(columns.json(*entry)) : details(*entry), options.json);
  return exit_done;
}

} // namespace maille::studies
