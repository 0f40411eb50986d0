/// Reads neighbour limits and failure data from a TOML table.

#include "maille/materials/toml_reader.hpp"

#include <fmt/format.h>

#include <utility>

namespace maille {
namespace {

bool is_within(TableReader& table, std::string_view key, double value) {
  const auto wanted = wanted_in_range("material", key, value);
  if (wanted)
    table.fault(key, *wanted, fmt::format("{}", value));
  return !wanted;
}

/// One ratio for all three axes, or three.
void read_ratios(TableReader& table, std::string_view key, std::array<double, 3>& into) {
  const auto values = table.quantities(key, Dimension::dimensionless, true);
  if (!values)
    return;
  const bool one_for_all = !table.find(key)->is_array();
  for (const double value : *values) {
    if (!is_within(table, key, value) && one_for_all) {
      break; // a single number gives a single fault
    }
  }
  into = *values;
}

void read_shear_row(TableReader& table, std::size_t axis, const toml::array& row, NeighbourLimits& limits) {
  for (std::size_t b = 0; b < 3; ++b) {
    const std::string path = fmt::format("{}[{}][{}]", table.path_of("shear"), axis, b);
    const auto value = read_quantity(row[b], path, Dimension::dimensionless, table.faults());
    if (!value || axis == b) {
      continue; // the diagonal is unused
    }
    if (const auto wanted = wanted_in_range("material", "shear", *value))
      table.faults().add(line_of(row[b]), path, *wanted, describe(row[b]));
    limits.shear[axis][b] = *value;
  }
}

bool is_three_by_three(const toml::array& rows) {
  if (rows.size() != 3)
    return false;
  for (const toml::node& row : rows) {
    const auto* const list = row.as_array();
    if (!list || list->size() != 3)
      return false;
  }
  return true;
}

void read_shear(TableReader& table, NeighbourLimits& limits) {
  const toml::node* const node = table.find("shear");
  if (!node)
    return;
  if (const auto* const rows = node->as_array()) {
    if (!is_three_by_three(*rows)) {
      table.fault("shear", "one ratio >= 0, or three rows of three ratios: [link axis][component]");
      return;
    }
    for (std::size_t a = 0; a < 3; ++a)
      read_shear_row(table, a, *(*rows)[a].as_array(), limits);
    return;
  }
  const auto value = table.quantity("shear", Dimension::dimensionless);
  if (value && is_within(table, "shear", *value)) {
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b)
        limits.shear[a][b] = a == b ? 0 : *value;
    }
  }
}

} // namespace

std::optional<NeighbourLimits> read_neighbour_limits(TableReader& table) {
  bool any = false;
  for (const std::string_view key : {"stretch", "compress", "shear"})
    any = table.find(key) != nullptr || any;
  if (!any)
    return std::nullopt;
  const std::size_t before = table.faults().size();
  NeighbourLimits limits;
  read_ratios(table, "stretch", limits.stretch);
  read_ratios(table, "compress", limits.compress);
  read_shear(table, limits);
  return table.faults().size() == before ? std::optional(limits) : std::nullopt;
}

std::optional<Damage> read_damage(TableReader& table) {
  const std::size_t before = table.faults().size();
  Damage damage;
  damage.stretch = table.three("stretch").value_or(damage.stretch);
  NeighbourLimits others;
  read_ratios(table, "compress", others.compress);
  read_shear(table, others);
  if (table.has("compress"))
    damage.compress = others.compress;
  if (table.has("shear"))
    damage.shear = others.shear;
  table.read("of", damage.of);
  table.read("source", damage.source);
  table.read("verified", damage.verified);
  return table.faults().size() == before ? std::optional(std::move(damage)) : std::nullopt;
}

} // namespace maille
