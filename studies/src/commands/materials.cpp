#include "cli/commands.hpp"
#include "text.hpp"

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

/// What stands behind every derived table: the Poisson ratios of a nearly incompressible tissue of these
/// moduli.
struct NearlyIncompressible {
  double bulk_modulus = 0; ///< [Pa]
  std::array<double, 3> poisson_ratio{};
};

/// At bulk moduli that linear elements (20 largest shear moduli) and those that do not lock (100) cope with.
/// Left out where the material would not be valid: then its moduli do not go with so stiff a volume.
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

nlohmann::ordered_json derived_json(const ElasticConstants& e) {
  nlohmann::ordered_json sets = nlohmann::ordered_json::array();
  for (const NearlyIncompressible& set : nearly_incompressible(e))
    sets.push_back({{"bulk_modulus_pa", set.bulk_modulus}, {"poisson_ratio", set.poisson_ratio}});
  return sets;
}

nlohmann::ordered_json entry_json(const LibraryEntry& entry) {
  const Material& m = entry.material;
  const ElasticConstants& e = m.elasticity;
  const Matrix6 C = stiffness(e);
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (int i = 0; i < 6; ++i)
    rows.push_back(std::vector<double>{C(i, 0), C(i, 1), C(i, 2), C(i, 3), C(i, 4), C(i, 5)});
  const auto values = eigenvalues(C);
  nlohmann::ordered_json out{{"name", m.name},
                             {"title", entry.title},
                             {"state", entry.state},
                             {"species", entry.species},
                             {"source", entry.source},
                             {"uncertainty", entry.uncertainty},
                             {"note", entry.note},
                             {"verified", entry.verified},
                             {"density_kg_m3", m.density},
                             {"youngs_modulus_pa", e.youngs_modulus},
                             {"poisson_ratio", {e.nu12, e.nu13, e.nu23}},
                             {"shear_modulus_pa", {e.G12, e.G13, e.G23}},
                             {"bulk_modulus_pa", bulk_modulus(e)},
                             {"anisotropy", e.youngs_modulus[0] / e.youngs_modulus[1]},
                             {"nearly_incompressible", derived_json(e)},
                             {"stiffness_pa", rows},
                             {"stiffness_eigenvalues_pa", std::vector<double>(values.begin(), values.end())}};
  if (m.limits)
    out["limits"] = {
        {"stretch", m.limits->stretch}, {"compress", m.limits->compress}, {"shear", m.limits->shear}};
  if (const auto& damage = m.damage) {
    const NeighbourLimits limits = limits_before_failure(*damage);
    out["damage"] = {{"stretch", limits.stretch},
                     {"compress", limits.compress},
                     {"shear", limits.shear},
                     {"compress_is_derived", !damage->compress},
                     {"shear_is_derived", !damage->shear},
                     {"of", damage->of},
                     {"source", damage->source},
                     {"verified", damage->verified}};
  }
  return out;
}

std::string overview() {
  std::string text =
      fmt::format("{:<32}{:>12}{:>12}{:>12}{:>8}{:>8}{:>10}  {}\n", "material (axis 1 = fibre)", "E1", "E2",
                  "G12", "nu12", "nu23", "E1/E2", "source");
  for (const LibraryEntry& entry : material_library()) {
    const ElasticConstants& e = entry.material.elasticity;
    text += fmt::format("{:<32}{:>12}{:>12}{:>12}{:>8.4g}{:>8.4g}{:>10.3g}  {}{}\n", entry.material.name,
                        in_pascals(e.youngs_modulus[0]), in_pascals(e.youngs_modulus[1]), in_pascals(e.G12),
                        e.nu12, e.nu23, e.youngs_modulus[0] / e.youngs_modulus[1],
                        entry.verified ? "" : "UNVERIFIED; ", entry.source);
  }
  return text;
}

/// A label and words after it, in lines that fit on a screen.
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

/// One number where all axes have the same, else three.
std::string ratios(const std::array<double, 3>& values) {
  return values[0] == values[1] && values[0] == values[2] ? fmt::format("{:.4g}", values[0])
                                                          : fmt::format("{:.4g}", fmt::join(values, " "));
}

/// Where it fails, and what follows for `[limits] from = "failure"`.
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
  text += fmt::format("\nE1 E2 E3     {}  {}  {}\n", in_pascals(e.youngs_modulus[0]),
                      in_pascals(e.youngs_modulus[1]), in_pascals(e.youngs_modulus[2]));
  text += fmt::format("nu12 13 23   {:.4g}  {:.4g}  {:.4g}\n", e.nu12, e.nu13, e.nu23);
  text += fmt::format("G12 13 23    {}  {}  {}\n", in_pascals(e.G12), in_pascals(e.G13), in_pascals(e.G23));
  text += fmt::format("density      {:.4g} kg/m^3\n\nderived\n", m.density);
  text += fmt::format("bulk modulus {} (uniform stress)\nE1 / E2      {:.4g}\n", in_pascals(bulk_modulus(e)),
                      e.youngs_modulus[0] / e.youngs_modulus[1]);
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
  if (options.name.empty()) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const LibraryEntry& entry : material_library())
      all.push_back(entry_json(entry));
    deliver(options.json ? json_text(all) : overview(), options.json);
    return exit_done;
  }
  const LibraryEntry* entry = find_material(options.name);
  if (!entry && similar_material_names(options.name).empty())
    throw UsageError(
        fmt::format("materials: no tissue called \"{}\" (maille materials lists all)", options.name));
  if (!entry)
    throw UsageError(fmt::format("materials: no tissue called \"{}\"; the nearest: {}", options.name,
                                 fmt::join(similar_material_names(options.name), ", ")));
  deliver(options.json ? json_text(entry_json(*entry)) : details(*entry), options.json);
  return exit_done;
}

} // namespace maille::studies
