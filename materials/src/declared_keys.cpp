/// The declarations of keys in scene/keys.toml, and the getters that use them.

#include "maille/materials/toml_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace maille {

std::string_view keys_toml(); // generated from scene/keys.toml

namespace {

const toml::table& declared_tables() {
  static const toml::table tables = toml::parse(keys_toml());
  return tables;
}

/// Declaration of a key of a table in scene/keys.toml. @throws std::logic_error if it is missing
const toml::table& declaration(std::string_view table, std::string_view key) {
  const toml::table* const keys = declared_tables()[table].as_table();
  const toml::table* const found = keys && key != "_" ? (*keys)[key].as_table() : nullptr;
  if (found)
    return *found;
  const auto also = keys ? (*keys)["_"]["also"].value<std::string_view>() : std::nullopt;
  if (!also)
    throw std::logic_error(fmt::format("scene/keys.toml has no {}.{}", table, key));
  return declaration(*also, key);
}

Dimension declared_dimension(const toml::table& key) {
  constexpr std::array<std::string_view, 9> names{
      "", "length", "pressure", "density", "angle", "acceleration", "time", "force", "foundation"};
  return static_cast<Dimension>(std::ranges::find(names, key["unit"].value_or(std::string_view{})) -
                                names.begin());
}

/// Expected range of a key, for faults.
std::string wanted_of(const toml::table& key) {
  if (const auto wanted = key["wanted"].value<std::string>())
    return *wanted;
  const auto least = key["least"].value<double>(), most = key["most"].value<double>();
  const bool is_whole = key["type"].value_or(std::string_view{}) == "integer";
  const std::string all = describe(declared_dimension(key)),
                    what = is_whole ? "a whole number" : all.substr(0, all.find(" such as"));
  if (least && most)
    return fmt::format("{} from {} to {}", what, *least, *most);
  return least ? fmt::format("{} >= {}", what, *least)
               : fmt::format("{} > {}", what, key["above"].value_or(0.0));
}

bool is_within(const toml::table& key, double value) {
  const double infinity = std::numeric_limits<double>::infinity();
  return std::isfinite(value) && value >= key["least"].value_or(-infinity) &&
         value <= key["most"].value_or(infinity) && value > key["above"].value_or(-infinity) &&
         value < key["below"].value_or(infinity);
}

/// Default of an absent number.
std::optional<double> default_of(const toml::table& key) {
  const auto text = key["default"].value<std::string_view>();
  return text ? parse_quantity(*text, declared_dimension(key)) : key["default"].value<double>();
}

} // namespace

std::optional<std::string> wanted_in_range(std::string_view table, std::string_view key, double value) {
  const toml::table& declared = declaration(table, key);
  return is_within(declared, value) ? std::nullopt : std::optional(wanted_of(declared));
}

std::string TableReader::missing(std::string_view key) const {
  const toml::table& declared = declaration(declared_, key);
  const std::string_view expected = said(key, declared["required"].is_string() ? "required" : "missing");
  return expected.empty() ? describe(declared_dimension(declared)) : std::string(expected);
}

const toml::node* TableReader::require(std::string_view key) {
  return require(key, missing(key));
}

/// Entry of the key's own declaration, else of its type.
std::string_view TableReader::said(std::string_view key, std::string_view what) const {
  const toml::table& declared = declaration(declared_, key);
  const auto type = declared["type"].value_or(std::string_view{});
  const toml::table& all = declared_tables();
  return declared[what].value<std::string_view>().value_or(
      all["types"][type][what].value<std::string_view>().value_or(
          all[type]["_"][what].value_or(std::string_view{})));
}

/// True if the key is absent; adds a fault if it is required.
bool TableReader::is_missed(std::string_view key) {
  if (find(key))
    return false;
  if (declaration(declared_, key).contains("required"))
    require(key);
  return true;
}

bool TableReader::is_in_range(std::string_view key, double value) {
  const auto wanted = wanted_in_range(declared_, key, value);
  if (wanted)
    fault(key, *wanted);
  return !wanted;
}

std::optional<double> TableReader::number(std::string_view key) {
  const toml::table& declared = declaration(declared_, key);
  if (is_missed(key))
    return default_of(declared);
  const bool is_plain = declared["plain"].value_or(false);
  if (is_plain && !find(key)->is_number()) {
    fault(key, wanted_of(declared));
    return std::nullopt;
  }
  const auto value = is_plain ? find(key)->value<double>() : quantity(key, declared_dimension(declared));
  return value && is_in_range(key, *value) ? value : std::nullopt;
}

std::optional<std::int64_t> TableReader::whole(std::string_view key) {
  const toml::table& declared = declaration(declared_, key);
  if (is_missed(key))
    return declared["default"].value<std::int64_t>();
  return integer(key, declared["least"].value_or(std::numeric_limits<std::int64_t>::min()),
                 declared["most"].value_or(std::numeric_limits<std::int64_t>::max()));
}

std::vector<std::string_view> TableReader::words(std::string_view key) const {
  const toml::table& declared = declaration(declared_, key);
  const auto type = declared["type"].value_or(std::string_view{});
  const toml::array* list = declared["words"].as_array();
  std::vector<std::string_view> words;
  for (const toml::node& word : list ? *list : *declared_tables()["types"][type]["words"].as_array())
    words.push_back(*word.value<std::string_view>());
  return words;
}

std::optional<int> TableReader::word(std::string_view key) {
  auto chosen = choice(key);
  if (!chosen && !has(key))
    chosen = declaration(declared_, key)["default"].value<std::string>();
  if (!chosen)
    return std::nullopt;
  const std::vector<std::string_view> all = words(key);
  return static_cast<int>(std::ranges::find(all, *chosen) - all.begin());
}

std::optional<std::array<double, 3>> TableReader::three(std::string_view key) {
  const toml::table& declared = declaration(declared_, key);
  const bool one_for_all = declared["type"].value_or(std::string_view{}) == "ratios";
  if (is_missed(key))
    return std::nullopt;
  const auto values = quantities(key, declared_dimension(declared), one_for_all);
  for (std::size_t a = 0; values && a < 3; ++a)
    if (!is_within(declared, (*values)[a])) {
      fault(key, wanted_of(declared));
      return std::nullopt;
    }
  return values;
}

std::optional<TableReader> TableReader::open(std::string_view key) {
  const toml::table* const section = is_missed(key) ? nullptr : subtable(key);
  return section ? std::optional(TableReader(*section, path_of(key), *faults_, declared_under(key)))
                 : std::nullopt;
}

namespace {

template<class Value, class Into>
bool put(const std::optional<Value>& value, Into& into) {
  into = value ? static_cast<Into>(*value) : into;
  return value.has_value();
}

} // namespace

bool TableReader::read(std::string_view key, double& into) {
  return put(number(key), into);
}

bool TableReader::read(std::string_view key, std::int64_t& into) {
  return put(whole(key), into);
}

bool TableReader::read(std::string_view key, int& into) {
  return put(whole(key), into);
}

bool TableReader::read(std::string_view key, bool& into) {
  if (is_missed(key))
    return false;
  const auto* const truth = find(key)->as_boolean();
  if (!truth)
    fault(key, "true or false");
  into = truth ? truth->get() : into;
  return truth != nullptr;
}

bool TableReader::read(std::string_view key, std::string& into) {
  return !is_missed(key) && put(text(key), into);
}

Dimension TableReader::dimension(std::string_view key) const {
  return declared_dimension(declaration(declared_, key));
}

std::string_view TableReader::declared_under(std::string_view key) const {
  if (declared_.empty())
    return {};
  const auto type = declaration(declared_, key)["type"];
  return type[0].value<std::string_view>().value_or(type.value_or(std::string_view{}));
}

} // namespace maille
