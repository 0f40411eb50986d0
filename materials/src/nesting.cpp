#include "nesting.hpp"

#include <algorithm>
#include <vector>

namespace maille {

namespace {

/// Walks over TOML as its lexer would; what is no TOML is for the parser to refuse.
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
  /// From behind its first quote to behind its last.
  void skip_string(char quote) {
    const bool is_long = text_.substr(at_, 2) == std::string_view(quote == '"' ? "\"\"" : "''");
    at_ += is_long ? 2 : 0;
    for (; at_ < text_.size() && (is_long || text_[at_] != '\n'); ++at_) {
      line_ += text_[at_] == '\n';
      if (quote == '"' && text_[at_] == '\\') {
        ++at_; // what follows is no end
        line_ += at_ < text_.size() && text_[at_] == '\n';
      } else if (text_[at_] == quote && (!is_long || is_end(quote))) {
        at_ += is_long ? 3 : 1;
        for (int more = 0; is_long && more < 2 && at_ < text_.size() && text_[at_] == quote; ++more)
          ++at_; // up to two quotes before the last three are the string's own
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

} // namespace

std::optional<int> line_of_deep_key(std::string_view text, int most) {
  return KeyWalk(text, most).line_of_deep_key();
}

} // namespace maille
