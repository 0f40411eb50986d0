#pragma once
/// The parser for JSON files. Nesting is limited, because nlohmann/json copies, compares and prints nested
/// values by recursion. Keys are stored without the linear search of its ordered objects, so time is linear
/// in the text. Memory is at most about 30 times the text.

#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille {

/// Builds the value of a text from the parser's events.
class JsonBuilder final : public nlohmann::json_sax<nlohmann::ordered_json> {
public:
  using Json = nlohmann::ordered_json;
  static constexpr int deepest = 64; ///< levels of brackets; Maille writes fewer than ten

  /// @param line first line of the text in the file @throws InputError: file, line, and cause
  static Json parse(std::string_view text, const std::filesystem::path& file, int line) {
    JsonBuilder builder;
    const std::size_t deep = first_too_deep(text);
    if (deep == text.size() && Json::sax_parse(text.begin(), text.end(), &builder))
      return std::move(builder.root_);
    std::string expected = "JSON", found = builder.at_ > text.size() ? "its end" : builder.found_;
    if (deep < text.size()) {
      builder.at_ = deep + 1;
      expected = "JSON of at most " + std::to_string(deepest) + " brackets inside each other";
      found = "more";
    } else if (!builder.repeated_.empty()) {
      expected = "each key of an object once";
      found = "\"" + builder.repeated_.substr(0, 60) + "\" again";
    }
    const std::string_view before = text.substr(0, builder.at_ > 0 ? builder.at_ - 1 : 0);
    if (builder.at_ > 0)
      found += " at character " + std::to_string(before.size() - (before.rfind('\n') + 1) + 1);
    line += static_cast<int>(std::ranges::count(before, '\n'));
    throw InputError({{file.string(), builder.at_ > 0 ? line : 0, "", expected, found}});
  }

  // Events of the parser.
  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override { return add(value); }
  bool number_float(number_float_t value, const string_t& /*text*/) override { return add(value); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t& /*value*/) override { return false; }
  bool key(string_t& value) override {
    key_ = std::move(value);
    return true;
  }
  bool start_object(std::size_t /*size*/) override { return add(Json::object(), true); }
  bool start_array(std::size_t /*size*/) override { return add(Json::array(), true); }
  bool end_array() override {
    open_.pop_back();
    return true;
  }
  bool end_object() override {
    std::vector<std::string_view> keys;
    for (const auto& [key, value] : open_.back()->items())
      keys.push_back(key);
    std::ranges::sort(keys);
    if (const auto twice = std::ranges::adjacent_find(keys); twice != keys.end())
      repeated_ = *twice;
    return end_array() && repeated_.empty();
  }
  bool parse_error(std::size_t at, const std::string& token, const nlohmann::detail::exception&) override {
    at_ = at;
    found_ = "\"" + token.substr(0, 60) + "\"";
    return false;
  }

private:
  /// Position of the first bracket that is nested too deep; the text's size if none exists.
  static std::size_t first_too_deep(std::string_view text) {
    int depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i)
      if (text[i] == '"')
        in_string = !in_string;
      else if (in_string)
        i += text[i] == '\\' ? 1 : 0;
      else if (text[i] == '[' || text[i] == '{') {
        if (++depth > deepest)
          return i;
      } else if (text[i] == ']' || text[i] == '}')
        --depth;
    return text.size();
  }

  bool add(Json value, bool is_open = false) {
    Json* added = &root_;
    if (open_.empty())
      root_ = std::move(value);
    else if (auto& outer = *open_.back(); outer.is_array())
      added = &outer.get_ref<Json::array_t&>().emplace_back(std::move(value));
    else
      added = &outer.get_ref<Json::object_t&>().emplace_back(std::move(key_), std::move(value)).second;
    if (is_open)
      open_.push_back(added);
    return true;
  }

  Json root_;
  std::vector<Json*> open_; ///< containers around the next value
  string_t key_;
  std::size_t at_ = 0; ///< characters up to the error
  std::string found_, repeated_;
};

/// @param line first line of the text, for files with several texts
inline nlohmann::ordered_json parse_json(std::string_view text, const std::filesystem::path& file,
                                         int line = 1) {
  return JsonBuilder::parse(text, file, line);
}

/// An entry of an object; null if the value is no object or has no such entry.
inline const nlohmann::ordered_json& json_entry(const nlohmann::ordered_json& object, std::string_view key) {
  static const nlohmann::ordered_json none;
  const auto entry = object.is_object() ? object.find(std::string(key)) : object.end();
  return entry == object.end() ? none : *entry;
}

} // namespace maille
