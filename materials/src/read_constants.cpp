/// Reads elastic constants from a TOML table: detects which of the three forms it has, and validates the
/// numbers; or a law of large strain and its parameters.

#include "maille/materials/material.hpp"
#include "maille/materials/toml_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

namespace maille {
namespace {

struct Form {
  std::string_view name;
  std::vector<std::string_view> keys;
};

const Form isotropic{"isotropic", {"youngs_modulus", "poisson_ratio"}},
    isotropic_by_symbols{"isotropic", {"E", "nu"}},
    transversely_isotropic{"transversely isotropic",
                           {"E_fibre", "E_cross", "G_fibre", "nu_fibre", "nu_cross"}},
    orthotropic{"orthotropic", {"E", "nu", "G"}};

/// The possible forms of a table: if E is one number and there is no G, E and nu are isotropic.
std::array<const Form*, 3> forms_of(TableReader& table) {
  const toml::node* const E = table.has("E") ? table.find("E") : nullptr;
  const bool is_one_number = E && !E->is_array() && !table.has("G");
  return {&isotropic, &transversely_isotropic, is_one_number ? &isotropic_by_symbols : &orthotropic};
}

constexpr std::string_view wanted_forms =
    "all keys of one form: { youngs_modulus, poisson_ratio } or { E, nu } (isotropic), { E_fibre, E_cross, "
    "G_fibre, nu_fibre, nu_cross } (transversely isotropic) or { E = [E1, E2, E3], nu = [nu12, nu13, nu23], "
    "G = [G12, G13, G23] } (orthotropic)";

/// Largest left side of an inequality for which the fault is taken as an intended incompressible material,
/// and advice is given.
constexpr double near_limit = 1e-3;

constexpr std::string_view incompressible_advice =
    " (at the limit the material is incompressible and its stiffness infinite: take a slightly smaller "
    "{}, such as {})";

std::vector<std::string_view> keys_present(const TableReader& table, const Form& form) {
  std::vector<std::string_view> present;
  for (const std::string_view key : form.keys) {
    if (table.has(key))
      present.push_back(key);
  }
  return present;
}

/// Detects the form by its keys; nothing and a fault if there are no keys, keys of two forms, or too few.
/// Marks the keys of all forms with keys as known; without any, those of all forms, so that a misspelling is
/// reported with the right list.
const Form* detect_form(TableReader& table) {
  std::vector<std::string_view> present;
  const Form* detected = nullptr;
  std::size_t touched = 0;
  for (const Form* const form : forms_of(table)) {
    const std::vector<std::string_view> keys = keys_present(table, *form);
    if (!keys.empty()) {
      detected = form;
      ++touched;
      present.insert(present.end(), keys.begin(), keys.end());
    }
  }
  for (const Form* const form : forms_of(table)) {
    if (touched == 0 || !keys_present(table, *form).empty()) {
      for (const std::string_view key : form->keys)
        table.find(key);
    }
  }
  if (touched == 1 && present.size() == detected->keys.size())
    return detected;
  // A label with its own fibre: one fault for one cause.
  if (touched == 0 && (table.has("material") || table.has("fibre"))) {
    table.find("material");
    table.find("fibre");
    table.fault(
        table.has("fibre") ? "fibre" : "material",
        "a material: a name of the library, or its constants; fibres of all labels are one `fibre` of "
        "the specimen, such as { tensor_image }",
        "a table around them");
    return nullptr;
  }
  table.fault("", std::string(wanted_forms),
              touched == 0   ? "none of these keys"
              : touched == 1 ? fmt::format("only {}", fmt::join(present, ", "))
                             : fmt::format("keys of {} forms: {}", touched, fmt::join(present, ", ")));
  return touched == 1 ? detected : nullptr;
}

/// Checks the remaining inequalities, with one fault each.
bool is_positive_definite(TableReader& table, const ElasticConstants& constants) {
  const std::vector<BrokenRule> violated = broken_rules(constants);
  for (const BrokenRule& inequality : violated)
    table.fault(table.has(inequality.key) ? inequality.key : "", inequality.expected, inequality.found);
  return violated.empty();
}

std::optional<ElasticConstants> read_isotropic(TableReader& table, std::string_view modulus,
                                               std::string_view ratio) {
  const auto E = table.number(modulus);
  const auto nu = table.number(ratio);
  const bool is_positive = E && *E > 0;
  if (E && !is_positive)
    table.fault(modulus, fmt::format("{} > 0", modulus));
  constexpr double round_off = 1e-9;
  if (nu && !(*nu > -1 + round_off && *nu < 0.5 - round_off)) {
    std::string expected = fmt::format("-1 < {} < 0.5", ratio);
    if (*nu > -1 && *nu < 0.5)
      expected += fmt::format(", by {:g} at least", round_off);
    if (std::abs(*nu - 0.5) < near_limit)
      expected += fmt::format(incompressible_advice, ratio, "0.49");
    table.fault(ratio, expected);
    return std::nullopt;
  }
  return is_positive && nu ? std::optional(ElasticConstants::isotropic(*E, *nu)) : std::nullopt;
}

/// `rest` times (1 + nu_cross) is the determinant of the scaled 3 x 3 block of the compliance.
bool fibre_ratio_is_valid(TableReader& table, double E_fibre, double E_cross, double nu_fibre,
                          double nu_cross) {
  const double rest = 1 - nu_cross - 2 * nu_fibre * nu_fibre * E_cross / E_fibre;
  constexpr double round_off = 1e-9;
  if (rest > round_off)
    return true;
  std::string expected = "1 - nu_cross - 2 nu_fibre^2 E_cross / E_fibre > 0";
  if (std::abs(rest) < near_limit) {
    expected += fmt::format(incompressible_advice, "nu_fibre or nu_cross",
                            fmt::format("nu_fibre = {:.3g}", 0.98 * nu_fibre));
  }
  table.fault("nu_fibre", expected,
              fmt::format("{:.4g} for nu_fibre = {}, nu_cross = {}, E_cross / E_fibre = {:.6g}", rest,
                          nu_fibre, nu_cross, E_cross / E_fibre));
  return false;
}

std::optional<ElasticConstants> read_transversely_isotropic(TableReader& table) {
  const auto E_fibre = table.number("E_fibre");
  const auto E_cross = table.number("E_cross");
  const auto G_fibre = table.number("G_fibre");
  const auto nu_fibre = table.number("nu_fibre");
  const auto nu_cross = table.number("nu_cross");
  bool valid = true;
  if (E_fibre && E_cross && nu_fibre && nu_cross)
    valid = fibre_ratio_is_valid(table, *E_fibre, *E_cross, *nu_fibre, *nu_cross);
  if (!valid || !E_fibre || !E_cross || !G_fibre || !nu_fibre || !nu_cross)
    return std::nullopt;
  return ElasticConstants::transversely_isotropic(*E_fibre, *E_cross, *G_fibre, *nu_fibre, *nu_cross);
}

std::optional<ElasticConstants> read_orthotropic(TableReader& table) {
  const auto E = table.three("E");
  const auto nu = table.three("nu");
  const auto G = table.three("G");
  if (!E || !nu || !G)
    return std::nullopt;
  return ElasticConstants{*E, (*nu)[0], (*nu)[1], (*nu)[2], (*G)[0], (*G)[1], (*G)[2]};
}

} // namespace

std::optional<ElasticConstants> read_elastic_constants(TableReader& table) {
  const std::size_t before = table.faults().size();
  const Form* const form = detect_form(table);
  if (!form)
    return std::nullopt;
  // Reads all present keys even if one is missing, so that their faults are reported too.
  const auto constants = form == &transversely_isotropic ? read_transversely_isotropic(table)
                         : form == &orthotropic          ? read_orthotropic(table)
                                                : read_isotropic(table, form->keys[0], form->keys[1]);
  if (!constants || !is_positive_definite(table, *constants))
    return std::nullopt;
  return table.faults().size() == before ? constants : std::nullopt;
}

namespace {

/// One fault for all linear constants beside a law; neo_hookean uses E and nu.
void refuse_linear_constants(TableReader& table, bool takes_E_and_nu) {
  std::vector<std::string_view> beside;
  for (const Form& form : {isotropic, transversely_isotropic, orthotropic})
    for (const std::string_view key : keys_present(table, form))
      if (table.find(key) && !(takes_E_and_nu && (key == "E" || key == "nu")))
        beside.push_back(key);
  if (!beside.empty())
    table.fault(beside.front(), "no elastic constants beside a law, which has its own at rest",
                fmt::format("{}", fmt::join(beside, ", ")));
}

/// Reads E and nu of the law.
void read_parameters(TableReader& table, NeoHookean& law) {
  table.require("E", "Young's modulus of the law, a pressure");
  table.require("nu", "Poisson's ratio of the law");
  const auto constants = read_isotropic(table, "E", "nu");
  if (constants)
    law = {constants->G12, 2 * constants->G12 * constants->nu12 / (1 - 2 * constants->nu12)};
}

template<class Other>
void read_parameters(TableReader& table, Other& of) {
  Law law = of;
  std::string names;
  for (const auto& [name, place] : parameters(law))
    names += (names.empty() ? "" : ", ") + std::string(name);
  table.require("parameters", fmt::format("the parameters of {}: {{ {} }}", name_of(law), names));
  const toml::table* const values = table.subtable("parameters");
  if (!values)
    return;
  TableReader reader(*values, table.path_of("parameters"), table.faults(), "law");
  const std::size_t before = table.faults().size();
  for (const auto& [name, place] : parameters(law))
    reader.read(name, *place);
  reader.finish();
  if (table.faults().size() == before)
    for (const BrokenRule& rule : broken_rules(law))
      reader.fault(rule.key, rule.expected, rule.found);
  of = std::get<Other>(law);
}

} // namespace

bool read_mechanics(TableReader& table, Material& material) {
  const std::size_t before = table.faults().size();
  if (!table.has("law")) {
    const auto constants = read_elastic_constants(table);
    material.elasticity = constants.value_or(material.elasticity);
    return constants.has_value();
  }
  const auto word = table.word("law");
  refuse_linear_constants(table, !word || *word == 0);
  if (!word) {
    table.find("parameters");
    return false;
  }
  std::array<Law, 5> laws{NeoHookean{}, MooneyRivlin{}, Guccione{}, HolzapfelGasserOgden{}, Muscle{}};
  Law& law = laws[*word];
  std::visit([&](auto& of) { read_parameters(table, of); }, law);
  if (table.faults().size() > before || !is_positive_definite(table, rest_constants(law)))
    return false;
  material.law = law;
  material.elasticity = rest_constants(law);
  return true;
}

} // namespace maille
