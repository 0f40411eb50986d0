#include "maille/materials/toml_reader.hpp"

#include "maille/materials/fault.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace maille {

namespace {

/// True for texts such as "2" or "1e-3": a number and no unit.
bool has_no_unit(const toml::node& node) {
  const auto* const string = node.as_string();
  if (!string)
    return true;
  const std::string& text = string->get();
  const std::size_t last = text.find_last_not_of(" \t");
  return last != std::string::npos && (text[last] == '.' || (text[last] >= '0' && text[last] <= '9')) &&
         parse_quantity(text, Dimension::dimensionless).has_value();
}

/// Applies the file's unit to a length or an angle without a unit; without `units` only 0 is allowed.
/// @param value in SI units, if no unit applies @return in SI units; nothing and a fault for unknown units
std::optional<double> in_units_of_the_file(const toml::node& node, double value, const std::string& path,
                                           Dimension dimension, FaultList& faults) {
  const bool is_length = dimension == Dimension::length;
  if ((!is_length && dimension != Dimension::angle) || value == 0 || !has_no_unit(node))
    return value;
  const std::optional<double>& factor = is_length ? faults.units.length : faults.units.angle;
  if (factor)
    return value * *factor;
  const char* const unit = is_length ? "mm" : "deg";
  const char* const si = is_length ? "m" : "rad";
  faults.add(line_of(node), path,
             fmt::format("{0} with its unit, such as \"{1:g} {2}\" or \"{1:g} {3}\" (or, for all numbers of "
                         "the file, a first "
                         "line units = \"{2}\" or \"{3}\")",
                         is_length ? "a length" : "an angle", value, si, unit),
             describe(node) + ", which has none");
  return std::nullopt;
}

/// Scans TOML like a lexer; the parser reports invalid TOML.
class KeyWalk {
public:
  KeyWalk(std::string_view text, int most) : text_(text), most_(most) {}

  std::optional<int> line_of_deep_key() {
    while (at_ < text_.size()) {
      step(text_[at_]);
      if (dots_ > most_)
        return line_;
    }
    return std::nullopt;
  }

private:
  void step(char c) {
    ++at_;
    if (c == '"' || c == '\'')
      skip_string(c);
    else if (c == '#')
      at_ = std::min(text_.find('\n', at_), text_.size());
    else if (c == '.')
      ++dots_;
    else if (c == '{' || c == '[')
      around_.push_back(dots_);
    else if (c == '}' || c == ']')
      leave();
    else if (c == ',' || c == '\n')
      dots_ = around_.empty() ? 0 : around_.back();
    line_ += c == '\n';
  }
  void leave() {
    dots_ = around_.empty() ? 0 : around_.back();
    if (!around_.empty())
      around_.pop_back();
  }
  /// Skips from after its first quote to after its last.
  void skip_string(char quote) {
    const bool is_long = text_.substr(at_, 2) == std::string_view(quote == '"' ? "\"\"" : "''");
    at_ += is_long ? 2 : 0;
    for (; at_ < text_.size() && (is_long || text_[at_] != '\n'); ++at_) {
      line_ += text_[at_] == '\n';
      if (quote == '"' && text_[at_] == '\\') {
        ++at_; // an escaped character is no end
        line_ += at_ < text_.size() && text_[at_] == '\n';
      } else if (text_[at_] == quote && (!is_long || is_end(quote))) {
        at_ += is_long ? 3 : 1;
        for (int more = 0; is_long && more < 2 && at_ < text_.size() && text_[at_] == quote; ++more)
          ++at_; // up to two quotes before the last three belong to the string
        return;
      }
    }
  }
  bool is_end(char quote) const {
    return text_.size() - at_ >= 3 && text_[at_ + 1] == quote && text_[at_ + 2] == quote;
  }

  std::string_view text_;
  int most_;
  std::size_t at_ = 0;
  int line_ = 1, dots_ = 0;
  std::vector<int> around_; ///< dots up to each bracket that is open
};

/// The line (from 1) of the first TOML key with more than `most` dots, including those of the keys around it;
/// nothing if there is no such key. Every dot is a table within a table, nested on the stack: a key of
/// 100,000 parts would overflow it. (toml++ bounds brackets itself, keys from version 3.4 on.)
/// Cost  one pass
std::optional<int> line_of_deep_key(std::string_view text, int most) {
  return KeyWalk(text, most).line_of_deep_key();
}

constexpr int deepest_key = 256; // as toml++ limits brackets

constexpr std::size_t most_told = 1000; ///< faults reported per file; one more states that there are others

std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 60;
  if (text.size() <= longest)
    return fmt::format("\"{}\"", text);
  const auto goes_on = [&](std::size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U;
  };
  std::size_t kept = longest;
  // Does not cut inside a UTF-8 character (at most four bytes); table cells may contain any bytes.
  for (int bytes = 1; bytes < 4 && goes_on(kept); ++bytes)
    --kept;
  return fmt::format("\"{}...\"", text.substr(0, kept));
}

std::string describe_array(const toml::array& array) {
  constexpr std::size_t most = 9;
  std::string text = "[";
  for (std::size_t i = 0; i < array.size() && i < most; ++i) {
    text += i > 0 ? ", " : "";
    text += describe(array[i]);
  }
  return text + (array.size() > most ? ", ...]" : "]");
}

std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& candidates) {
  const std::string_view meant = nearest_spelling(word, candidates);
  return meant.empty() ? std::string() : fmt::format(" (did you mean \"{}\"?)", meant);
}

} // namespace

toml::table parse_toml(std::string_view text, const std::string& file) {
  if (const auto line = line_of_deep_key(text, deepest_key)) {
    throw InputError(
        {{file, *line, "", fmt::format("keys of at most {} dots", deepest_key), "a longer one"}});
  }
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    const std::string_view found = error.description();
    const bool is_binary = found.find("utf-8") != std::string_view::npos;
    const bool is_open = found.find("string: unescaped control") != std::string_view::npos;
    throw InputError({{file, static_cast<int>(error.source().begin.line), "",
                       is_binary ? "a TOML file, which is text"
                       : is_open ? "a quote that closes the text on its line"
                                 : "valid TOML",
                       is_binary && text.starts_with("\x1f\x8b") ? "a gzip file"
                       : is_binary                               ? "bytes that are no text"
                       : is_open                                 ? "the end of the line"
                                                                 : std::string(found)}});
  }
}

void FaultList::add(int line, std::string key, std::string expected, std::string found) {
  if (faults_.size() < most_told)
    faults_.push_back({file_, line, std::move(key), std::move(expected), std::move(found)});
  else if (faults_.size() == most_told)
    faults_.push_back({file_, line, "", fmt::format("at most {} faults", most_told), "more"});
}

void FaultList::throw_if_any() {
  if (faults_.empty())
    return;
  std::stable_sort(faults_.begin(), faults_.end(),
                   [](const Fault& a, const Fault& b) { return a.line < b.line; });
  throw InputError(faults_);
}

TableReader::TableReader(const toml::table& table, std::string path, FaultList& faults,
                         std::string_view declared)
    : table_(&table), path_(std::move(path)), faults_(&faults), declared_(declared) {}

const toml::node* TableReader::find(std::string_view key) {
  known_.emplace(key);
  return table_->get(key);
}

const toml::node* TableReader::require(std::string_view key, std::string_view expected) {
  const toml::node* const node = find(key);
  if (!node)
    fault(key, std::string(expected), "nothing");
  return node;
}

std::optional<std::string> TableReader::text(std::string_view key) {
  const toml::node* const node = find(key);
  if (!node)
    return std::nullopt;
  if (const auto* const string = node->as_string())
    return string->get();
  fault(key, "a text in quotes", describe(*node));
  return std::nullopt;
}

std::optional<double> TableReader::quantity(std::string_view key, Dimension dimension) {
  const toml::node* const node = find(key);
  return node ? read_quantity(*node, path_of(key), dimension, *faults_) : std::nullopt;
}

std::optional<std::int64_t> TableReader::integer(std::string_view key, std::int64_t least,
                                                 std::int64_t most) {
  const toml::node* const node = find(key);
  if (!node)
    return std::nullopt;
  const auto* const number = node->as_integer();
  if (number && number->get() >= least && number->get() <= most)
    return number->get();
  const bool has_upper_bound = most < std::numeric_limits<std::int64_t>::max();
  fault(key,
        has_upper_bound ? fmt::format("a whole number from {} to {}", least, most)
                        : fmt::format("a whole number >= {}", least),
        describe(*node));
  return std::nullopt;
}

std::optional<std::string> TableReader::choice(std::string_view key, std::vector<std::string_view> choices) {
  if (choices.empty())
    choices = words(key);
  const toml::node* const node = declared_.empty() || !is_missed(key) ? find(key) : nullptr;
  if (!node)
    return std::nullopt;
  const auto* const string = node->as_string();
  if (string && std::find(choices.begin(), choices.end(), string->get()) != choices.end())
    return string->get();
  fault(key, fmt::format("one of: \"{}\"", fmt::join(choices, "\", \"")),
        describe(*node) + (string ? did_you_mean(string->get(), choices) : ""));
  return std::nullopt;
}

std::optional<std::array<double, 3>> TableReader::quantities(std::string_view key, Dimension dimension,
                                                             bool one_for_all) {
  const toml::node* const node = find(key);
  if (!node)
    return std::nullopt;
  const auto* const list = node->as_array();
  if (!list && one_for_all) {
    const std::optional<double> value = read_quantity(*node, path_of(key), dimension, *faults_);
    return value ? std::optional(std::array{*value, *value, *value}) : std::nullopt;
  }
  if (!list || list->size() != 3) {
    fault(key,
          fmt::format("{} of three, each {}", one_for_all ? "one quantity or a list" : "a list",
                      describe(dimension)),
          describe(*node));
    return std::nullopt;
  }
  std::array<double, 3> values{};
  bool good = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string path = fmt::format("{}[{}]", path_of(key), i);
    const std::optional<double> value = read_quantity((*list)[i], path, dimension, *faults_);
    good = good && value.has_value();
    values[i] = value.value_or(0);
  }
  return good ? std::optional(values) : std::nullopt;
}

const toml::table* TableReader::subtable(std::string_view key) {
  const toml::node* const node = find(key);
  if (!node)
    return nullptr;
  if (!node->is_table())
    fault(key, "a table", describe(*node));
  return node->as_table();
}

void TableReader::finish() {
  const std::vector<std::string_view> known(known_.begin(), known_.end());
  const std::string expected =
      known.empty() ? "no key here" : fmt::format("one of: {}", fmt::join(known, ", "));
  for (const auto& [key, node] : *table_) {
    if (!known_.contains(key.str()) && faults_->size() <= most_told)
      fault(key.str(), expected, "an unknown key" + did_you_mean(key.str(), known));
  }
}

void TableReader::fault(std::string_view key, std::string expected, std::string found) {
  faults_->add(line_of_key(key), path_of(key), std::move(expected), std::move(found));
}

void TableReader::fault(std::string_view key, std::string expected) {
  const toml::node* const node = find(key);
  fault(key, std::move(expected), node ? describe(*node) : "nothing");
}

void TableReader::refuse(std::string_view key, std::string expected) {
  if (find(key))
    fault(key, std::move(expected));
}

int TableReader::line_of_key(std::string_view key) const {
  const auto entry = table_->find(key);
  return entry == table_->end() ? line() : static_cast<int>(entry->first.source().begin.line);
}

std::string TableReader::path_of(std::string_view key) const {
  if (key.empty() || path_.empty())
    return key.empty() ? path_ : std::string(key);
  return fmt::format("{}.{}", path_, key);
}

int TableReader::line() const {
  return line_of(*table_);
}

int line_of(const toml::node& node) {
  return static_cast<int>(node.source().begin.line);
}

std::string describe(const toml::node& node) {
  if (const auto* const string = node.as_string())
    return in_quotes(string->get());
  if (const auto* const integer = node.as_integer())
    return fmt::format("{}", integer->get());
  if (const auto* const number = node.as_floating_point())
    return fmt::format("{}", number->get());
  if (const auto* const truth = node.as_boolean())
    return truth->get() ? "true" : "false";
  if (const auto* const array = node.as_array())
    return describe_array(*array);
  return node.is_table() ? "a table" : "a date or time";
}

std::optional<double> read_quantity(const toml::node& node, const std::string& path, Dimension dimension,
                                    FaultList& faults) {
  std::optional<double> value;
  if (const auto* const string = node.as_string()) {
    value = parse_quantity(string->get(), dimension);
  } else {
    value = node.value<double>(); // an integer or a float; nothing for the rest
    if (node.is_boolean() || (value && !std::isfinite(*value)))
      value.reset();
  }
  if (!value) {
    faults.add(line_of(node), path, describe(dimension), describe(node));
    return std::nullopt;
  }
  return in_units_of_the_file(node, *value, path, dimension, faults);
}

void read_units(TableReader& root) {
  constexpr const char* wanted =
      "a unit of length, of angle, or both: \"mm\", \"mm, deg\" (m, cm, mm, um, nm; rad, deg)";
  const auto text = root.text("units");
  if (!text)
    return;
  FileUnits units;
  for (std::size_t begin = 0; begin <= text->size();) {
    const std::size_t end = std::min(text->find(',', begin), text->size());
    const std::string unit = text->substr(begin, end - begin);
    const bool is_none = parse_quantity("1" + unit, Dimension::dimensionless).has_value(); // "", "0", "%"
    const auto length = is_none ? std::nullopt : parse_quantity("1" + unit, Dimension::length),
               angle = is_none ? std::nullopt : parse_quantity("1" + unit, Dimension::angle);
    std::optional<double>& into = length ? units.length : units.angle;
    if ((!length && !angle) || into) {
      root.fault("units", wanted, describe(*root.find("units")));
      return;
    }
    into = length ? length : angle;
    begin = end + 1;
  }
  root.faults().units = units;
}

} // namespace maille
